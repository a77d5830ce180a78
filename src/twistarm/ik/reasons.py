"""Why a target cannot be met: the limits, a direction the arm has no joint for, or its reach."""

from __future__ import annotations

import numpy as np

from ..arm import Arm
from ..checks import Array
from .damped import Tolerances
from .deadline import Deadline
from .race import race
from .ranges import joint_ranges
from .solution import StopReason
from .starts import random_start
from .task_space import Target, constrained

UNLIMITED_RESTARTS = 48
"""Searches without limits before the limits are found not to be the reason."""

RANK_SAMPLES = 16
"""Random configurations among which the rank of a task is the largest; almost every one has it."""

RANK_TOL = 1e-6
"""Singular values below this, relative to the largest, are directions the arm cannot move in."""


def without_limits(
    arm: Arm, target: Target, theta: Array, tolerances: Tolerances, seed: int, deadline: Deadline
) -> Array | None:
    """A configuration (n,) that meets the target if the arm had no position limits, or None; searched from theta on."""
    ranges = joint_ranges(arm, limited=False)
    winner = race(
        arm, target, theta, ranges, tolerances, restarts=UNLIMITED_RESTARTS, seed=seed, deadline=deadline
    ).winner
    return None if winner is None else joint_ranges(arm).toward(winner.theta)


def reason(
    arm: Arm, target: Target, tolerances: Tolerances, position_error: float, orientation_error: float
) -> StopReason:
    """Why the nearest configuration, with these errors, is no answer, though limits are not to blame."""
    impossible = position_error <= tolerances.position and orientation_error > tolerances.orientation
    if impossible and task_rank(arm, target) < constrained(target):
        return StopReason.IMPOSSIBLE_DIRECTION
    return StopReason.OUT_OF_REACH


def task_rank(arm: Arm, target: Target) -> int:
    """In how many of the target's components the arm can move its tool, in almost every configuration that meets it.

    The largest rank, over random configurations, of the rows of a target of the same kind that is met there.
    """
    ranges = joint_ranges(arm)
    ranks = []
    for k in range(RANK_SAMPLES):
        g, J_b = arm.fk_and_body_jacobian(random_start(ranges, 0, k))
        met = target.at(g)
        rows = np.concatenate([met.position_rows(g, J_b)[1] / arm.reach, met.rotation_rows(g, J_b)[1]])
        singular_values = np.linalg.svd(rows, compute_uv=False)
        ranks.append(int((singular_values > RANK_TOL * singular_values[0]).sum()))
    return max(ranks)
