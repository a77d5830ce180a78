"""panel.toml: tasks on a panel, each a place, a direction and a screw of the tool, and where the rover may park."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from ..description.companions.toml_entries import parse_toml
from ..ik.targets import Approach
from ..planning.motion_file import ANGLES, SHARED
from ..planning.segments import CONSTRAINED, ArcMove, Constrained, LineMove, Segment, as_label
from ..support.checks import Array, as_direction, as_flag, as_positive, require_choice, require_mapping
from ..support.display import Brief
from ..support.entries import at, only, real, three
from ..support.errors import InputError, listed, shown
from ..support.files import as_path
from ..theory import screws

FAR, LONGEST, LEAD, TURNS = 10.0, 1.0, 0.1, 20.0
"""The farthest place, the longest travel and lead of a screw [m], and its most turns: beyond them units are wrong."""

MOST_TASKS = 200


class Kind(NamedTuple):
    """What a word means: the sense of its travel along the direction (0: it turns), what is held, the way back."""

    sense: float
    hold: Constrained
    back: bool


KINDS = {
    "press": Kind(1.0, "approach", True),
    "insert": Kind(1.0, "pose", False),
    "pull": Kind(-1.0, "pose", False),
    "turn": Kind(0.0, "pose", False),
    "flip": Kind(0.0, "approach", False),
    "screw": Kind(0.0, "pose", False),
}
TOP = ("degrees", "clearance", "panel", "parking", "task")
PANEL, PARKING, TASK = ("xyz", "normal", "up", "size", "gap"), ("x", "y", "yaw", "z"), ("name", "kind", "xyz")
OPTIONS = ("direction", "hold", "back")


@dataclass(frozen=True, eq=False, repr=False)
class PanelTask(Brief):
    """The tool touches `place` (3,) [m], points along `direction` (3,), and its origin moves by the screw `twist` (6,).

    p(s) = exp(s ξ̂) p with the twist ξ, s from 0 to 1 (MLS §2.3.3). With hold="pose" the tool holds the thing and turns
    with it: g(s) = exp(s ξ̂) g0. With "approach" it pushes and keeps its direction, with "position" not even that.
    `back` leads it back along the screw.
    """

    name: str
    kind: str
    place: Array
    direction: Array
    twist: Array
    hold: Constrained
    back: bool

    def seen_from(self, g: Array) -> PanelTask:
        """The task in another frame, in which its own has the pose g (4, 4)."""
        place, direction = g[:3, :3] @ self.place + g[:3, 3], g[:3, :3] @ self.direction
        return replace(self, place=place, direction=direction, twist=screws.adjoint(g) @ self.twist)

    @property
    def into(self) -> float:
        """How far the tool ends beyond the place along its direction [m], 0 if before it."""
        end = screws.exp(self.twist, 1.0 - self.back)
        return max(0.0, float((end[:3, :3] @ self.place + end[:3, 3] - self.place) @ self.direction))

    def checkpoints(self, clearance: float) -> tuple[Array, Array]:
        """Places and directions (5, 3) of the tool: in front, at the place, half-way, at the end, and away from it.

        With hold="position", in front and at the place alone.
        """
        g = screws.exp(self.twist, np.array([0.0, 0.0, 0.5, 1.0, 1.0 - self.back]) * (self.hold != "position"))
        places, directions = g[:, :3, :3] @ self.place + g[:, :3, 3], np.tile(self.direction, (len(g), 1))
        directions = g[:, :3, :3] @ self.direction if self.hold == "pose" else directions
        places -= np.array([clearance, 0.0, 0.0, 0.0, clearance + self.into])[:, None] * directions
        return places, directions

    def moves(self, tool_axis: Array, clearance: float) -> list[Segment]:
        """From the configuration in front of the place: to it, along the screw, and away against the tool axis."""
        how: dict[str, Any] = {"turn": self.hold == "pose", "constrain": self.hold}
        moves: list[Segment] = [LineMove(Approach(self.place, self.direction, tool_axis))]
        moves += [ArcMove(None, None, twist=self.twist, label=self.name, **how)]
        moves += [ArcMove(None, None, twist=-self.twist, **how)] * self.back
        return [*moves, LineMove.by(-(clearance + self.into) * tool_axis, constrain="approach")]


@dataclass(frozen=True, eq=False, repr=False)
class Panel(Brief):
    """Tasks in the panel's frame (x right, y up, z out of it), its `pose` (4, 4) in the world, and where to park.

    The base of the arm stands at x, y [m] and yaw [rad] in these ranges, at the height `z` [m]. `size` (3,) [m] makes
    the panel a box, `gap` [m] behind z = 0. The tool goes straight through the last `clearance` [m] before a place.
    `shared` are speeds and tolerances for `plan`.
    """

    tasks: tuple[PanelTask, ...]
    pose: Array
    size: Array | None = None
    gap: float = 0.03
    clearance: float = 0.05
    x: tuple[float, float] = (0.0, 0.0)
    y: tuple[float, float] = (0.0, 0.0)
    yaw: tuple[float, float] = (0.0, 0.0)
    z: float = 0.0
    shared: Mapping[str, float] = field(default_factory=dict)

    def base_at(self, x: float, y: float, yaw: float) -> Array:
        """The pose (4, 4) in the world of an arm's base that stands upright at x, y [m] and yaw [rad]."""
        g: Array = screws.exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), yaw)
        g[:3, 3] = x, y, self.z
        return g


