"""panel.toml: tasks on a panel, each a place, a direction and a screw of the tool, and where the rover may park."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..description.companions.toml_entries import parse_toml
from ..ik.targets import Approach
from ..planning.segments import CONSTRAINED, ArcMove, Constrained, LineMove, Segment, as_label
from ..support.checks import Array, as_direction, as_positive, require_choice, require_mapping
from ..support.display import Brief
from ..support.errors import InputError, listed, shown
from ..support.fields import flag, inside, number, only, vector
from ..support.files import as_path
from ..theory import screws

FAR, LONGEST, LEAD, TURNS, MOST_TASKS = 10.0, 1.0, 0.1, 20.0, 200
"""The farthest place, longest travel and lead [m], most turns and tasks: beyond them units are wrong."""

KINDS: dict[str, tuple[float, Constrained, bool]] = {
    "press": (1.0, "approach", True),
    "insert": (1.0, "pose", False),
    "pull": (-1.0, "pose", False),
    "turn": (0.0, "pose", False),
    "flip": (0.0, "approach", False),
    "screw": (0.0, "pose", False),
}
"""The sense of the travel along the direction (0: it turns), the default of `hold`, and that of `back`."""

TASK, TOLERANCES = ("name", "kind", "xyz"), ("position_tol", "orientation_tol")


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

    def checkpoints(self, clearance: float) -> tuple[Array, Array]:
        """Places and directions (5, 3) of the tool: in front, at the place, half-way, at the end, and away from it.

        With hold="position", in front and at the place alone.
        """
        g = screws.exp(self.twist, np.array([0.0, 0.0, 0.5, 1.0, 1.0 - self.back]) * (self.hold != "position"))
        places, directions = g[:, :3, :3] @ self.place + g[:, :3, 3], np.tile(self.direction, (len(g), 1))
        directions = g[:, :3, :3] @ self.direction if self.hold == "pose" else directions
        into = max(0.0, float((places[-1] - self.place) @ self.direction))  # the tool stands so far in the panel
        places -= np.array([clearance, 0.0, 0.0, 0.0, clearance + into])[:, None] * directions
        return places, directions

    def moves(self, tool_axis: Array, clearance: float) -> list[Segment]:
        """From the configuration in front of the place: to it, along the screw, and away against the tool axis."""
        how: dict[str, Any] = {"turn": self.hold == "pose", "constrain": self.hold}
        places = self.checkpoints(clearance)[0]
        away = float(np.linalg.norm(places[-1] - places[1 if self.back else 3]))
        moves: list[Segment] = [LineMove(Approach(self.place, self.direction, tool_axis))]
        moves += [ArcMove(None, None, twist=self.twist, label=self.name, **how)]
        moves += [ArcMove(None, None, twist=-self.twist, **how)] * self.back
        return [*moves, LineMove.by(-away * tool_axis, constrain="approach")]


@dataclass(frozen=True, eq=False, repr=False)
class Panel(Brief):
    """Tasks in the panel's frame (x right, y up, z out of it), its `pose` (4, 4) in the world, and where to park.

    The base of the arm stands at x, y [m] and yaw [rad] in these ranges, at the height `z` [m]. `size` (3,) [m] makes
    the panel a box, `gap` [m] behind z = 0. The tool goes straight through the last `clearance` [m] before a place.
    `tolerances` are `position_tol` [m] and `orientation_tol` [rad] of `plan`.
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
    tolerances: Mapping[str, float] = field(default_factory=dict)

    def base_at(self, x: float, y: float, yaw: float) -> Array:
        """The pose (4, 4) in the world of an arm's base that stands upright at x, y [m] and yaw [rad]."""
        g: Array = screws.exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), yaw)
        g[:3, 3] = x, y, self.z
        return g


def load_panel(path: str | os.PathLike[str]) -> Panel:
    """Read a panel.toml.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[task]]` has a name, a kind, xyz in
    the panel's frame, and `travel` or `angle`. `[panel]` places the panel in the world, `[parking]` the arm's base.
    Raises InputError, with file, task and entry, for an entry that cannot be used, and DescriptionError for a file that
    cannot be read or is no TOML.
    """
    file = as_path(path)
    content = parse_toml(file, "a panel.toml")
    with inside(file, "at the top"):
        only(content, ("degrees", "clearance", "panel", "parking", "task", *TOLERANCES))
        unit = np.pi / 180.0 if flag(content.get("degrees", False), "degrees") else 1.0
        met = {name: as_positive(_length(content, name, most=LEAD), name) for name in TOLERANCES[:1] if name in content}
        angles = {name: _angle(content[name], name, unit, 0.25) for name in TOLERANCES[1:] if name in content}
        met |= {name: as_positive(angle, name) for name, angle in angles.items()}
        clearance = as_positive(_length(content, "clearance", 0.05, LONGEST), "clearance")
        tables = content.get("task", [])
        if not isinstance(tables, list) or not 0 < len(tables) <= MOST_TASKS:
            raise InputError(f"a panel has 1 to {MOST_TASKS} tasks: write [[task]] with name, kind, xyz and so on")
    with inside(file, "panel"):
        found = _placed(require_mapping(content.get("panel", {}), "panel", "{ xyz = [1.0, 0.0, 0.8] }"))
    with inside(file, "parking"):
        found |= _parking(require_mapping(content.get("parking", {}), "parking", "{ x = [-1.0, 0.0] }"), unit)
    tasks: dict[str, PanelTask] = {}
    for i, table in enumerate(tables):
        with inside(file, f"task {i + 1}"):
            task = _task(require_mapping(table, "a task", '{ name = "key A" }'), unit)
            if task.name in tasks:
                raise InputError(f"name: another task is already called {task.name!r}; give each its own name")
            tasks[task.name] = task
    return Panel(tuple(tasks.values()), **found, clearance=clearance, tolerances=met)


