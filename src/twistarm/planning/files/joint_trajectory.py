"""ROS's trajectory_msgs/JointTrajectory as JSON, with motors and labels as extra fields; read as YAML, too."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...description.companions.data_files import parse_yaml
from ...support.checks import Array, as_number
from ...support.errors import DescriptionError, InputError, closest, listed, quote
from ...support.fields import numbers
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
        # An echoed message ends with the separator of a next document, which does not follow.
        is_json = file.suffix.lower() == ".json"
        message = parsed(text) if is_json else parse_yaml(text.rstrip().removesuffix("\n---"), file)
    except (ValueError, DescriptionError) as error:
        raise InputError(f"{file} is no JSON: {error}" if is_json else str(error)) from error
    return points_in(arm, message, str(file))


def points_in(arm: Arm, message: Any, file: str) -> Points:
    """The points of `arm` in a JointTrajectory or MoveIt's RobotTrajectory. Raises InputError, with the point."""
    message = message.get("joint_trajectory", message) if isinstance(message, dict) else message
    names, points = _listed(message, "joint_names", file), _listed(message, "points", file)
    order = _order(arm, names, file)

    def place(k: int) -> str:
        return f"{file}, point {k} (counted from 0)"

    t = np.array([_time(point, place(k)) for k, point in enumerate(points)])
    states = []
    for name in FIELDS:
        if name != FIELDS[0] and not all(point.get(name) for point in points):
            break  # ROS leaves out what is not known, or leaves it empty
        rows = [
            numbers(_entry(point, name, place(k)), f"{place(k)}: {name}", len(names)) for k, point in enumerate(points)
        ]
        states.append(np.reshape(rows, (len(points), len(names)))[:, order])
    return Points(t, _labels(message, file), place, *states)


def _entry(mapping: Any, name: str, place: str) -> Any:
    if not isinstance(mapping, dict):
        raise InputError(f"{place}: a mapping with {name!r} is needed; got {quote(mapping)}")
    if name not in mapping:
        raise InputError(f"{place}: {name!r} is missing{closest(name, map(str, mapping))}")
    return mapping[name]


def _listed(mapping: Any, name: str, place: str) -> list[Any]:
    value = _entry(mapping, name, place)
    if not isinstance(value, list):
        raise InputError(f"{place}: {name} must be a list; got {quote(value)}")
    return value


def _order(arm: Arm, names: list[Any], file: str) -> list[int]:
    """Return the index of each of the arm's joints among those of the message."""
    others = [name for name in names if isinstance(name, str) and name not in arm.joint_names]
    require_joint_of(arm, [name for name in names if isinstance(name, str)], file)
    for name in arm.joint_names:
        if names.count(name) != 1:
            what = f"twice: {listed([name])}" if name in names else f"no {listed([name])}{closest(name, others)}"
            raise InputError(f"{file}: its joint_names have {what}; a motion of {arm.name} names each joint once")
    return [names.index(name) for name in arm.joint_names]


def _time(point: Any, place: str) -> float:
    time = _entry(point, "time_from_start", place)
    parts = [_entry(time, name, f"{place}, time_from_start") for name in ("sec", "nanosec")]
    if not all(isinstance(part, int) and not isinstance(part, bool) and 0 <= part < 2**32 for part in parts):
        raise InputError(f"{place}: time_from_start is in whole sec and nanosec from 0; got {quote(time)}")
    return float(parts[0] + parts[1] * NANOSECOND)


def _labels(message: dict[str, Any], file: str) -> list[tuple[float, str]]:
    place = f"{file}, labels"
    return [
        (as_number(_entry(label, "time", place), f"{place}: time"), _entry(label, "text", place))
        for label in (_listed(message, "labels", file) if "labels" in message else ())
    ]
