"""Branches: all configurations that meet a target."""

from __future__ import annotations

import numpy as np

from ...arm.arm import Arm
from ...ik.answer import Configurations
from ...ik.closed_form.methods import family_method
from ...ik.ranges import joint_ranges
from ...ik.searches import searched
from ...ik.targets import AnyTarget
from ...ik.task_space import USUAL, Tolerances
from ...support.checks import Array
from ..tolerances import are_wide
from .projection import ALL_BUT_EXACT, EXACT

MANY = 96
"""Searches from random starts, besides the one from the arm's configuration; also the most closed-form answers."""

FREE_VALUES = 12
"""Values tried for the turn about an approach's axis, and for each joint that changes no other."""

DISTINCT = 0.02
"""Configurations nearer together than this [rad, m] in every joint are one. Branches may come close to each other."""

SEED = 0


def branches(arm: Arm, target: AnyTarget, near: Array, tolerances: Tolerances = USUAL) -> Array:
    """Return configurations (b, n) that meet the target, b ≥ 0, nearest to `near` (n,) first.

    The closed form of the arm's family gives them, with random values for free joints. Without a closed form, or for a
    continuous family, searches from random starts find them. Of close answers the nearest stays. Joints with room for
    whole turns give all their windings. Tolerances are used if wide, or if no configuration meets the target exactly.
    """
    starts = np.vstack([near, arm.random_theta(SEED, MANY)])
    met, all_found = _by_closed_form(arm, target, starts)
    if not all_found:
        met = np.vstack([_nearest(arm, target, near), met, _by_searches(arm, target, starts, ALL_BUT_EXACT)])
    if not len(met) or are_wide(tolerances):
        met = np.vstack([met, _by_searches(arm, target, starts, tolerances)])
    met = joint_ranges(arm).wrapped(met, near)
    return _in_order(_windings(arm, _distinct(_in_order(met, near))), near)


def _by_closed_form(arm: Arm, target: AnyTarget, starts: Array) -> tuple[Array, bool]:
    """Return configurations (k, n), and whether nothing is left to search for.

    Held joints take their values from `starts`. Of more than `MANY` the nearest half stays, and others evenly.
    """
    method = family_method(arm, target)
    if method.core is None:
        return starts[:0], False
    held = list(method.held)
    values = np.ascontiguousarray(starts[: None if method.swept else FREE_VALUES, held]) if held else None
    answer = method.core.solve(target.numbers, np.array(starts[0]), values, EXACT, EXACT)
    assert answer is not None, "what was checked is plain"
    found = Configurations(*answer)
    theta, moving = found.theta[: found.inside], found.moves[: found.inside]
    moving[:, held] = False
    if len(theta) > MANY:
        theta = theta[np.append(np.arange(MANY // 2), np.linspace(MANY // 2, len(theta) - 1, MANY // 2).astype(int))]
    if held:
        theta = np.vstack([_nearest(arm, target, starts[0]), theta])
    return theta, not found.left and not moving.any()


def _by_searches(arm: Arm, target: AnyTarget, starts: Array, met: Tolerances) -> Array:
    """Return what searches from each of the starts find, (k, n)."""
    return searched(arm, [target] * len(starts), starts, met).met


def _nearest(arm: Arm, target: AnyTarget, near: Array) -> Array:
    """Return the configuration nearest to `near` that meets the target, (1, n), or none."""
    return searched(arm, [target], near[None], ALL_BUT_EXACT, restarts=100, posture="theta0").met


def _in_order(thetas: Array, near: Array) -> Array:
    """Sort configurations, nearest first."""
    return thetas[np.argsort(np.linalg.norm(thetas - near, axis=1), kind="stable")]


def _distinct(thetas: Array) -> Array:
    """Drop configurations close to an earlier one."""
    left = thetas
    kept: list[Array] = []
    while len(left):
        kept.append(left[0])
        left = left[np.abs(left - left[0]).max(axis=1) > DISTINCT]
    return np.array(kept).reshape(-1, thetas.shape[1])


def _windings(arm: Arm, thetas: Array) -> Array:
    """Add each configuration with one joint a whole turn on or back, inside its limits."""
    more = [thetas]
    for joint, unit in enumerate(arm.units):
        if unit != "rad" or not np.isfinite(arm.limits.upper[joint] - arm.limits.lower[joint]):
            continue
        for turn in (-2.0 * np.pi, 2.0 * np.pi):
            turned = thetas.copy()
            turned[:, joint] += turn
            more.append(turned[arm.limits.contains(turned)])
    return np.vstack(more)
