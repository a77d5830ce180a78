"""Positions, velocities and counts of an arm's motors, which files hold beside the joints."""

from __future__ import annotations

from dataclasses import replace

from ...limits.actuators import Actuators
from ...support.checks import Array
from ..trajectory import Trajectory


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
