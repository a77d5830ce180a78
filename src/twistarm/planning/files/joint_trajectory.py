"""ROS's trajectory_msgs/JointTrajectory as JSON, with motors and labels as extra fields; read as YAML, too."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...description.companions.data_files import parse_yaml
from ...support.checks import Array, as_number, as_whole
from ...support.errors import DescriptionError, InputError, closest, listed
from ...support.fields import anything, fields, inside, list_of, numbers
from ...support.fields import text as any_text
from ...support.files import read_bounded, why_no_file
from ...support.strict_json import parsed
from ..trajectory import Points, Trajectory, Writing, motor_values, motors_of, require_joint_of

NANOSECOND = 1e-9

MAX_BYTES = 50_000_000  # Twenty minutes of five joints at 100 Hz.

FIELDS = ("positions", "velocities", "accelerations")


def json_text(trajectory: Trajectory, how: Writing) -> str:
    """Return the text that `save_trajectory` writes."""
    samples = trajectory.sample(how.dt)
    nanoseconds = np.rint(samples.t / NANOSECOND).astype(np.int64)
    if not (np.diff(nanoseconds) > 0).all():
        raise InputError(f"dt = {how.dt:g} s is too short for JointTrajectory, which counts time in nanoseconds")
    stamps = [{"time_from_start": {"sec": ns // 10**9, "nanosec": ns % 10**9}} for ns in nanoseconds.tolist()]
    points = [state | stamp for state, stamp in zip(_points_of(FIELDS, samples[1:]), stamps, strict=True)]
    message: dict[str, Any] = {"joint_names": list(trajectory.joint_names), "points": points}
    if motors := motors_of(trajectory, how.actuators):
        names = ("positions", "velocities", "counts", "counts_rates")
        message["motors"] = {
            "names": list(motors.names),
            "units": list(motors.motor_units),
            "count_units": list(motors.units),
            "points": _points_of(names, motor_values(trajectory, motors, samples.t)),
        }
    if trajectory.labels:
        message["labels"] = [{"time": time, "text": text} for time, text in trajectory.labels]
    return json.dumps(message, indent=1, allow_nan=False) + "\n"


def _points_of(names: tuple[str, ...], values: Sequence[Array]) -> list[dict[str, Any]]:
    """Return one mapping per row of these arrays (m, k)."""
    return [dict(zip(names, rows, strict=True)) for rows in zip(*(column.tolist() for column in values), strict=True)]


def read_message(arm: Arm, file: Path) -> Points:
    """Read the points of `arm` from JSON, from YAML, or from what `ros2 topic echo` prints.

    Raises InputError, with the line or the point.
    """
    try:
        text = read_bounded(file, MAX_BYTES).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        raise InputError(f"{file}: {why_no_file(file, error)}") from error
    try:
        is_json = file.suffix.lower() == ".json"
        message = parsed(text) if is_json else parse_yaml(text, file)
    except (ValueError, DescriptionError) as error:
        raise InputError(f"{file} is no JSON: {error}" if is_json else str(error)) from error
    return points_in(arm, message, str(file))


def points_in(arm: Arm, message: Any, file: str) -> Points:
    """The points of `arm` in a JointTrajectory or MoveIt's RobotTrajectory. Raises InputError, with the point."""
    message = message.get("joint_trajectory", message) if isinstance(message, dict) else message
    with inside(file):
        sent = fields(
            message, "JointTrajectory", {"joint_names": list_of(any_text), "points": list_of(_point)},
            {"header": anything, "motors": anything, "labels": list_of(_label)},
        )  # fmt: skip
    names, points, states = sent["joint_names"], sent["points"], []
    order = _order(arm, names, file)
    for name in FIELDS:
        if name != FIELDS[0] and not all(point.get(name) for point in points):
            break  # ROS leaves out what is not known, or leaves it empty
        with inside(file):
            rows = [numbers(point[name], f"points[{k}].{name}", len(names)) for k, point in enumerate(points)]
        states.append(np.reshape(rows, (len(points), len(names)))[:, order])
    t = np.array([point["time_from_start"] for point in points])
    return Points(t, sent.get("labels", []), lambda k: f"{file}, points[{k}]", *states)


def _point(value: Any, name: str) -> dict[str, Any]:
    optional = dict.fromkeys((*FIELDS[1:], "effort"), anything)
    return fields(value, name, {FIELDS[0]: anything, "time_from_start": _time}, optional)


def _time(value: Any, name: str) -> float:
    whole = partial(as_whole, most=2**32 - 1)
    parts = fields(value, name, {"sec": whole, "nanosec": whole})
    return float(parts["sec"] + parts["nanosec"] * NANOSECOND)


def _label(value: Any, name: str) -> tuple[float, str]:
    label = fields(value, name, {"time": as_number, "text": any_text})
    return label["time"], label["text"]


def _order(arm: Arm, names: list[str], file: str) -> list[int]:
    """Return the index of each of the arm's joints among those of the message."""
    others = [name for name in names if name not in arm.joint_names]
    require_joint_of(arm, names, file)
    for name in arm.joint_names:
        if names.count(name) != 1:
            what = f"twice: {listed([name])}" if name in names else f"no {listed([name])}{closest(name, others)}"
            raise InputError(f"{file}: its joint_names have {what}; a motion of {arm.name} names each joint once")
    return [names.index(name) for name in arm.joint_names]
