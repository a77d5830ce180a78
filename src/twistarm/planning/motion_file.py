"""motion.toml: a motion as a list of segments, with start, kind and limits."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..description.companions.toml_entries import parse_toml
from ..ik.targets import Approach, Pose, Position, TolerancedPose
from ..support.checks import as_not_negative, as_positive, as_reals, as_theta, require_choice, require_mapping
from ..support.errors import InputError, listed, shown
from ..support.fields import flag, inside, number, only, vector
from ..support.files import as_path
from ..theory.rotations import from_quaternion_wxyz, from_rpy
from .motion import LAWS
from .segments import ArcMove, Dwell, FreeMove, Goal, JointMove, LineMove, ScrewMove, Segment

SHARED = ("linear_speed", "angular_speed", "position_tol", "orientation_tol")
"""What holds for every segment that does not say it itself."""

TOP_LEVEL = ("start", "kind", "degrees", *SHARED, "unwrap", "scene", "limits", "segment")
KINDS = ("joint", "free", "line", "screw", "arc", "dwell")
OPTIONS = ("blend", "velocity_scaling", *SHARED, "label")
GOAL = ("xyz", "rpy", "quaternion_wxyz", "direction", "tool_axis", "tolerance", "frame")

ANGLES = ("rpy", "angle", "angular_speed", "orientation_tol")
"""Entries in degrees where the file says so."""


@dataclass(frozen=True)
class MotionFile:
    """The content of a motion.toml: arguments of `plan`, None for a default. `scene` is the path of a scene file."""

    segments: tuple[Segment, ...]
    start: Goal | None = None
    kind: str | None = None
    limits: Mapping[str, Any] = field(default_factory=dict)
    linear_speed: float | None = None
    angular_speed: float | None = None
    position_tol: float | None = None
    orientation_tol: float | None = None
    unwrap: bool = False
    scene: Path | None = None


def load_motion(path: str | os.PathLike[str], arm: Arm) -> MotionFile:
    """Read a motion.toml for an arm.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[segment]]` has a joint, free,
    line, screw, arc or dwell, and options of `Move`. `scene` names a scene file, seen from the folder of this one.

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
        with inside(self.file, "at the top"):
            only(self.content, TOP_LEVEL)
            if flag(self.content.get("degrees", False), "degrees"):
                self.angle = np.pi / 180.0
            limits = require_mapping(self.content.get("limits", {}), "limits", "{ acceleration = 3.0 }")
            self.arm.limits.with_(limits, self.arm.joint_names)  # says what is wrong with them
            kind = require_choice(self.content["kind"], LAWS, "kind") if "kind" in self.content else None
            start = self._start(self.content["start"]) if "start" in self.content else None
            whole = {
                name: as_positive(self._number(self.content, name), name) for name in SHARED if name in self.content
            }
            unwrap = flag(self.content.get("unwrap", False), "unwrap")
            scene = self._scene(self.content["scene"]) if "scene" in self.content else None
            entries = self.content.get("segment", [])
            if not isinstance(entries, list) or not entries:
                raise InputError(f"there is no segment: write [[segment]] and under it one of {', '.join(KINDS)}")
        segments = []
        for i, entry in enumerate(entries):
            with inside(self.file, f"segment {i + 1}"):
                segments.append(self._segment(entry))
        return MotionFile(tuple(segments), start, kind, limits, **whole, unwrap=unwrap, scene=scene)

    def _segment(self, entry: Any) -> Segment:
        table = require_mapping(entry, "a segment", '{ line = "ready" }')
        only(table, (*KINDS, *OPTIONS))
        kinds = [kind for kind in KINDS if kind in table]
        if len(kinds) != 1:
            raise InputError(f"it needs one of {', '.join(KINDS)}; got {listed(kinds) or 'none of them'}")
        options = {
            name: table[name] if name == "label" else self._number(table, name) for name in OPTIONS if name in table
        }
        make: Callable[[Any, dict[str, Any]], Segment] = getattr(self, f"_{kinds[0]}")
        return make(table[kinds[0]], options)

    def _joint(self, value: Any, options: dict[str, Any]) -> Segment:
        return JointMove(self._goal(value), **options)

    def _free(self, value: Any, options: dict[str, Any]) -> Segment:
        return FreeMove(self._goal(value), **options)

    def _line(self, value: Any, options: dict[str, Any]) -> Segment:
        if table := _described(value, ("by",), ("frame", "constrain")):
            return LineMove.by(vector(table["by"], "by"), **_present(table, "frame", "constrain"), **options)
        return LineMove(self._goal(value), **options)

    def _screw(self, value: Any, options: dict[str, Any]) -> Segment:
        if table := _described(value, ("axis", "point", "angle"), ("pitch", "constrain")):
            axis, point = (vector(table[name], name) for name in ("axis", "point"))
            angle = self._number(table, "angle")
            pitch = self._number(table, "pitch") if "pitch" in table else 0.0
            return ScrewMove.about(axis, point, angle, pitch, **_present(table, "constrain"), **options)
        return ScrewMove(self._goal(value), **options)

    def _arc(self, value: Any, options: dict[str, Any]) -> Segment:
        if table := _described(value, ("axis", "centre", "angle"), ("turn", "constrain")):
            axis, centre = (vector(table[name], name) for name in ("axis", "centre"))
            angle = self._number(table, "angle")
            return ArcMove.about(axis, centre, angle, **_present(table, "turn", "constrain"), **options)
        through = _described(value, ("via", "to"), ())
        if through is None:
            raise InputError(f"arc takes via and to, or axis, centre and angle; got {shown(value)}")
        via = through["via"]
        middle = self._target(via) if isinstance(via, dict) else vector(via, "via")
        return ArcMove(middle, self._goal(through["to"]), **options)

    def _dwell(self, value: Any, options: dict[str, Any]) -> Segment:
        only(options, ("label",))
        return Dwell(as_not_negative(self._number({"dwell": value}, "dwell"), "dwell"), **options)

    def _scene(self, value: Any) -> Path:
        if not isinstance(value, str) or not value:
            raise InputError(f'scene must name a file, such as "scene.toml"; got {shown(value)}')
        return self.file.parent / value

    def _start(self, value: Any) -> Goal:
        """Read a configuration; a target is refused."""
        if isinstance(value, dict) and "xyz" in value:
            raise InputError("start must be a configuration: a pose's name, the joints' values or { joint = value, … }")
        start = self._goal(value)
        self.arm.theta_from(start, name="start")  # type: ignore[arg-type]  # names every joint
        return start

    def _goal(self, value: Any) -> Goal:
        """Read a goal: a configuration's name, its numbers, {joint: value}, or a target by xyz."""
        if isinstance(value, str):
            self.arm.theta_from(value)  # says which there are
            return value
        per_joint = np.array([self.angle if unit == "rad" else 1.0 for unit in self.arm.units])
        if isinstance(value, list):
            return as_theta(value, self.arm.n, "a configuration", self.arm.joint_names) * per_joint
        if not isinstance(value, dict) or not value:
            raise InputError(f'a goal is "ready", {{ elbow = 0.5 }} or {{ xyz = [0.5, 0.0, 0.6] }}; got {shown(value)}')
        only(value, (*self.arm.joint_names, *GOAL))
        joints = [name for name in value if name in self.arm.joint_names]
        if not joints:
            return self._target(value)
        if len(joints) < len(value):
            raise InputError(f"a goal is a target or values of joints, not both; got {listed(value)}")
        factors = dict(zip(self.arm.joint_names, per_joint.tolist(), strict=True))
        return {joint: number(each, joint) * factors[joint] for joint, each in value.items()}

    def _target(self, table: Mapping[str, Any]) -> Pose | Position | Approach | TolerancedPose:
        only(table, GOAL)
        if "xyz" not in table:
            raise InputError(f"xyz is missing beside {listed(table)}: a target says where the tool is to be")
        p = vector(table["xyz"], "xyz")
        turned = [name for name in ("rpy", "quaternion_wxyz", "direction") if name in table]
        if len(turned) > 1:
            which = " or ".join(turned)
            raise InputError(f"give {which}, not both: a whole orientation, or only where the tool points")
        _needs(table, "tool_axis", ("direction",))
        _needs(table, "tolerance", ("rpy", "quaternion_wxyz"))
        _needs(table, "frame", ("tolerance",))
        if "direction" in table:
            tool_axis = vector(table["tool_axis"], "tool_axis") if "tool_axis" in table else None
            return Approach(p, vector(table["direction"], "direction"), tool_axis)
        if not turned:
            return Position(p)
        g = np.eye(4)
        g[:3, 3] = p
        if "rpy" in table:
            g[:3, :3] = from_rpy(self.angle * vector(table["rpy"], "rpy"))
        else:
            g[:3, :3] = from_quaternion_wxyz(table["quaternion_wxyz"])
        if "tolerance" not in table:
            return Pose(g)
        tolerance = as_reals(table["tolerance"], "tolerance")
        if tolerance.shape != (6,):
            raise InputError(
                "tolerance must be six numbers, along x, y and z and about them, inf where it is free; "
                f"got {shown(table['tolerance'])}"
            )
        return TolerancedPose(g, tolerance * np.repeat([1.0, self.angle], 3), table.get("frame", "target"))

    def _number(self, table: Mapping[str, Any], name: str) -> float:
        return number(table[name], name) * (self.angle if name in ANGLES else 1.0)


def _described(value: Any, needed: Sequence[str], others: Sequence[str]) -> Mapping[str, Any] | None:
    """The table of a move without a goal: all of `needed`, and any of `others`."""
    if not isinstance(value, dict) or not set(value) & {*needed, *others}:
        return None
    only(value, (*needed, *others))
    if missing := [name for name in needed if name not in value]:
        raise InputError(
            f"{' and '.join(missing)} {'are' if len(missing) > 1 else 'is'} missing beside {listed(value)}"
        )
    return value


def _present(table: Mapping[str, Any], *names: str) -> dict[str, Any]:
    return {name: table[name] for name in names if name in table}


def _needs(table: Mapping[str, Any], name: str, others: Sequence[str]) -> None:
    """Refuse an entry that has no meaning without one of the `others`."""
    if name in table and not set(others) & set(table):
        raise InputError(f"{name} goes with {' or '.join(others)}, and it is missing beside it")
