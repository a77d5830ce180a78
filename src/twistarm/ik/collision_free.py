"""Inverse kinematics with a scene: the nearest free configuration that meets the target."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from .batch import solve_ik_batch
from .ranges import joint_ranges
from .solution import IKResult

if TYPE_CHECKING:
    from ..collision import Scene

SPREADS = (0.3, 1.0, np.inf, np.inf, np.inf, np.inf, np.inf, np.inf)
"""Widths [rad, m] of the starts about theta0 in each round of searches; inf for the whole range."""

SEARCHES = 64
"""Searches of each round."""


def collision_free(
    arm: Arm, scene: Scene, first: IKResult, solve: Callable[[Array], IKResult], max_time: float | None
) -> IKResult:
    """The nearest free configuration that meets the target of `first`, or `first` with its contacts.

    `first` meets the target and collides. Searches start near theta0, then at random configurations.
    `solve(theta)` is the call of `solve_ik` from another start.
    """
    start = first._answer.theta0
    ends = np.inf if max_time is None else time.monotonic() + max_time
    for candidates in _rounds(arm, first, start):
        near = candidates[np.argsort(np.linalg.norm(candidates - start, axis=1), kind="stable")]
        for theta in near[~scene.collides(near)] if len(near) else ():
            found = solve(theta)
            if found.converged and not scene.collides(found.theta):
                found._avoided = f"the configuration nearest to theta0 collides: {scene.contacts(first.theta)[0]}"
                return found
        if time.monotonic() > ends:
            break
    first._contacts = scene.contacts(first.theta)
    return first


def _rounds(arm: Arm, first: IKResult, start: Array) -> Iterator[Array]:
    """Configurations (k, n) that meet the target, several at a time."""
    tolerances = first.tolerances
    asked: dict[str, Any] = {"position_tol": tolerances.position, "orientation_tol": tolerances.orientation}
    rng, ranges = np.random.default_rng(0), joint_ranges(arm)
    for spread in SPREADS:
        starts = arm.random_theta(rng, SEARCHES)
        if np.isfinite(spread):
            starts = np.array([ranges.inside(start + rng.normal(0.0, spread, arm.n)) for _ in range(SEARCHES)])
        found = solve_ik_batch(arm, [first.target] * SEARCHES, starts, restarts=1, **asked)
        met = found.theta[found.converged]
        yield np.array([ranges.wrapped(theta, start) for theta in met]).reshape(-1, arm.n)
