"""motion.toml: a motion as segments with start, kind and limits, and a first one for an arm."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..description.companions.data_files import parse_toml, toml_key
from ..ik.targets import Approach, Pose, Position, TolerancedPose
from ..support.checks import Array, as_flag, as_number, as_positive, as_theta, pose_of
from ..support.code_text import filled
from ..support.errors import InputError, listed, quote
from ..support.fields import Check, anything, fields, inside, list_of, numbers, one_of, only, table_of, vector, word
from ..support.files import as_path
from ..theory.rotations import from_quaternion_wxyz, from_rpy
from .keep import Keep
from .motion import LAWS
from .segments import ArcMove, Dwell, FreeMove, Goal, JointMove, LineMove, Move, ScrewMove, Segment
from .torque_limits import Load

# How far the first motion moves a joint from the ready configuration, or as far as its limits allow.
STEP = {"rad": 0.2, "m": 0.05}

KINDS = {"joint": JointMove, "free": FreeMove, "line": LineMove, "screw": ScrewMove, "arc": ArcMove, "dwell": Dwell}

WAYS: Mapping[str, list[tuple[Callable[..., Segment], tuple[str, ...], tuple[str, ...]]]] = {
    "line": [(LineMove.by, ("by",), ("frame", "constrain"))],
    "screw": [(ScrewMove.about, ("axis", "point", "angle"), ("pitch", "constrain"))],
    "arc": [(ArcMove.about, ("axis", "centre", "angle"), ("turn", "constrain")), (ArcMove, ("via", "to"), ())],
}
"""The moves of each kind that are given by a table other than a goal: what makes them, needed and optional entries."""

OPTIONS = tuple(option.name for option in dataclasses.fields(Move))
# Entries of a table `keep`, beside `level`, `rpy` and `quaternion_wxyz`.
KEPT = tuple(part.name for part in dataclasses.fields(Keep))

ROTATIONS = ("rpy", "quaternion_wxyz", "direction")

# Entries of a target that have no meaning without one of the others.
GO_WITH = {"tool_axis": ("direction",), "tolerance": ("rpy", "quaternion_wxyz"), "frame": ("tolerance",)}


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
    torques: bool = False
    payload: Load = 0.0
    scene: Path | None = None


def load_motion(path: str | os.PathLike[str], arm: Arm) -> MotionFile:
    """Read a motion.toml for an arm.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[segment]]` has a joint, free,
    line, screw, arc or dwell, and options of `Move`. `scene` names a scene file, seen from the folder of this one.

    Args:
        path: The file.
        arm: The arm. The file names its joints.

    Returns:
        The `MotionFile`.

    Raises:
        InputError: An entry cannot be used; the message names file, segment and entry.
        DescriptionError: The file cannot be read or is no TOML.
    """
    file = as_path(path)
    content = parse_toml(file, "a motion.toml")
    with inside(file, "at the top"):
        angle = np.pi / 180.0 if as_flag(content.get("degrees", False), "degrees") else 1.0
        reader = _Reader(arm, angle)
        top = fields(content, "", {"segment": list_of(anything, 1)}, reader.checks(("degrees", *SETTINGS)))
        arm.limits.with_(top.get("limits", {}), arm.joint_names)  # says what is wrong with them
    segments = []
    for i, entry in enumerate(top.pop("segment")):
        with inside(file, f"segment {i + 1}"):
            segments.append(reader.segment(entry))
    top.pop("degrees", None)
    if "scene" in top:
        top["scene"] = file.parent / top["scene"]
    return MotionFile(tuple(segments), **top)


SETTINGS = tuple(setting.name for setting in dataclasses.fields(MotionFile) if setting.name != "segments")


class _Reader:
    """Reads the tables of a motion.toml for an arm, with angles in units of `angle` [rad]."""

    def __init__(self, arm: Arm, angle: float) -> None:
        self.arm, self.angle = arm, angle
        self.known: dict[str, Check] = {
            **dict.fromkeys(("by", "axis", "point", "centre", "xyz", "direction", "tool_axis"), vector),
            **dict.fromkeys(("linear_speed", "position_tol"), as_positive),
            **dict.fromkeys(("angular_speed", "orientation_tol"), lambda value, name: angle * as_positive(value, name)),
            **dict.fromkeys(("degrees", "unwrap", "torques"), as_flag),
            **dict.fromkeys(("blend", "velocity_scaling", "pitch"), as_number),
            "angle": lambda value, name: angle * as_number(value, name),
            "rpy": lambda value, name: from_rpy(angle * vector(value, name)),
            "quaternion_wxyz": lambda value, _: from_quaternion_wxyz(value),
            "tolerance": self._tolerance,
            "keep": self._keep,
            "tol": lambda value, name: angle * as_positive(value, name),
            "via": self._via,
            "to": self._goal,
            "start": self._start,
            "kind": one_of(tuple(LAWS)),
            "limits": table_of(anything),
            "payload": _payload,
            "scene": word,
        }

    def checks(self, names: Iterable[str]) -> dict[str, Check]:
        """The checks of these entries. What has none is checked by the segment that takes it."""
        return {name: self.known.get(name, anything) for name in names}

    def segment(self, entry: Any) -> Segment:
        table = fields(entry, "", {}, dict.fromkeys(KINDS, anything) | self.checks((*OPTIONS, "keep")))
        kinds = [kind for kind in KINDS if kind in table]
        if len(kinds) != 1:
            raise InputError(f"it needs one of {', '.join(KINDS)}; got {listed(kinds) or 'none of them'}")
        (kind,) = kinds
        value = table.pop(kind)
        if "keep" in table and kind != "free":
            raise InputError(f"keep goes with free; a {kind} takes its own way")
        if kind == "dwell":
            only(table, ("label",))
            return Dwell(as_number(value, kind, least=0.0), **table)
        for make, needed, others in WAYS.get(kind, ()):
            if isinstance(value, dict) and value.keys() & {*needed, *others}:
                way = fields(value, kind, self.checks(needed), self.checks(others))
                first = [way.pop("by")] if "by" in way else []  # whose name in Python is `offset`
                return make(*first, **way, **table)
        if kind == "arc":
            raise InputError(f"arc takes via and to, or axis, centre and angle; got {quote(value)}")
        return KINDS[kind](self._goal(value, kind), **table)

    def _keep(self, value: Any, name: str) -> Keep:
        """Read what a free move keeps. `true` for what is so at the start."""
        of_start = {part for part in KEPT if isinstance(value, dict) and value.get(part) is True}
        known = self.checks(part for part in KEPT if part not in of_start) | dict.fromkeys(of_start, anything)
        table = fields(value, name, {}, known | self.checks(("rpy", "quaternion_wxyz", "level")))
        given = [entry for entry in ("orientation", "rpy", "quaternion_wxyz") if entry in table]
        if len(given) > 1:
            raise InputError(f"give {' or '.join(given)}, not both")
        if given:
            table["orientation"] = table.pop(given[0])
        if not as_flag(table.pop("level", False), "level"):
            return Keep(**table)
        if table.keys() & {"direction", "tool_axis"}:
            raise InputError("level = true means direction = [0, 0, 1] and tool_axis = true: give one of them")
        return dataclasses.replace(Keep.level(), **table)

    def _via(self, value: Any, name: str) -> Goal:
        return self._target(value, name) if isinstance(value, dict) else vector(value, name)

    def _start(self, value: Any, name: str) -> Goal:
        """Read a configuration; a target is refused."""
        if isinstance(value, dict) and "xyz" in value:
            raise InputError("start must be a configuration: its name, the joints' values or { joint = value, … }")
        start = self._goal(value, name)
        self.arm.theta_from(start, name="start")  # type: ignore[arg-type]  # names every joint
        return start

    def _goal(self, value: Any, name: str) -> Goal:
        """Read a goal: a configuration's name, its numbers, {joint: value}, or a target by xyz."""
        names = self.arm.joint_names
        if isinstance(value, str):
            self.arm.theta_from(value)  # says which there are
            return value
        sizes = np.array([self.angle if unit == "rad" else 1.0 for unit in self.arm.units])
        if isinstance(value, list):
            return as_theta(value, self.arm.n, "a configuration", names) * sizes
        if not isinstance(value, dict) or not value:
            raise InputError(f'a goal is "ready", {{ elbow = 0.5 }} or {{ xyz = [0.5, 0.0, 0.6] }}; got {quote(value)}')
        if "xyz" in value or not value.keys() & {*names}:
            return self._target(value, name)
        only(value, names)
        return {joint: as_number(entry, joint) * sizes[names.index(joint)] for joint, entry in value.items()}

    def _target(self, value: Any, name: str) -> Pose | Position | Approach | TolerancedPose:
        table = fields(value, name, self.checks(("xyz",)), self.checks((*ROTATIONS, *GO_WITH)))
        rotations = [entry for entry in ROTATIONS if entry in table]
        if len(rotations) > 1:
            which = " or ".join(rotations)
            raise InputError(f"give {which}, not both: a whole orientation, or only where the tool points")
        for entry, others in GO_WITH.items():
            if entry in table and not table.keys() & {*others}:
                raise InputError(f"{entry} goes with {' or '.join(others)}, and it is missing beside it")
        if "direction" in table:
            return Approach(table["xyz"], table["direction"], table.get("tool_axis"))
        if not rotations:
            return Position(table["xyz"])
        g = pose_of(table[rotations[0]], table["xyz"])
        if "tolerance" not in table:
            return Pose(g)
        return TolerancedPose(g, table["tolerance"], table.get("frame", "target"))

    def _tolerance(self, value: Any, name: str) -> Array:
        six = numbers(value, f"{name}, along x, y and z and about them, inf where it is free,", 6, least=0.0, most=inf)
        return np.array(six) * np.repeat([1.0, self.angle], 3)


def _payload(value: Any, name: str) -> Load:
    """Read a mass [kg], or { mass, offset } with its place in tool axes [m]."""
    if not isinstance(value, dict):
        return as_number(value, name, least=0.0)
    table = fields(value, name, {"mass": partial(as_number, least=0.0), "offset": vector}, {})
    return table["mass"], table["offset"]


def draft_motion_file(arm: Arm) -> str:
    """Return the text of a motion.toml for this arm, with every kind of segment."""
    x, y, z = np.round(arm.fk(arm.ready)[:3, 3], 3).tolist()
    steps = np.array([STEP[unit] for unit in arm.units])
    moved = np.clip(arm.ready + steps, arm.limits.lower, arm.limits.upper)
    j = int(np.argmax(np.round((moved - arm.ready) / steps, 9)))  # the first that can take its step
    value = float(np.floor(1e3 * moved[j]) / 1e3)
    template = Path(__file__).parent / "files" / "motion.toml.in"
    return filled(template, arm=arm.name, joint=toml_key(arm.joint_names[j]), value=value, x=x, y=y, z=z)
