"""The points of a motion as a file holds them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...limits.joint_limits import JointLimits
from ...support.checks import Array


class Points(NamedTuple):
    """k instants t (k,) [s] of n joints (k, n). Rates, accelerations and the planner's limits are optional.

    `place(i)` tells the place of point i in the file.
    """

    t: Array
    labels: list[tuple[float, str]]
    place: Callable[[int], str]
    limits: JointLimits | None
    theta: Array
    theta_dot: Array | None = None
    theta_ddot: Array | None = None