def load_panel(path: str | os.PathLike[str]) -> Panel:
    """Read a panel.toml.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[task]]` has a name, a kind, xyz in
    the panel's frame, and `travel` or `angle`. `[panel]` places the panel in the world, `[parking]` the arm's base.

    Args:
        path: The file.

    Returns:
        The `Panel`.

    Raises:
        InputError: An entry cannot be used; the message names file, task and entry.
        DescriptionError: The file cannot be read or is no TOML.
    """
    file = as_path(path)
    content = parse_toml(file, "a panel.toml")
    with at(file, "at the top"):
        only(content, (*TOP, *SHARED))
        unit = np.pi / 180.0 if as_flag(content.get("degrees", False), "degrees") else 1.0
        units = {name: unit if name in ANGLES else 1.0 for name in SHARED if name in content}
        shared = {name: as_positive(real(content[name], name), name) * unit for name, unit in units.items()}
        clearance = as_positive(_length(content.get("clearance", 0.05), "clearance", LONGEST), "clearance")
        tables = content.get("task", [])
        if not isinstance(tables, list) or not 0 < len(tables) <= MOST_TASKS:
            raise InputError(
                f"a panel has 1 to {MOST_TASKS} tasks: write [[task]] and under it name, kind, xyz and so on"
            )
    with at(file, "panel"):
        placed = _placed(require_mapping(content.get("panel", {}), "panel", "{ xyz = [1.0, 0.0, 0.8] }"))
    with at(file, "parking"):
        parking = _parking(require_mapping(content.get("parking", {}), "parking", "{ x = [-1.0, 0.0] }"), unit)
    tasks: dict[str, PanelTask] = {}
    for i, table in enumerate(tables):
        with at(file, f"task {i + 1}"):
            task = _task(require_mapping(table, "a task", '{ name = "key A" }'), unit)
            if task.name in tasks:
                raise InputError(f"name: another task is already called {task.name!r}; give each its own name")
            tasks[task.name] = task
    return Panel(tuple(tasks.values()), **placed, **parking, clearance=clearance, shared=shared)


def _placed(table: Mapping[str, Any]) -> dict[str, Any]:
    """The pose (4, 4) by the normal and the direction up, and the box."""
    only(table, PANEL)
    given = {"xyz": [0.0] * 3, "normal": [-1.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0], **table}
    z, up = (as_direction(three(given, name), name) for name in ("normal", "up"))
    across = np.cross(up, z)
    if np.linalg.norm(across) < 1e-6:
        raise InputError("normal and up must not be parallel: of a panel that lies flat, say which side is up")
    x = across / np.linalg.norm(across)
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = np.stack([x, np.cross(z, x), z], axis=-1), _lengths(given, "xyz")
    size = _lengths(table, "size") if "size" in table else None
    if size is not None and not (size > 0.0).all():
        raise InputError(f"size must be width, height and depth above 0; got {shown(table['size'])}")
    return {"pose": g, "size": size, "gap": _length(table.get("gap", 0.03), "gap")}


