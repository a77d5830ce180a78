"""A ball in two sockets: how still it stands and how far apart the two are, on placements that were not fitted.

Beside ours stands the objective of MUKCa (Franzese et al. 2025, arXiv 2503.12584), solved by SciPy: the origins of
all joints and of the ball, 6 numbers each, with the means of the predicted balls, their distance, and a ridge.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from twistarm import Arm
from twistarm.calibration import Measurements, calibrate
from twistarm.theory.rotations import exp as turn
from twistarm.theory.rotations import from_rpy, to_rpy

Array = np.ndarray[Any, np.dtype[np.float64]]
Placements = dict[str, list[Array]]

APART, RIDGE = 0.05, 1e-4


def placements(folder: Path) -> Placements:
    """{placement: theta (K, n) in each of the two sockets}."""
    return {
        place.name: [np.loadtxt(place / f"hole_{k}.csv", delimiter=",") for k in (0, 1)]
        for place in sorted(folder.iterdir())
    }


def spread(balls: list[Array]) -> tuple[float, float]:
    """The mean distance of the balls from their socket's mean, and the error of the distance of the two means [m]."""
    means = [p.mean(axis=0) for p in balls]
    off = np.concatenate([np.linalg.norm(p - mean, axis=1) for p, mean in zip(balls, means, strict=True)])
    return float(off.mean()), float(abs(np.linalg.norm(means[0] - means[1]) - APART))


def ours(arm: Arm, data: Placements, fitted: tuple[str, ...]) -> Any:
    theta = np.vstack([rows for name in fitted for rows in data[name]])
    points = [f"{name} {k}" for name in fitted for k in (0, 1) for _ in data[name][k]]
    apart = {(f"{name} 0", f"{name} 1"): APART for name in fitted}
    return calibrate(arm, Measurements(theta, point=points), distances=apart).predict


def theirs(arm: Arm, data: Placements, fitted: tuple[str, ...]) -> Any:
    assert arm.description is not None
    chain = arm.description.chain(arm.base, arm.tip_link)
    nominal = np.array([np.r_[joint.origin[:3, 3], to_rpy(joint.origin[:3, :3])] for joint in chain])
    free = [i for i, joint in enumerate(chain) if joint.moving or i == len(chain) - 1]

    def balls(origins: Array, theta: Array) -> Array:
        p, R, columns = np.zeros((len(theta), 3)), np.tile(np.eye(3), (len(theta), 1, 1)), iter(theta.T)
        for joint, origin in zip(chain, origins, strict=True):
            p, R = p + R @ origin[:3], R @ from_rpy(origin[3:])
            if joint.moving:
                R = R @ turn(next(columns)[:, None] * joint.twist[3:])
        return p

    def moved(values: Array) -> Array:
        origins = nominal.copy()
        origins[free] = values.reshape(-1, 6)
        return origins

    def residual(values: Array) -> Array:
        origins, parts = moved(values), []
        for name in fitted:
            both = [balls(origins, rows) for rows in data[name]]
            means, count = [p.mean(axis=0) for p in both], sum(map(len, both))
            parts += [((p - mean) / np.sqrt(count)).ravel() for p, mean in zip(both, means, strict=True)]
            parts.append(np.array([np.linalg.norm(means[0] - means[1]) - APART]))
        parts.append(np.sqrt(len(fitted) * RIDGE) * (origins - nominal)[free[:-1]].ravel())
        return np.concatenate(parts)

    found = least_squares(residual, nominal[free].ravel(), xtol=1e-12, ftol=1e-12, gtol=1e-14, max_nfev=60)
    return lambda theta: balls(moved(found.x), theta)
