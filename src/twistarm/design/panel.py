"""panel.toml: tasks on a panel, and where the rover may park. A task has a place, a direction and a screw."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from ..description.companions.data_files import parse_toml
from ..ik.targets import Approach
from ..planning.segments import CONSTRAINED, ArcMove, Constrained, LineMove, Segment, as_label
from ..support.checks import Array, as_direction, as_flag, as_number, as_positive
from ..support.display import Brief
from ..support.errors import InputError, quote
from ..support.fields import Check, anything, fields, inside, list_of, one_of, vector, word
from ..support.files import as_path
from ..theory import screws

# The farthest place, longest travel and lead [m], most turns and tasks: beyond them units are wrong.
FAR, LONGEST, LEAD, TURNS, MOST_TASKS = 10.0, 1.0, 0.1, 20.0, 200

KINDS: dict[str, tuple[float, Constrained, bool]] = {
    "press": (1.0, "approach", True),
    "insert": (1.0, "pose", False),
    "pull": (-1.0, "pose", False),
    "turn": (0.0, "pose", False),
    "flip": (0.0, "approach", False),
    "screw": (0.0, "pose", False),
}
"""The sense of the travel along the direction (0: it turns), the default of `hold`, and that of `back`."""


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
        last = 0.0 if self.back else 1.0
        along = np.array([0.0, 0.0, 0.5, 1.0, last]) if self.hold != "position" else np.zeros(5)
        g = screws.exp(self.twist, along)
        places, directions = g[:, :3, :3] @ self.place + g[:, :3, 3], np.tile(self.direction, (len(g), 1))
        directions = g[:, :3, :3] @ self.direction if self.hold == "pose" else directions
        into = max(0.0, float((places[-1] - self.place) @ self.direction))  # so deep in the panel does the screw end
        places -= np.array([clearance, 0.0, 0.0, 0.0, clearance + into])[:, None] * directions
        return places, directions

    def moves(self, tool_axis: Array, clearance: float) -> list[Segment]:
        """From the configuration in front of the place: to it, along the screw, and away against the tool axis."""
        how: dict[str, Any] = {"turn": self.hold == "pose", "constrain": self.hold}
        places = self.checkpoints(clearance)[0]
        away = float(np.linalg.norm(places[-1] - places[1 if self.back else 3]))
        moves: list[Segment] = [LineMove(Approach(self.place, self.direction, tool_axis))]
        moves.append(ArcMove(None, None, twist=self.twist, label=self.name, **how))
        if self.back:
            moves.append(ArcMove(None, None, twist=-self.twist, **how))
        return [*moves, LineMove.by(-away * tool_axis, constrain="approach")]


@dataclass(frozen=True, eq=False, repr=False)
class Panel(Brief):
    """Tasks in the panel's frame (x right, y up, z out of it), its `pose` (4, 4) in the world, and where to park.

    The base of the arm is at x, y [m] and yaw [rad] in these ranges, at the height `z` [m]. `size` (3,) [m] makes
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
        """The pose (4, 4) in the world of an upright base at x, y [m] and yaw [rad]."""
        g: Array = screws.exp(np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), yaw)
        g[:3, 3] = x, y, self.z
        return g


def load_panel(path: str | os.PathLike[str]) -> Panel:
    """Read a panel.toml.

    Lengths are metres and angles radians, or degrees after `degrees = true`. Each `[[task]]` has a name, a kind, xyz in
    the panel's frame, and `travel` or `angle`. `[panel]` places the panel in the world, `[parking]` the arm's base.
    Raises InputError, with file, task and entry, for an entry that cannot be used. Raises DescriptionError for a file
    that cannot be read or is no TOML.
    """
    file = as_path(path)
    content = parse_toml(file, "a panel.toml")
    with inside(file):
        angle = partial(_angle, as_flag(content.get("degrees", False), "degrees"))
        place = {"x": _range(_length), "y": _range(_length), "yaw": _range(angle), "z": _length}
        optional: dict[str, Check] = {
            "degrees": as_flag, "clearance": _positive(LONGEST), "position_tol": _positive(LEAD),
            "orientation_tol": lambda value, name: as_positive(angle(value, name, 0.25), name),
            "panel": partial(fields, needed={}, optional=PLACED), "parking": partial(fields, needed={}, optional=place),
        }  # fmt: skip
        top = fields(content, "", {"task": list_of(anything, 1, MOST_TASKS)}, optional)
        frame = {"xyz": np.zeros(3), "normal": -np.eye(3)[0], "up": np.eye(3)[2], **top.get("panel", {})}
        z, g = frame["normal"], np.eye(4)
        across = np.cross(frame["up"], z)
        if np.linalg.norm(across) < 1e-6:  # six digits of its direction would be lost
            raise InputError("panel: normal and up are parallel; give an up that lies in the panel")
        x = across / np.linalg.norm(across)
        g[:3, :3], g[:3, 3] = np.stack([x, np.cross(z, x), z], axis=-1), frame["xyz"]
    tasks: dict[str, PanelTask] = {}
    for i, table in enumerate(top["task"]):
        with inside(file, f"task {i + 1}"):
            task = _task(table, angle)
            if task.name in tasks:
                raise InputError(f"name: another task is already called {task.name!r}; give each its own name")
            tasks[task.name] = task
    more = {name: frame[name] for name in ("size", "gap") if name in frame} | top.get("parking", {})
    tolerances: dict[str, float] = {name: top[name] for name in ("position_tol", "orientation_tol") if name in top}
    return Panel(tuple(tasks.values()), g, tolerances=tolerances, clearance=top.get("clearance", 0.05), **more)


