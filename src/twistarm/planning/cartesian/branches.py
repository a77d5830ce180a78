"""Branches: the configurations in which an arm meets a target, from many starts."""

from __future__ import annotations

import numpy as np

from ...ik.batch import solve_ik_batch
from ...ik.targets import AnyTarget
from ...model.arm import Arm
from ...support.checks import Array
from .nodes import EXACT

STARTS = 96
"""Searches from random starts, beside the one from where the arm is."""

APART = 0.02
"""Configurations nearer together than this [rad, m] in every joint are one; branches may come near each other."""

SEED = 0


def branches(arm: Arm, target: AnyTarget, near: Array) -> Array:
    """Configurations (b, n) that meet the target, b ≥ 0, nearest to `near` (n,) first.

    One search from `near`, others from random starts, each alone; of answers that are close together the nearest is
    kept. Joints that may turn for more than a turn are given by the windings their limits allow.
    """
    starts = np.vstack([near, arm.random_theta(SEED, STARTS)])
    found = solve_ik_batch(arm, [target] * len(starts), starts, position_tol=EXACT, orientation_tol=EXACT, restarts=1)
    first = solve_ik_batch(arm, [target], near[None], position_tol=EXACT, orientation_tol=EXACT, posture="theta0")
    met = np.vstack([first.theta[first.converged], found.theta[found.converged]])
    met = _windings(arm, met)
    left = met[np.argsort(np.linalg.norm(met - near, axis=1), kind="stable")]
    kept: list[Array] = []
    while len(left):
        kept.append(left[0])
        left = left[np.abs(left - left[0]).max(axis=1) > APART]
    return np.array(kept).reshape(-1, arm.n)


def _windings(arm: Arm, thetas: Array) -> Array:
    """The same, and each with one joint a whole turn on or back, where its limits allow."""
    more = [thetas]
    for joint, unit in enumerate(arm.units):
        if unit != "rad" or not np.isfinite(arm.limits.upper[joint] - arm.limits.lower[joint]):
            continue
        for turn in (-2.0 * np.pi, 2.0 * np.pi):
            turned = thetas.copy()
            turned[:, joint] += turn
            more.append(turned[arm.limits.contains(turned)])
    return np.vstack(more)
