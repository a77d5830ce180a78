"""A trajectory as ROS's trajectory_msgs/JointTrajectory, its motors and labels beside the message's own fields."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from ...limits.actuators import Actuators
from ...support.checks import Array
from ...support.errors import InputError
from ...support.files import WRITTEN_YAML
from ...support.yaml_text import block
from .motor_values import motor_values, motors_of

if TYPE_CHECKING:
    from ..trajectory import Trajectory

NANOSECOND = 1e-9


def json_text(trajectory: Trajectory, dt: float, actuators: Actuators | None = None) -> str:
    """What `Trajectory.to_json` writes."""
    return json.dumps(_message(trajectory, dt, actuators), indent=1, allow_nan=False) + "\n"


def yaml_text(trajectory: Trajectory, dt: float, actuators: Actuators | None = None) -> str:
    """What `Trajectory.to_yaml` writes."""
    message = _message(trajectory, dt, actuators)
    return "\n".join([f"{WRITTEN_YAML}: a trajectory_msgs/JointTrajectory", *block(message), ""])


def _message(trajectory: Trajectory, dt: float, actuators: Actuators | None) -> dict[str, Any]:
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
    if motors := motors_of(trajectory, actuators):
        message["motors"] = _motors_message(trajectory, motors, samples.t)
    if trajectory.labels:
        message["labels"] = [{"time": time, "text": text} for time, text in trajectory.labels]
    return message


def _motors_message(trajectory: Trajectory, motors: Actuators, t: Array) -> dict[str, Any]:
    """Beside the joints' points, which keep to ROS's fields: as many points of the motors."""
    position, velocity, counts, rate = motor_values(trajectory, motors, t)
    return {
        "names": list(motors.names),
        "units": list(motors.motor_units),
        "count_units": list(motors.units),
        "points": [
            {"positions": p, "velocities": v, "counts": c, "counts_rates": r}
            for p, v, c, r in zip(position.tolist(), velocity.tolist(), counts.tolist(), rate.tolist(), strict=True)
        ],
    }