def _parking(table: Mapping[str, Any], unit: float) -> dict[str, Any]:
    """The ranges of x, y and yaw, and the height z."""
    only(table, PARKING)
    found: dict[str, Any] = {"z": _length(table.get("z", 0.0), "z")}
    for name in ("x", "y", "yaw"):
        value = table.get(name, 0.0)
        ends = value if isinstance(value, list) else [value, value]
        if len(ends) != 2:
            raise InputError(f"{name} must be a number or a range [least, greatest]; got {shown(value)}")
        lower, upper = (_angle(end, name, unit) if name == "yaw" else _length(end, name) for end in ends)
        if lower > upper:
            raise InputError(f"{name} must be a range [least, greatest], and {shown(value)} is empty: swap its ends")
        found[name] = lower, upper
    return found


def _task(table: Mapping[str, Any], unit: float) -> PanelTask:
    if missing := [name for name in TASK if name not in table]:
        raise InputError(f"it lacks {listed(missing)}: a task has a name, a kind and xyz")
    name = as_label(table["name"])
    if not name.strip():
        raise InputError("name must not be empty")
    word = require_choice(table["kind"], KINDS, "kind")
    kind, lead = KINDS[word], ("lead",) * (word == "screw")
    how = ("travel",) if kind.sense else ("angle", "axis", "point", *lead)
    only(table, (*TASK, *OPTIONS, *how))
    if missing := [each for each in (how[0], *lead, *(("axis",) * (word == "flip"))) if each not in table]:
        raise InputError(f"a {word} lacks {listed(missing)}")
    direction = as_direction(three({"direction": [0.0, 0.0, -1.0], **table}, "direction"), "direction")
    place = _lengths(table, "xyz")
    if kind.sense:
        travel = as_positive(_length(table["travel"], "travel", LONGEST), "travel")
        twist = np.concatenate([kind.sense * travel * direction, np.zeros(3)])
    else:
        angle = _angle(table["angle"], "angle", unit, TURNS if lead else 1.0)
        if not angle:
            raise InputError(f"angle must not be 0: by how far to {word}")
        axis = as_direction(three(table, "axis"), "axis") if "axis" in table else direction
        point = _lengths(table, "point") if "point" in table else place
        advance = _length(table["lead"], "lead", LEAD) / (2.0 * np.pi) if lead else 0.0
        twist = angle * np.concatenate([np.cross(point, axis) + advance * axis, axis])
    hold: Any = require_choice(table.get("hold", kind.hold), CONSTRAINED, "hold")
    task = PanelTask(name, word, place, direction, twist, hold, as_flag(table.get("back", kind.back), "back"))
    if hold != "pose" and np.abs(screws.exp(twist) @ np.append(place, 1.0) - np.append(place, 1.0)).max() < 1e-9:
        raise InputError('the tool stays where it is: give a point on the axis of the lever, or hold = "pose"')
    return task


def _length(value: Any, name: str, most: float = FAR) -> float:
    """A length [m] of at most so much."""
    if abs(metres := real(value, name)) > most:
        raise InputError(f"{name} is {metres:g} m, and at most {most:g} m are allowed: lengths are in metres")
    return metres


def _lengths(table: Mapping[str, Any], name: str) -> Array:
    """Three lengths [m]."""
    return np.array([_length(value, name) for value in three(table, name).tolist()])


def _angle(value: Any, name: str, unit: float, turns: float = 1.0) -> float:
    """An angle [rad] of at most so many turns."""
    angle = real(value, name) * unit
    if abs(angle) > turns * 2.0 * np.pi * (1.0 + 1e-9):
        help_ = "" if unit != 1.0 else "; for degrees write degrees = true at the top"
        raise InputError(f"{name} is {angle:g} rad, and at most {turns:g} turns are allowed{help_}")
    return angle
