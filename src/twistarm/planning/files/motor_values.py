"""Positions, velocities and counts of an arm's motors along a motion, which every file has beside its joints."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...limits.actuators import Actuators
from ...support.checks import Array, require
from ...support.errors import InputError

if TYPE_CHECKING:
    from ..trajectory import Trajectory


def motors_of(trajectory: Trajectory, actuators: Actuators | None) -> Actuators | None:
    """The motors to write: those given, else those of the arm that was planned for, if it has any."""
    motors = trajectory.actuators
    if actuators is not None:
        motors = require(actuators, Actuators, "actuators", "as arm.actuators is")
    return motors if motors is not None and motors.names else None


def require_motors(motors: Actuators | None) -> Actuators:
    """The motors, or InputError where there are none."""
    if motors is None:
        raise InputError("this trajectory knows no motors: give actuators=, or plan for an arm with [actuators]")
    return motors


def motor_values(trajectory: Trajectory, motors: Actuators, t: Array) -> list[Array]:
    """Where the motors are and how fast they turn at t (m,), in rad or m, then as their drives count: (m, k) each."""
    moved = trajectory.of_motors(motors)
    turned = [moved(t), moved(t, 1)]
    return [*turned, *map(motors.to_counts, turned)]


def counted(trajectory: Trajectory, motors: Actuators) -> Trajectory:
    """The motion in what the motors' drives count, as a trajectory of the motors."""
    moved, scale = trajectory.of_motors(motors), motors.counts_per_unit
    waypoints, coefficients = moved.waypoints * scale, moved.coefficients * scale
    return replace(moved, units=motors.units, waypoints=waypoints, coefficients=coefficients)
