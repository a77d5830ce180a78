"""joint_limits.yaml of MoveIt and ros2_control: limits beside the description, by joint."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...limits.joint_limits import by_field
from ...support.errors import DescriptionError, closest, listed
from ..document import existing_file, read_text
from ..findings import Finding, Place, finding, refusal
from ..yaml_reading import parse_yaml

MAX_BYTES = 250_000
"""A file for a whole humanoid has some 10 kB."""

MAX_NESTING = 6
"""How deep parameters nest around joint_limits (`/**: ros__parameters: robot_description_planning:`)."""

_GIVEN = {
    "velocity": ("has_velocity_limits", {"max_velocity": "velocity"}),
    "acceleration": ("has_acceleration_limits", {"max_acceleration": "acceleration"}),
    "jerk": ("has_jerk_limits", {"max_jerk": "jerk"}),
    "effort": ("has_effort_limits", {"max_effort": "effort"}),
    "position": ("has_position_limits", {"min_position": "lower", "max_position": "upper"}),
}
"""For each kind of limit its switch, and its entries with their fields of JointLimits."""

_OTHER = re.compile(r"(has|max)_deceleration(_limits)?|has_soft_limits|k_(position|velocity)|soft_.*|angle_wraparound")
"""Entries of ros2_control that have no effect here."""


@dataclass(frozen=True)
class LimitsFile:
    """Limits of a file by joint and field, {"elbow": {"velocity": 1.0}}, in rad or m and their rates."""

    path: Path
    joints: Mapping[str, Mapping[str, float]]
    findings: tuple[Finding, ...] = ()

    def of(
        self, names: tuple[str, ...], every: Iterable[str]
    ) -> tuple[dict[str, dict[str, float]], tuple[Finding, ...]]:
        """Limits for these coordinates by field and joint, and findings. `every` lists all joints of the robot.

        Raises DescriptionError if the file names none of the coordinates.
        """
        others = [joint for joint in self.joints if joint not in names]
        place = Place(self.path.name)
        if len(others) == len(self.joints):
            what = f"its joints are {listed(others) or 'none'}; the arm's are {listed(names)}"
            raise refusal("limits-unusable", Place(str(self.path)), what, "is it the file of another robot?")
        changes = by_field({joint: values for joint, values in self.joints.items() if joint in names})
        noted = list(self.findings)
        nobodys = [joint for joint in others if joint not in set(every)]
        for joint in nobodys:
            what = f"it has limits for {joint!r}, and no joint has that name; they are not kept"
            noted.append(finding("limits-unknown-joint", place, what, f"correct the name{closest(joint, names)}"))
        if len(nobodys) < len(others):
            strangers = [joint for joint in others if joint not in nobodys]
            what = f"it has limits for {listed(strangers)}, which are no coordinates of this arm"
            noted.append(finding("off-the-chain", place, what, "nothing, if they are a gripper's"))
        if not changes:
            what = "it gives no limit for this arm: every has_…_limits is false, or the values are 0"
            noted.append(finding("limits-empty", place, what, "set has_velocity_limits: true and max_velocity"))
        return changes, tuple(noted)


def read_joint_limits(path: str | os.PathLike[str]) -> LimitsFile:
    """Read a joint_limits.yaml: `joint_limits: {joint: {has_velocity_limits: true, max_velocity: 1.0, …}}`.

    `has_…_limits: false` and a limit of 0 mean "not given". Without `has_…` a limit counts. The mapping may lie inside
    ROS parameters (`/**: ros__parameters:`). `!degrees` become rad.

    Raises DescriptionError (file, joint, remedy).
    """
    file = existing_file(path, "the path of a joint_limits.yaml")
    content = parse_yaml(read_text(file, MAX_BYTES), file)
    found = list(_nested(content, MAX_NESTING))
    if len(found) != 1:
        there = f"it holds joint_limits in {len(found)} places" if found else "it holds no joint_limits"
        keys = listed(map(str, content), 6) if isinstance(content, dict) else "no mapping"
        remedy = "write joint_limits: {joint: {has_velocity_limits: true, max_velocity: 1.0}}, once"
        raise _unusable(file, f"{there} (at the top: {keys})", remedy)
    around, table = found[0]
    if not isinstance(table, dict):
        raise _unusable(file, f"joint_limits must be a mapping by joint; got {_short(table)}")
    joints: dict[str, dict[str, float]] = {}
    noted = list(_scaled(around, file))
    for joint, entries in table.items():
        joints[str(joint)] = _joint(str(joint), entries, file, noted)
    return LimitsFile(file, joints, tuple(noted))


def _nested(content: Any, depth: int) -> Iterator[tuple[Any, Any]]:
    """Every mapping with joint_limits, and the value there."""
    if not isinstance(content, dict) or depth == 0:
        return
    if "joint_limits" in content:
        yield content, content["joint_limits"]
        return
    for value in content.values():
        yield from _nested(value, depth - 1)


def _scaled(around: Mapping[str, Any], file: Path) -> Iterator[Finding]:
    factors = [f"{key} {value}" for key, value in around.items() if str(key).startswith("default_")]
    if factors:
        what = f"{' and '.join(factors)}: MoveIt plans with limits scaled so; here they are taken as they are"
        yield finding("limits-not-scaled", Place(file.name), what, "lower limits that should hold here too")


def _joint(joint: str, entries: Any, file: Path, noted: list[Finding]) -> dict[str, float]:
    if not isinstance(entries, dict):
        raise _unusable(file, f"joint {joint!r} must be a mapping such as {{max_velocity: 1.0}}; got {_short(entries)}")
    known = [name for switch, fields in _GIVEN.values() for name in (switch, *fields)]
    for key in map(str, entries):
        if key not in known and not _OTHER.fullmatch(key):
            what = f"its entry {key!r} is unknown and left out{closest(key, known)}"
            noted.append(finding("limits-entry-unknown", Place(file.name, None, "joint", joint), what, "correct it"))
    limits: dict[str, float] = {}
    for switch, fields in _GIVEN.values():
        if _is_on(entries, switch, joint, file):
            limits |= {
                field: _number(entries[name], name, joint, file) for name, field in fields.items() if name in entries
            }
    limits = {field: value for field, value in limits.items() if value or field in ("lower", "upper")}
    if limits.get("lower", -np.inf) > limits.get("upper", np.inf):
        what = f"joint {joint!r}: min_position {limits['lower']:g} lies above max_position {limits['upper']:g}"
        raise _unusable(file, what, "swap them")
    return limits


def _is_on(entries: Mapping[str, Any], switch: str, joint: str, file: Path) -> bool:
    value = entries.get(switch, True)
    if not isinstance(value, bool):
        raise _unusable(file, f"joint {joint!r}: {switch} must be true or false; got {_short(value)}")
    return value


def _number(value: Any, entry: str, joint: str, file: Path) -> float:
    try:
        number = float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else np.nan
    except OverflowError:
        number = np.nan
    if np.isnan(number):
        raise _unusable(file, f"joint {joint!r}: {entry} must be a number (rad or m, or !degrees); got {_short(value)}")
    if number < 0 and not entry.endswith("position"):
        raise _unusable(file, f"joint {joint!r}: {entry} must not be negative; got {number:g}")
    return number


def _unusable(file: Path, what: str, remedy: str = "") -> DescriptionError:
    return refusal("limits-unusable", Place(str(file)), what, remedy)


def _short(value: Any) -> str:
    return repr(value)[:60]