def _task(value: Any, angle: Callable[..., float]) -> PanelTask:
    kind = one_of(tuple(KINDS))(value.get("kind") if isinstance(value, dict) else value, "kind")
    sense, hold, back = KINDS[kind]
    needed: dict[str, Check] = {"name": word, "kind": word, "xyz": _three(_length)}
    optional: dict[str, Check] = {"direction": _direction, "hold": one_of(CONSTRAINED), "back": as_flag}
    if sense:
        needed["travel"] = _positive(LONGEST)
    else:
        optional |= {"axis": _direction, "point": _three(_length)}
        turns = TURNS if kind == "screw" else 1.0
        needed["angle"] = lambda value, name: angle(value, name, turns)
        if kind == "screw":
            needed["lead"] = partial(_length, most=LEAD)
        if kind == "flip":
            needed["axis"] = _direction
    table = fields(value, f"a {kind}", needed, optional)
    place, direction = table["xyz"], table.get("direction", -np.eye(3)[2])
    if sense:
        twist = np.concatenate([sense * table["travel"] * direction, np.zeros(3)])
    else:
        axis, point = table.get("axis", direction), table.get("point", place)
        pitch = table.get("lead", 0.0) / (2.0 * np.pi)
        twist = table["angle"] * np.concatenate([np.cross(point, axis) + pitch * axis, axis])
        if not table["angle"]:
            raise InputError(f"angle must not be 0: give the angle to {kind} by")
    hold = table.get("hold", hold)
    if hold != "pose" and np.abs((screws.exp(twist) - np.eye(4)) @ np.append(place, 1.0)).max() < 1e-9:
        raise InputError('the tool stays where it is: give a point on the axis of the lever, or hold = "pose"')
    return PanelTask(as_label(table["name"]), kind, place, direction, twist, hold, table.get("back", back))


def _length(value: Any, name: str, most: float = FAR) -> float:
    metres = as_number(value, name)
    if abs(metres) > most:
        raise InputError(f"{name} is {metres:g} m, and at most {most:g} m are allowed: lengths are in metres")
    return metres


def _positive(most: float) -> Check:
    return lambda value, name: as_positive(_length(value, name, most), name)


def _three(check: Check) -> Check:
    return lambda value, name: np.array(list_of(check, 3, 3)(value, name))


def _direction(value: Any, name: str) -> Array:
    return as_direction(vector(value, name), name)


PLACED: dict[str, Check] = {
    "xyz": _three(_length), "normal": _direction, "up": _direction, "size": _three(_positive(FAR)), "gap": _length,
}  # fmt: skip
"""The entries of [panel]."""


def _range(check: Check) -> Check:
    """The check of a number, or of a range [least, greatest]."""

    def ends(value: Any, name: str) -> tuple[float, float]:
        lower, upper = list_of(check, 2, 2)(value if isinstance(value, list) else [value, value], name)
        if lower > upper:
            raise InputError(f"{name} must be a range [least, greatest], and {quote(value)} is empty: swap its ends")
        return lower, upper

    return ends


def _angle(degrees: bool, value: Any, name: str, turns: float = 1.0) -> float:
    angle = as_number(value, name) * (np.pi / 180.0 if degrees else 1.0)
    if abs(angle) > turns * 2.0 * np.pi * (1.0 + 1e-9):
        given, help_ = ("°", "") if degrees else (" radians", "; for degrees write degrees = true at the top")
        raise InputError(f"{name} is {value:g}{given}, and at most {turns:g} turns are allowed{help_}")
    return angle