def _placed(table: Mapping[str, Any]) -> dict[str, Any]:
    only(table, ("xyz", "normal", "up", "size", "gap"))
    given = {"xyz": [0.0] * 3, "normal": [-1.0, 0.0, 0.0], "up": [0.0, 0.0, 1.0], **table}
    z, up = (as_direction(vector(given[name], name), name) for name in ("normal", "up"))
    across, g = np.cross(up, z), np.eye(4)
    if np.linalg.norm(across) < 1e-6:
        raise InputError("normal and up must not be parallel: of a panel that lies flat, say which side is up")
    x = across / np.linalg.norm(across)
    g[:3, :3], g[:3, 3] = np.stack([x, np.cross(z, x), z], axis=-1), _lengths(given, "xyz")
    size = _lengths(table, "size") if "size" in table else None
    if size is not None and not (size > 0.0).all():
        raise InputError(f"size must be width, height and depth above 0; got {shown(table['size'])}")
    return {"pose": g, "size": size, "gap": _length(table, "gap", 0.03)}


def _parking(table: Mapping[str, Any], unit: float) -> dict[str, Any]:
    only(table, ("x", "y", "yaw", "z"))
    found: dict[str, Any] = {"z": _length(table, "z", 0.0)}
    for name in ("x", "y", "yaw"):
        value = table.get(name, 0.0)
        ends = value if isinstance(value, list) else [value, value]
        if len(ends) != 2:
            raise InputError(f"{name} must be a number or a range [least, greatest]; got {shown(value)}")
        lower, upper = (_angle(end, name, unit) if name == "yaw" else _length({name: end}, name) for end in ends)
        if lower > upper:
            raise InputError(f"{name} must be a range [least, greatest], and {shown(value)} is empty: swap its ends")
        found[name] = lower, upper
    return found


def _task(table: Mapping[str, Any], unit: float) -> PanelTask:
    if missing := [name for name in TASK if name not in table]:
        raise InputError(f"it lacks {listed(missing)}: a task has a name, a kind and xyz")
    name, kind = as_label(table["name"]), require_choice(table["kind"], KINDS, "kind")
    sense, hold, back = KINDS[kind]
    needed = ("travel",) if sense else ("angle", *{"screw": ("lead",), "flip": ("axis",)}.get(kind, ()))
    only(table, (*TASK, "direction", "hold", "back", *needed, *(() if sense else ("axis", "point"))))
    if not name.strip() or (missing := [each for each in needed if each not in table]):
        raise InputError(f"a {kind} lacks {listed(missing) if name.strip() else 'a name'}")
    direction = as_direction(vector({"direction": [0.0, 0.0, -1.0], **table}["direction"], "direction"), "direction")
    place = _lengths(table, "xyz")
    if sense:
        travel = as_positive(_length(table, "travel", most=LONGEST), "travel")
        twist = np.concatenate([sense * travel * direction, np.zeros(3)])
    else:
        angle = _angle(table["angle"], "angle", unit, TURNS if kind == "screw" else 1.0)
        if not angle:
            raise InputError(f"angle must not be 0: by how far to {kind}")
        axis = as_direction(vector(table["axis"], "axis"), "axis") if "axis" in table else direction
        point = _lengths(table, "point") if "point" in table else place
        pitch = _length(table, "lead", 0.0, LEAD) / (2.0 * np.pi)
        twist = angle * np.concatenate([np.cross(point, axis) + pitch * axis, axis])
    held: Any = require_choice(table.get("hold", hold), CONSTRAINED, "hold")
    if held != "pose" and np.abs((screws.exp(twist) - np.eye(4)) @ np.append(place, 1.0)).max() < 1e-9:
        raise InputError('the tool stays where it is: give a point on the axis of the lever, or hold = "pose"')
    return PanelTask(name, kind, place, direction, twist, held, flag(table.get("back", back), "back"))


def _length(table: Mapping[str, Any], name: str, default: float = 0.0, most: float = FAR) -> float:
    if abs(metres := number(table.get(name, default), name)) > most:
        raise InputError(f"{name} is {metres:g} m, and at most {most:g} m are allowed: lengths are in metres")
    return metres


def _lengths(table: Mapping[str, Any], name: str) -> Array:
    return np.array([_length({name: value}, name) for value in vector(table[name], name).tolist()])


def _angle(value: Any, name: str, unit: float, turns: float = 1.0) -> float:
    angle = number(value, name) * unit
    if abs(angle) > turns * 2.0 * np.pi * (1.0 + 1e-9):
        said, help_ = ("°", "") if unit != 1.0 else (" radians", "; for degrees write degrees = true at the top")
        raise InputError(f"{name} is {value:g}{said}, and at most {turns:g} turns are allowed{help_}")
    return angle
