"""Inverse kinematics with a scene: the nearest free configuration that meets the target."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from .answer import record_type
from .deadline import Deadline
from .ranges import joint_ranges
from .solution import IKResult

if TYPE_CHECKING:
    from ..collision import Scene

SPREADS = (0.3, 1.0, np.inf, np.inf, np.inf, np.inf, np.inf, np.inf)
"""Widths [rad, m] of the starts about theta0 in each round of searches; inf for the whole range."""

SEARCHES = 64
"""Searches of each round."""

Solve = Callable[..., IKResult]
"""`solve_ik`."""


def collision_free(scene: Scene, first: IKResult, solve: Solve, deadline: Deadline) -> IKResult:
    """The nearest free configuration that meets the target of `first`, or `first` with its contacts.

    `first` meets the target and collides. Searches start near theta0, then at random configurations.
    """
    arm, start, met = first.arm, first.record["theta0"], first.tolerances.keywords
    for candidates in _rounds(arm, first, start):
        near = candidates[np.argsort(np.linalg.norm(candidates - start, axis=1), kind="stable")]
        for theta in near[~scene.collides(near)] if len(near) else ():
            found = solve(arm, first.target, theta, **met, max_time=deadline.left)
            if found.converged and not scene.collides(found.theta):
                found._avoided = f"the configuration nearest to theta0 collides: {scene.contacts(first.theta)[0]}"
                return found
        if deadline.passed:
            break
    first._contacts = scene.contacts(first.theta)
    return first


def _rounds(arm: Arm, first: IKResult, start: Array) -> Iterator[Array]:
    """Configurations (k, n) that meet the target, several at a time."""
    met, chain, target = first.tolerances, arm.require_core("solve_ik with a scene"), first.target
    numbers = np.repeat(target.numbers[None], SEARCHES, axis=0)
    rng, ranges = np.random.default_rng(0), joint_ranges(arm)
    for spread in SPREADS:
        starts = arm.random_theta(rng, SEARCHES)
        if np.isfinite(spread):
            starts = np.array([ranges.inside(start + rng.normal(0.0, spread, arm.n)) for _ in range(SEARCHES)])
        found = np.empty(SEARCHES, record_type(arm.n))
        how = met.position, met.orientation, 1, 0, None, None, 1, None
        assert chain.solve_batch(target.kind, numbers, starts, *how, found), "the target and the starts are plain"
        theta = found["theta"][found["stop"] == 0]
        yield np.array([ranges.wrapped(each, start) for each in theta]).reshape(-1, arm.n)
