"""The shortest quintic spline through waypoints, by SciPy: linear programs in a trust region, from many starts."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline
from scipy.optimize import linprog

LOOKS, STEPS = 33, 120
"""Places in each segment at which rates are looked at, and linear programs from each start."""

NUDGE = 1e-6
"""Of the logarithm of a duration, for differences."""


def spline(points: np.ndarray, durations: np.ndarray) -> BSpline:
    """The C⁴ quintic, at rest at both ends and without acceleration there."""
    still = [(1, np.zeros(points.shape[1])), (2, np.zeros(points.shape[1]))]
    return make_interp_spline(np.append(0.0, np.cumsum(durations)), points, k=5, bc_type=(still, still))


def slowing(points: np.ndarray, x: np.ndarray, asked: dict[str, Any], looks: int = LOOKS) -> np.ndarray:
    """Logarithms of the factors by which each rate slows the motion with durations exp(x), at `looks` places each."""
    durations = np.exp(x)
    curve = spline(points, durations)
    ends = np.cumsum(durations)
    t = ((ends - durations)[:, None] + durations[:, None] * np.linspace(0.0, 1.0, looks)).ravel()
    t = np.minimum(t, ends[-1] * (1.0 - 1e-13))
    speed, force = np.abs(curve(t, 1)) / asked["velocity"], np.abs(curve(t, 2)) / asked["acceleration"]
    return np.log(np.maximum(np.concatenate([speed.ravel(), np.sqrt(force).ravel()]), 1e-9))


def descended(points: np.ndarray, x: np.ndarray, asked: dict[str, Any]) -> tuple[float, np.ndarray]:
    """The least time near x, and the logarithms of its durations."""
    reach, now = 0.3, slowing(points, x, asked)
    x, now, best = x + now.max(), now - now.max(), float(np.exp(x).sum() * np.exp(now.max()))
    for _ in range(STEPS):
        near = np.flatnonzero(now > -6.0 * reach - 0.05)
        nudged = [slowing(points, x + NUDGE * axis, asked)[near] - now[near] for axis in np.eye(len(x))]
        ways = [(-reach, reach)] * len(x)
        step = linprog(np.exp(x - x.max()), A_ub=np.transpose(nudged) / NUDGE, b_ub=-now[near], bounds=ways)
        after = slowing(points, x + step.x, asked) if step.status == 0 else np.full(1, np.inf)
        time = float(np.exp(x + step.x).sum() * np.exp(after.max())) if step.status == 0 else np.inf
        if time < best * (1.0 - 1e-9):
            gain, best, reach = 1.0 - time / best, time, min(1.5 * reach, 0.5)
            x, now = x + step.x + after.max(), after - after.max()
            if gain < 1e-6:
                break
        else:
            reach *= 0.4
            if reach < 1e-5:
                break
    return best, x


def fastest_quintic(asked: dict[str, Any]) -> float:
    """The least time [s] found from as many starts as were asked for."""
    random, points = np.random.default_rng(0), np.array(asked["waypoints"])
    way = np.abs(np.diff(points, axis=0))
    least = np.log(np.maximum(way / asked["velocity"], np.sqrt(way / asked["acceleration"])).max(1))
    starts = [least * random.uniform() + random.normal(0.0, 0.5, len(way)) for _ in range(asked["starts"] - 1)]
    _, x = min((descended(points, start, asked) for start in [least, *starts]), key=lambda found: found[0])
    return float(np.exp(x).sum() * np.exp(slowing(points, x, asked, 401).max()))
