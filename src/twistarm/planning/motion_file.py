"""motion.toml: a motion as a list of segments, with its start, kind and limits."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..description.companions.toml_entries import parse_toml
from ..ik.targets import Approach, Pose, Position, Task
from ..model.arm import Arm
from ..support.checks import Array, as_flag, as_number, as_reals, as_vector, require_mapping
from ..support.errors import InputError, TwistarmError, closest, listed
from ..support.files import as_path
from ..theory.rotations import from_quaternion_wxyz, from_rpy
from .segments import ArcMove, Dwell, Goal, JointMove, LineMove, ScrewMove, Segment

SPEEDS = ("tool_speed", "turn_speed")
TOP = ("start", "kind", "degrees", *SPEEDS, "limits", "segment")
KINDS = ("joint", "line", "screw", "arc", "dwell")
OPTIONS = ("blend", "speed", *SPEEDS, "label")
GOAL = ("xyz", "rpy", "quaternion_wxyz", "direction", "tool_axis", "tolerance", "frame")

ANGLES = ("rpy", "angle", "turn_speed")
"""Entries in degrees where the file says so."""


@dataclass(frozen=True)
class MotionFile:
    """The content of a motion.toml: what `plan` takes beside the arm, None where it is left to the defaults."""

    segments: tuple[Segment, ...]
    start: Goal | None = None
    kind: str | None = None
    limits: Mapping[str, Any] = field(default_factory=dict)
    tool_speed: float | None = None
    turn_speed: float | None = None


def load_motion(path: str | os.PathLike[str], arm: Arm) -> MotionFile:
    """Read a motion.toml for an arm.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[segment]]` has one of joint, line,
    screw, arc and dwell, and the options that `Move` has.

    Args:
        path: The file.
        arm: The arm whose joints it names.

    Returns:
        The `MotionFile`.

    Raises:
        InputError: An entry cannot be used; the message names file, segment and entry.
        DescriptionError: The file cannot be read or is no TOML.
    """
    file = as_path(path)
    return _Reader(file, parse_toml(file, "a motion.toml"), arm).motion()


class _Reader:
    def __init__(self, file: Path, content: Mapping[str, Any], arm: Arm) -> None:
        self.file, self.content, self.arm = file, content, arm
        self.angle = 1.0

    def motion(self) -> MotionFile:
        with self._at("at the top"):
            _only(self.content, TOP)
            if as_flag(self.content.get("degrees", False), "degrees"):
                self.angle = np.pi / 180.0
            limits = require_mapping(self.content.get("limits", {}), "limits", "{ acceleration = 3.0 }")
            entries = self.content.get("segment", [])
            if not isinstance(entries, list) or not entries:
                raise InputError("there is no segment: write [[segment]] and under it joint, line, screw, arc or dwell")
            start = self._goal(self.content["start"]) if "start" in self.content else None
            speeds = {name: self._number(self.content, name) for name in SPEEDS if name in self.content}
        segments = []
        for i, entry in enumerate(entries):
            with self._at(f"segment {i + 1}"):
                segments.append(self._segment(entry))
        return MotionFile(tuple(segments), start, self.content.get("kind"), limits, **speeds)

    @contextmanager
    def _at(self, place: str) -> Iterator[None]:
        try:
            yield
        except TwistarmError as error:
            raise InputError(f"{self.file}, {place}: {error}") from error

    def _segment(self, entry: Any) -> Segment:
        table = require_mapping(entry, "a segment", '{ line = "ready" }')
        _only(table, (*KINDS, *OPTIONS))
        kinds = [kind for kind in KINDS if kind in table]
        if len(kinds) != 1:
            raise InputError(f"it needs one of {', '.join(KINDS)}; got {listed(kinds) or 'none of them'}")
        options = {name: self._number(table, name) for name in OPTIONS if name in table}
        make: Callable[[Any, dict[str, Any]], Segment] = getattr(self, f"_{kinds[0]}")
        return make(table[kinds[0]], options)

    def _joint(self, value: Any, options: dict[str, Any]) -> Segment:
        return JointMove(self._goal(value), **options)

    def _line(self, value: Any, options: dict[str, Any]) -> Segment:
        if isinstance(value, dict) and "by" in value:
            return LineMove.by(value["by"], **self._rest(value, ("by",), ("frame", "constrain")), **options)
        return LineMove(self._goal(value), **options)

    def _screw(self, value: Any, options: dict[str, Any]) -> Segment:
        if isinstance(value, dict) and "axis" in value:
            rest = self._rest(value, ("axis", "point", "angle"), ("pitch", "constrain"))
            angle = self._number(value, "angle")
            return ScrewMove.about(value["axis"], value["point"], angle, **rest, **options)
        return ScrewMove(self._goal(value), **options)

    def _arc(self, value: Any, options: dict[str, Any]) -> Segment:
        table = require_mapping(value, "arc", "{ via = [0.5, 0.0, 0.6], to = … }")
        if "axis" in table:
            rest = self._rest(table, ("axis", "centre", "angle"), ("turn", "constrain"))
            angle = self._number(table, "angle")
            return ArcMove.about(table["axis"], table["centre"], angle, **rest, **options)
        self._rest(table, ("via", "to"), ())
        return ArcMove(table["via"], self._goal(table["to"]), **options)

    def _dwell(self, value: Any, options: dict[str, Any]) -> Segment:
        _only(options, ("label",))
        return Dwell(value, **options)

    def _goal(self, value: Any) -> Goal:
        """The name of a configuration, its numbers, {joint: value}, or a target by xyz and what turns the tool."""
        if isinstance(value, str):
            return value
        per_joint = np.array([self.angle if unit == "rad" else 1.0 for unit in self.arm.units])
        if isinstance(value, list):
            theta: Array = as_vector(value, "a configuration", self.arm.n) * per_joint
            return theta
        table = require_mapping(value, "a goal", '"ready", { elbow = 0.5 } or { xyz = [0.5, 0.0, 0.6] }')
        if "xyz" not in table:
            factors = dict(zip(self.arm.joint_names, per_joint.tolist(), strict=True))
            return {joint: as_number(each, joint) * factors.get(joint, 1.0) for joint, each in table.items()}
        _only(table, GOAL)
        return self._target(table)

    def _target(self, table: Mapping[str, Any]) -> Pose | Position | Approach | Task:
        p = as_vector(table["xyz"], "xyz")
        turned = [name for name in ("rpy", "quaternion_wxyz", "direction") if name in table]
        if len(turned) > 1:
            which = " or ".join(turned)
            raise InputError(f"give {which}, not both: a whole orientation, or only where the tool points")
        if "direction" in table:
            return Approach(p, table["direction"], table.get("tool_axis"))
        if not turned:
            return Position(p)
        g = np.eye(4)
        g[:3, 3] = p
        if "rpy" in table:
            g[:3, :3] = from_rpy(self.angle * as_vector(table["rpy"], "rpy"))
        else:
            g[:3, :3] = from_quaternion_wxyz(table["quaternion_wxyz"])
        if "tolerance" not in table:
            return Pose(g)
        tolerance = as_reals(table["tolerance"], "tolerance") * np.repeat([1.0, self.angle], 3)
        return Task(g, tolerance, table.get("frame", "target"))

    def _rest(self, table: Mapping[str, Any], needed: Sequence[str], others: Sequence[str]) -> dict[str, Any]:
        """Those of the `others` that are given, where all that is `needed` is there and nothing else."""
        _only(table, (*needed, *others))
        for name in needed:
            if name not in table:
                raise InputError(f"{name} is missing beside {listed(table)}")
        return {name: table[name] for name in others if name in table}

    def _number(self, table: Mapping[str, Any], name: str) -> Any:
        return as_number(table[name], name) * self.angle if name in ANGLES else table[name]


def _only(table: Mapping[str, Any], allowed: Sequence[str]) -> None:
    for key in table:
        if key not in allowed:
            raise InputError(f"unknown entry {key!r}{closest(key, allowed)} (allowed: {listed(allowed, 20)})")
