"""Additions of a program: drawings in the scene; sliders, buttons and lines of text in the panel."""

from __future__ import annotations

import base64
import logging
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from traceback import extract_tb
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ...support.checks import Array, Progress, as_floats, as_pose, as_positive, require_one
from ...support.errors import InputError, one_line, quote, unknown_name
from ..jobs import Job
from ..messages import LARGEST_VALUE, Message, as_name
from ..scene import drawing
from ..scene.drawing import BLUE, Colour, drawn_path
from .show import Part, Route, Show

MOST_ROWS = 200_000  # Most points or triangles of one drawing. More would hold up the pages.


class Draw:
    """Drawing in the scene: `viewer.draw`.

    A drawing replaces the one of the same name. Poses (4, 4) and points (N, 3) are in base axes [m]. A colour is
    (r, g, b) or (r, g, b, opacity), each from 0 to 1. Calls return at once, from any thread. Called faster than pages
    can draw, the latest wins. Drawings stay when another arm is loaded.

    Raises InputError for an argument that cannot be drawn, or once the view is closed.
    """

    def __init__(self, put: Callable[[Message], None]) -> None:
        self._put = put

    def frame(self, name: str, pose: ArrayLike, length: float = 0.1) -> None:
        """Draw a frame at `pose` with axes of `length` [m]: x red, y green, z blue."""
        g, size = _pose(pose), as_positive(length, "length")
        self._draw(name, lambda path: [drawing.transform(path, g), *drawing.triad(path, size)])

    def arrow(
        self, name: str, start: ArrayLike, end: ArrayLike, colour: ArrayLike = BLUE, radius: float = 0.006
    ) -> None:
        """Draw an arrow from `start` to `end` (3,), none without a length. A short one is thinner than `radius`."""
        (p,), (q,), tint = _rows([start], "start"), _rows([end], "end"), _colour(colour)
        way = float(np.linalg.norm(q - p))
        thick = min(as_positive(radius, "radius"), way / 12.0)
        self._draw(name, lambda path: drawing.arrow(path, p, q, thick, tint) if way > 0.0 else [])

    def points(self, name: str, points: ArrayLike, colour: ArrayLike = BLUE, size: float = 0.01) -> None:
        """Draw points (N, 3) as squares of `size` [m], in one colour or in colours (N, 3)."""
        p, edge = _rows(points, "points"), as_positive(size, "size")
        tints = _shares(colour)
        if tints.shape[:-1] != (len(p),):
            tints = np.tile(_colour(colour), (len(p), 1))
        self._draw(name, lambda path: [drawing.points(path, p, tints[:, :3], edge)] if len(p) else [])

    def line(self, name: str, points: ArrayLike, colour: ArrayLike = BLUE, radius: float = 0.003) -> None:
        """Draw a line through points (N, 3), `radius` [m] thick. None without a length."""
        p, tint, thick = _rows(points, "points"), _colour(colour), as_positive(radius, "radius")
        self._draw(name, lambda path: [drawing.tube(path, p, thick, tint)] if np.diff(p, axis=0).any() else [])

    def box(self, name: str, size: ArrayLike, pose: ArrayLike | None = None, colour: ArrayLike = BLUE) -> None:
        """Draw a box with edges `size` (3,) [m], its middle at `pose` or in the base."""
        (edges,), g, tint = _rows([size], "size"), _pose(pose), _colour(colour)
        if not (edges > 0.0).all():
            raise InputError(f"size must be positive; got {edges.tolist()}")
        self._draw(name, lambda path: [drawing.box(path, edges.tolist(), tint, g)])

    def mesh(
        self, name: str, vertices: ArrayLike, faces: ArrayLike, pose: ArrayLike | None = None, colour: ArrayLike = BLUE
    ) -> None:
        """Draw flat triangles: vertices (N, 3) in the axes of `pose`, and their indices (F, 3)."""
        v, f, g, tint = _rows(vertices, "vertices"), _rows(faces, "faces"), _pose(pose), _colour(colour)
        if f.size and not (np.isin(f, np.arange(len(v))).all()):
            raise InputError(f"faces must be indices of the {len(v)} vertices, whole numbers from 0 on")
        corners = v[f.astype(int)].reshape(-1, 3, 3)
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
        order, flat = np.arange(corners.size // 3).reshape(-1, 3), corners.reshape(-1, 3)
        self._draw(
            name,
            lambda path: [drawing.triangles(path, flat, np.repeat(normals, 3, 0), order, tint, g)] if len(f) else [],
        )

    def text(self, name: str, text: str, position: ArrayLike) -> None:
        """Write `text` at `position` (3,), over the scene and always to be read."""
        (at,) = _rows([position], "position")
        self._draw(name, lambda path: [], {"words": as_name(text, "text"), "at": at.tolist()})

    def remove(self, name: str) -> None:
        """Remove the drawing of this name. Harmless without one."""
        self._draw(name, lambda path: [])

    def _draw(self, name: str, draw: Callable[[str], list[bytes]], text: Message | None = None) -> None:
        node = drawn_path(as_name(name, "name"))
        objects = [base64.b64encode(content).decode("ascii") for content in draw(node)]
        self._put({"type": "drawn", "node": node, "objects": objects, "text": text})


def _pose(pose: ArrayLike | None) -> Array:
    g = require_one(as_pose(np.eye(4) if pose is None else pose), "pose", 2)
    _rows(g[:3, 3:].T, "place of the pose")
    return g


def _rows(values: Any, name: str) -> Array:
    rows = as_floats(values, name)
    if rows.ndim != 2 or rows.shape[1] != 3 or len(rows) > MOST_ROWS:
        raise InputError(f"{name} must be rows of 3 numbers, at most {MOST_ROWS:,}; got shape {rows.shape}")
    if np.abs(rows).max(initial=0.0) > LARGEST_VALUE:
        raise InputError(f"{name} must be at most {LARGEST_VALUE:g} in size; got {np.abs(rows).max():g}")
    return rows


def _shares(colour: ArrayLike) -> Array:
    shares = as_floats(colour, "colour")
    if shares.ndim == 0 or shares.shape[-1] not in (3, 4) or (shares < 0.0).any() or (shares > 1.0).any():
        raise InputError(f"colour must be (r, g, b) or (r, g, b, opacity), each from 0 to 1; got {quote(colour)}")
    return shares


def _colour(colour: ArrayLike) -> Colour:
    red, green, blue, opacity = [*require_one(_shares(colour), "colour", 1).tolist(), 1.0][:4]
    return red, green, blue, opacity


V = TypeVar("V")

LOG = logging.getLogger("twistarm")  # Without other settings, Python prints errors of it in the terminal.


class Control(Generic[V]):
    """A slider, a button or a text on the pages, for use from any thread."""

    def __init__(
        self,
        name: str,
        value: V,
        check: Callable[[V], V],
        post: Callable[[str, Callable[[Any], None]], None],
        call: Callable[..., object] | None = None,
        ends: tuple[float, float] | None = None,
    ) -> None:
        """post: changes the stage as `Server.post` does. ends: of a slider."""
        self.name, self.ends, self.error = name, ends, ""
        self._check, self._post, self._call = check, post, call
        self._value = self._known = check(value)
        post(f"control {name}", lambda stage: stage.controls.by_name.update({name: self}))

    @property
    def value(self) -> V:
        """A slider's number, or a text. Setting it shows it on all pages, without a call of `on_change`."""
        return self._value

    @value.setter
    def value(self, value: V) -> None:
        self._value = self._known = self._check(value)
        self._post("value", lambda stage: None)

    def remove(self) -> None:
        """Remove it from the pages. Harmless when repeated."""
        self._post(f"control {self.name}", lambda stage: stage.controls.drop(self))

    def take(self, value: Any) -> None:
        """Take a value from a page. The program does not know it yet."""
        if self.ends is None:
            raise InputError(f"{self.name} is not a slider")
        self._value = self._check(value)

    def call(self) -> None:
        """Call the program unless it knows the value. Its error becomes one line."""
        value, known, self._known = self._value, self._known, self._value
        if self._call is None or (self.ends and value == known):
            return
        try:
            self._call(*([value] if self.ends else []))
            self.error = ""
        except (Exception, SystemExit) as error:  # a callback that calls exit() must not end the thread
            at = "".join(
                f" ({Path(frame.filename).name}, line {frame.lineno})" for frame in extract_tb(error.__traceback__)[1:2]
            )
            self.error = one_line(f"{type(error).__name__}: {error}{at}")
            LOG.error("%s", one_line(f"{self.name}: {self.error}"))

    def entry(self) -> dict[str, Any]:
        """The control for the pages. A button has no value."""
        return {"name": self.name, "value": self._value, "ends": self.ends, "error": self.error}


class Controls(Part):
    """The controls in the order of the program, and those that wait for their callback."""

    def __init__(self) -> None:
        self.by_name: dict[str, Control[Any]] = {}
        self.waiting: deque[Control[Any]] = deque()
        self.routes = {"slide": Route(self._slide), "press": Route(self._press)}

    def take_over(self, other: Controls) -> None:
        """Show the controls of another arm's view."""
        self.by_name, self.waiting = other.by_name, other.waiting

    def drop(self, control: Control[Any]) -> None:
        """Remove a control, unless another has replaced it."""
        if self.by_name.get(control.name) is control:
            del self.by_name[control.name]

    def _slide(self, show: Show, now: float, name: str, value: float) -> Job:
        self._named(name).take(value)
        return self._press(show, now, name)

    def _press(self, show: Show, now: float, name: str) -> Job:
        """The job calls the program, one callback at a time, in order."""
        self.waiting.append(self._named(name))
        return Job("controls", "calling the program", self._call, lambda result: None)

    def _named(self, name: str) -> Control[Any]:
        if name not in self.by_name:
            raise unknown_name("control", name, self.by_name, within="the view", listing=", ".join(self.by_name))
        return self.by_name[name]

    def messages(self, show: Show) -> Iterator[Message]:
        """The controls."""
        yield {"type": "controls", "controls": [control.entry() for control in self.by_name.values()]}

    def _call(self, progress: Progress) -> None:
        while self.waiting:
            self.waiting.popleft().call()
