"""What files hold of a motion: points of its joints, and the values of its motors."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...limits.actuators import Actuators
from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from ..trajectory import Trajectory


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


def motor_values(trajectory: Trajectory, motors: Actuators, t: Array) -> list[Array]:
    """Position and velocity of the k motors at t (m,), then both in counts: four arrays (m, k)."""
    moved = trajectory.to_motors(motors)
    turned = [moved(t), moved(t, 1)]
    return [*turned, *map(motors.to_counts, turned)]
