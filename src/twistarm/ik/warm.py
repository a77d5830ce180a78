"""A target near the pose of theta0: its answer is wanted near theta0, or it is to be said that it is not."""

from __future__ import annotations

import math

import numpy as np

from ..arm import Arm
from ..checks import Array
from .damped import Search, Tolerances, search
from .ranges import JointRanges
from .task_space import Target

NEAR_POSITION, NEAR_ORIENTATION = 0.01, math.radians(1.0)
"""Up to here [m, rad] a target is near the pose of theta0."""

FAR = 0.2
"""A coordinate that moves by more [rad, m] than this toward such a target has left the branch of theta0."""

CAREFUL_STEP, CAREFUL_ITERATIONS = 0.05, 200
"""Longest step of a coordinate [rad, m] in a search that is to stay on its branch, and how many it may take."""


def near_pose(arm: Arm, target: Target, start: Array) -> bool:
    """Whether the target is within 1 cm and 1° of the pose of `start` (n,)."""
    g = arm.fk(start)
    return target.position_error(g) <= NEAR_POSITION and target.orientation_error(g) <= NEAR_ORIENTATION


def moves_far(theta: Array, start: Array) -> bool:
    """Whether a coordinate is farther than `FAR` from where it began."""
    return bool(np.abs(theta - start).max() > FAR)


def branch_kept(arm: Arm, target: Target, start: Array, ranges: JointRanges, tolerances: Tolerances) -> Search | None:
    """A careful search from `start` that meets the target on its branch; None where it does not."""
    bounds = ranges.search_lower, ranges.search_upper
    found = search(arm, target, start, bounds, tolerances, CAREFUL_ITERATIONS, CAREFUL_STEP)
    return found if found.converged and not moves_far(found.theta, start) else None
