"""A trajectory, its motors too, as the text of a file: CSV for people and plots, JSON as ROS's JointTrajectory."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array
from ..support.csv_lines import csv_text as lines_of
from ..support.errors import InputError

if TYPE_CHECKING:
    from .trajectory import Trajectory

RATES = ("position", "velocity", "acceleration")
CSV_UNITS = ("", "/s", "/s^2")
"""In ASCII: spreadsheets guess at anything else."""

NANOSECOND = 1e-9


def csv_text(trajectory: Trajectory, dt: float, actuators: Actuators | None = None) -> str:
    """What `Trajectory.to_csv` writes."""
    samples = trajectory.sample(dt)
    values = [np.stack(samples[1:], axis=-1)]
    columns = ["time [s]", *_joint_columns(trajectory)]
    if motors := _motors_of(trajectory, actuators):
        values.append(np.stack(list(_motor_values(trajectory, motors, dt).values()), axis=-1))
        columns += _motor_columns(motors)
    rows = len(samples.t)
    table = np.column_stack([samples.t, *(each.reshape(rows, -1) for each in values)])
    return lines_of(columns, table.tolist())


def json_text(trajectory: Trajectory, dt: float, actuators: Actuators | None = None) -> str:
    """What `Trajectory.to_json` writes."""
    samples = trajectory.sample(dt)
    nanoseconds = np.rint(samples.t / NANOSECOND).astype(np.int64)
    if not (np.diff(nanoseconds) > 0).all():
        raise InputError(f"dt = {dt:g} s is too short for JointTrajectory, which counts time in nanoseconds")
    points = [
        {
            "positions": theta.tolist(),
            "velocities": theta_dot.tolist(),
            "accelerations": theta_ddot.tolist(),
            "time_from_start": {"sec": int(ns // 10**9), "nanosec": int(ns % 10**9)},
        }
        for ns, theta, theta_dot, theta_ddot in zip(nanoseconds, *samples[1:], strict=True)
    ]
    message: dict[str, Any] = {"joint_names": list(trajectory.joint_names), "points": points}
    if motors := _motors_of(trajectory, actuators):
        message["motors"] = _motors_message(trajectory, motors, dt)
    return json.dumps(message, indent=1, allow_nan=False) + "\n"


def _joint_columns(trajectory: Trajectory) -> list[str]:
    return [
        f"{name}.{rate} [{unit}{per}]"
        for name, unit in zip(trajectory.joint_names, trajectory.units, strict=True)
        for rate, per in zip(RATES, CSV_UNITS, strict=True)
    ]


# -- motors ------------------------------------------------------------------------------------------------------


def _motors_of(trajectory: Trajectory, actuators: Actuators | None) -> Actuators | None:
    """The motors to write: those given, else those of the arm that was planned for, if it has any."""
    motors = trajectory.actuators if actuators is None else actuators
    return motors if motors is not None and motors.names else None


def _motor_values(trajectory: Trajectory, motors: Actuators, dt: float) -> dict[str, Array]:
    """Where the motors are and how fast they turn, in rad or m and as their drives count, each (m, k)."""
    _, motor, motor_dot, _ = trajectory.of_motors(motors).sample(dt)
    return {
        "motor_position": motor,
        "motor_velocity": motor_dot,
        "counts": motors.to_counts(motor),
        "counts_rate": motors.to_counts(motor_dot),
    }


def _motor_columns(motors: Actuators) -> list[str]:
    return [
        column
        for name, unit, counted in zip(motors.names, motors.motor_units, motors.units, strict=True)
        for column in (
            f"{name}.motor_position [{unit}]",
            f"{name}.motor_velocity [{unit}/s]",
            f"{name}.counts [{counted}]",
            f"{name}.counts_rate [{counted}/s]",
        )
    ]


def _motors_message(trajectory: Trajectory, motors: Actuators, dt: float) -> dict[str, Any]:
    """Beside the joints' points, which keep to ROS's fields: as many points of the motors."""
    position, velocity, counts, rate = _motor_values(trajectory, motors, dt).values()
    return {
        "names": list(motors.names),
        "units": list(motors.motor_units),
        "count_units": list(motors.units),
        "points": [
            {"positions": p, "velocities": v, "counts": c, "counts_rates": r}
            for p, v, c, r in zip(position.tolist(), velocity.tolist(), counts.tolist(), rate.tolist(), strict=True)
        ],
    }
