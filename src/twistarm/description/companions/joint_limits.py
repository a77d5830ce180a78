"""joint_limits.yaml of MoveIt and ros2_control: limits beside the description, by joint."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping
from functools import partial
from math import copysign, inf
from pathlib import Path
from typing import Any

from ...limits.joint_limits import JointLimits, by_field
from ...support.checks import as_flag, as_number
from ...support.errors import InputError, closest, listed
from ...support.fields import Check, anything, fields, table_of
from ..bounds import NO_LIMIT
from ..document import existing_file, read_text
from ..findings import Finding, Place, finding
from .data_files import parse_yaml, unusable

MAX_BYTES = 250_000  # A file for a whole humanoid has some 10 kB.
# How deep parameters nest around joint_limits (`/**: ros__parameters: robot_description_planning:`).
MAX_NESTING = 6


def _position(value: Any, name: str) -> float:
    """Check a position limit. From `NO_LIMIT` on it is an open side, as in a URDF."""
    position = as_number(value, name, -inf, inf, unit="rad or m, or !degrees")
    return position if abs(position) < NO_LIMIT else copysign(inf, position)


_rate = partial(as_number, least=0.0, most=inf, unit="per s, s², s³; N m or N")

ENTRIES: Mapping[str, tuple[str, str, Check]] = {
    "max_velocity": ("has_velocity_limits", "velocity", _rate),
    "max_acceleration": ("has_acceleration_limits", "acceleration", _rate),
    # Pilz's planner for MoveIt writes a negative number, ros2_control a positive one.
    "max_deceleration": ("has_deceleration_limits", "deceleration", _position),
    "max_jerk": ("has_jerk_limits", "jerk", _rate),
    "max_effort": ("has_effort_limits", "effort", _rate),
    "min_position": ("has_position_limits", "lower", _position),
    "max_position": ("has_position_limits", "upper", _position),
    "soft_lower_limit": ("has_soft_limits", "soft_lower", _position),
    "soft_upper_limit": ("has_soft_limits", "soft_upper", _position),
}
"""Each entry with its switch, its meaning and its check."""

FORMAT = (
    {entry: check for entry, (_, _, check) in ENTRIES.items()}
    | {switch: as_flag for switch, _, _ in ENTRIES.values()}
    | dict.fromkeys(("k_position", "k_velocity", "angle_wraparound"), anything)
)
"""The last three are of controllers and have no effect here."""

POSITIONS = ("lower", "upper", "soft_lower", "soft_upper")


def with_file(
    limits: JointLimits, names: tuple[str, ...], every: Collection[str], path: str | os.PathLike[str]
) -> tuple[JointLimits, tuple[Finding, ...]]:
    """The limits of these coordinates with those of a joint_limits.yaml, and findings.

    It is `joint_limits: {joint: {has_velocity_limits: true, max_velocity: 1.0, …}}`, also inside ROS parameters
    (`/**: ros__parameters:`). `has_…_limits: false` and a limit of 0 mean "not given". Without `has_…` a limit counts.
    Of acceleration and deceleration the smaller holds. Soft limits narrow the positions. `!degrees` become rad.
    `every` lists all joints of the robot.

    Raises DescriptionError (file, joint, remedy) also if the file names none of the coordinates, or if its limits are
    swapped or leave no room.
    """
    file = existing_file(path, "the path of a joint_limits.yaml")
    try:
        content = _content(file)
        table = table_of(table_of(anything))(content["joint_limits"], "joint_limits")
        given = {joint: _joint(joint, entries) for joint, entries in table.items()}
        noted = list(_noted(file, content, given, names, every))
        ours = {joint: its for joint, its in given.items() if joint in names}
        for joint, its in ours.items():
            i, soft = names.index(joint), (its.pop("soft_lower", -inf), its.pop("soft_upper", inf))
            if soft != (-inf, inf):
                its["lower"] = max(soft[0], its.get("lower", limits.lower[i]))
                its["upper"] = min(soft[1], its.get("upper", limits.upper[i]))
                if its["lower"] > its["upper"]:
                    hard = f"[{limits.lower[i]:g}, {limits.upper[i]:g}]"
                    raise InputError(f"the soft limits of {joint} leave no room inside {hard}: {list(soft)}")
                what = f"its soft limits are kept: [{its['lower']:g}, {its['upper']:g}]"
                place = Place(file.name, None, "joint", joint)
                noted.append(finding("limits-adjusted", place, what, "set has_soft_limits: false for its whole range"))
        return limits.with_(by_field(ours), names), tuple(noted)
    except InputError as error:
        raise unusable(file, str(error)) from error


def _content(file: Path) -> Mapping[str, Any]:
    """The one mapping with joint_limits."""
    content = parse_yaml(read_text(file, MAX_BYTES), file)
    found = list(_nested(content, MAX_NESTING))
    if len(found) != 1:
        there = f"it holds joint_limits in {len(found)} places" if found else "it holds no joint_limits"
        keys = listed(map(str, content), 6) if isinstance(content, dict) else "no mapping"
        remedy = "write joint_limits: {joint: {has_velocity_limits: true, max_velocity: 1.0}}, once"
        raise unusable(file, f"{there} (at the top: {keys})", remedy)
    return found[0]


def _noted(
    file: Path,
    content: Mapping[str, Any],
    given: Mapping[str, Mapping[str, float]],
    names: tuple[str, ...],
    every: Collection[str],
) -> Iterator[Finding]:
    """Findings for what has no effect: factors, unknown entries and joints, and a file without a limit."""
    place = Place(file.name)
    if factors := [f"{key} {value}" for key, value in content.items() if str(key).startswith("default_")]:
        what = f"{' and '.join(factors)}: MoveIt scales its limits by this factor; twistarm does not"
        yield finding("companion-not-used", place, what, "write the scaled limits here too")
    for joint, entries in content["joint_limits"].items():
        for key in (key for key in entries if key not in FORMAT):
            what = f"its entry {key!r} is unknown and left out{closest(key, FORMAT)}"
            yield finding("companion-doubtful", Place(file.name, None, "joint", joint), what, "correct it")
    if not any(joint in names for joint in given):
        what = f"its joints are {listed(given) or 'none'}; the arm's are {listed(names)}"
        raise unusable(file, what, "is it the file of another robot?")
    for joint in (joint for joint in given if joint not in names and joint not in every):
        what = f"it has limits for {joint!r}, and no joint has that name; they are not kept"
        yield finding("companion-doubtful", place, what, f"correct the name{closest(joint, names)}")
    if not any(its for joint, its in given.items() if joint in names):
        what = "it gives no limit for this arm: every has_…_limits is false, or the values are 0"
        yield finding("companion-not-used", place, what, "set has_velocity_limits: true and max_velocity")


def _nested(content: Any, depth: int) -> Iterator[Mapping[str, Any]]:
    """Every mapping with joint_limits."""
    if not isinstance(content, dict) or depth == 0:
        return
    if "joint_limits" in content:
        yield content
        return
    for value in content.values():
        yield from _nested(value, depth - 1)


def _joint(joint: str, entries: Mapping[str, Any]) -> dict[str, float]:
    """The limits of a joint by meaning, without those that are switched off."""
    given = fields({key: entries[key] for key in FORMAT if key in entries}, f"joint {joint!r}", {}, FORMAT)
    limits: dict[str, float] = {}
    for entry, (switch, meaning, _) in ENTRIES.items():
        if entry in given and given.get(switch, True) and (given[entry] or meaning in POSITIONS):
            limits[meaning] = given[entry]
    if slowing := abs(limits.pop("deceleration", 0.0)):
        limits["acceleration"] = min(slowing, limits.get("acceleration", inf))
    if limits.get("lower", -inf) > limits.get("upper", inf):
        raise InputError(f"joint {joint!r}: min_position {limits['lower']:g} lies above max_position; swap them")
    return limits
