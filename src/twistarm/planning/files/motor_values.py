"""Positions, velocities and counts of an arm's motors, which files hold beside the joints."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...limits.actuators import Actuators
from ...support.checks import Array, require
from ...support.errors import InputError

if TYPE_CHECKING:
    from ..trajectory import Trajectory


def motors_of(trajectory: Trajectory, actuators: Actuators | None) -> Actuators | None:
    """Return the motors to write: those given, else those of the planned arm, else None."""
    motors = trajectory.actuators
    if actuators is not None:
        motors = require(actuators, Actuators, "actuators", "as arm.actuators is")
    return motors if motors is not None and motors.names else None


def require_motors(motors: Actuators | None) -> Actuators:
    """Return the motors. Raises InputError for None."""
    if motors is None:
        raise InputError("this trajectory knows no motors: give actuators=, or plan for an arm with [actuators]")
    return motors


def motor_values(trajectory: Trajectory, motors: Actuators, t: Array) -> list[Array]:
    """Position and velocity of the k motors at t (m,), then both in counts: four arrays (m, k)."""
    moved = trajectory.to_motors(motors)
    turned = [moved(t), moved(t, 1)]
    return [*turned, *map(motors.to_counts, turned)]


def counted(trajectory: Trajectory, motors: Actuators) -> Trajectory:
    """Return the motion of the motors in what their drives count."""
    moved, scale = trajectory.to_motors(motors), motors.counts_per_unit
    waypoints, coefficients = moved.waypoints * scale, moved.coefficients * scale
    return replace(moved, units=motors.units, waypoints=waypoints, coefficients=coefficients)
