"""Meeting: the configurations nearest to others that meet the poses of a curve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...ik.searches import searched
from ...ik.targets import AnyTarget, Pose
from ...ik.task_space import Tolerances
from ...support.checks import Array
from .moving_target import MovingTarget
from .nodes import ALL_BUT_EXACT, EXACT, LONGEST_JUMP
from .projection import projected

Met = tuple[Array, NDArray[np.bool_]]
"""Configurations (k, n), and which of them meet their targets (k,)."""


def met_near(
    arm: Arm,
    moving: MovingTarget,
    ideal: Array,
    near: Array,
    closed_form: Callable[[MovingTarget, Array, Array], Met | None] | None = None,
) -> Met:
    """Configurations near `near` (k, n) for the targets at poses `ideal` (k, 4, 4), and which are met.

    They meet targets exactly where possible, so that a spline through them is smooth. With wide tolerances, the nearest
    configuration within them comes first. A search within tolerances comes last. `closed_form` replaces the search for
    exact configurations where it applies.
    """

    def exactly(arm: Arm, moving: MovingTarget, ideal: Array, near: Array) -> Met:
        found = None if closed_form is None else closed_form(moving, ideal, near)
        return _searched(arm, moving, ideal, near, ALL_BUT_EXACT) if found is None else found

    theta, met = near.copy(), np.zeros(len(near), dtype=bool)
    for solve in (*([_without_leap] if moving.leeway else []), exactly, _within):
        left = np.flatnonzero(~met)
        found, good = solve(arm, moving, ideal[left], near[left])
        theta[left[good]], met[left[good]] = found[good], True
        if met.all():
            break
    return theta, met


def _without_leap(arm: Arm, moving: MovingTarget, ideal: Array, near: Array) -> Met:
    theta, met = projected(arm, moving.like, ideal, near, EXACT, moving.tolerances)
    return theta, met & (np.abs(theta - near).max(axis=1) <= LONGEST_JUMP)


def _within(arm: Arm, moving: MovingTarget, ideal: Array, near: Array) -> Met:
    return _searched(arm, moving, ideal, near, moving.tolerances)


def _searched(arm: Arm, moving: MovingTarget, ideal: Array, near: Array, met: Tolerances) -> Met:
    found = searched(arm, targets_at(moving.like, ideal), near, met)
    return found.theta, found.converged


def targets_at(like: AnyTarget, ideal: Array) -> Array | list[AnyTarget]:
    """Return targets like that one at poses (k, 4, 4), in the form that `searched` takes."""
    return ideal if isinstance(like, Pose) else [like.at(each) for each in ideal]
