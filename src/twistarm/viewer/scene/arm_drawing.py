"""The drawing of an arm: screws, rods and links without files first, then its meshes one by one."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...limits.joint_limits import slides
from ...support.checks import Array
from ...support.files import stamp
from ...theory import poe
from ...theory.lines import axis_points
from ...theory.screws import to_screw
from . import drawing
from .drawing import STICK, Colour, link_path, rod_path, screw_path
from .links import MeshDrawing, Read, count_meshes, draw_meshes, draw_plain, missing_meshes

BESIDE = "/beside"  # The node that carries all of a second arm.


class Drawing:
    """An arm's drawing: messages in order, the node of each link, and failures.

    Everything that moves has a node. So a configuration is one matrix per node, {path: (4, 4) by columns}. `draw`
    appends to `objects`, from any thread. The first `plain` objects are not meshes, and replaced ones are empty. Meshes
    with more triangles than a screen shows are simplified unless `exact`. `simplified`: whether any was.

    A second arm `beside` is drawn below its node.

    An unreadable mesh is reported. A frame and simple shapes replace it. These are the link's collision shapes, or
    capsules from its origin to its joints. An arm without a description is drawn as rods between points of its axes.
    """

    def __init__(self, arm: Arm, exact: bool = False, read: Read | None = None, beside: Arm | None = None) -> None:
        """read: meshes that are not read again."""
        drawing.require_meshcat()
        self.exact, self.simplified = exact, False
        self._description, self._size, self._beside = arm.description, arm_size(arm), beside
        frames = [*drawing.triad("/frames/space", 0.16 * self._size), *drawing.axes("/frames/tool", 0.11 * self._size)]
        self.objects = [*draw_screws(arm), *frames, *_plain(arm)]
        self.links: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()
        self._read = {} if read is None else read
        self._places: dict[str, range] = {}  # in `objects`, of each mesh drawn
        self._meshes: Iterator[MeshDrawing]
        self._turn, self._lock = threading.Lock(), threading.Lock()
        if arm.description is not None:
            self.links = {name: link_path(name) for name in arm.description.links}
            self.notes = missing_meshes(arm.description)
        if beside is not None:
            self.objects += [drawing.below(BESIDE, part) for part in _plain(beside)]
            self.notes += () if beside.description is None else missing_meshes(beside.description)
        self.plain = len(self.objects)
        self._begin()

    def _begin(self) -> None:
        self.left, self._meshes = 0, iter(())
        if self._description is not None:
            self.left = count_meshes(self._description)
            self._meshes = draw_meshes(self._description, self._size, self.exact, self._read)
        if self._beside is not None and (other := self._beside.description) is not None:
            self.left += count_meshes(other)
            pieces = draw_meshes(other, arm_size(self._beside), self.exact, self._read)
            self._meshes = chain(self._meshes, map(_below, pieces))

    def successor(self, arm: Arm) -> Drawing:
        """The drawing of another arm. Unchanged files are not read again."""
        unchanged = {key: parts for key, parts in list(self._read.items()) if stamp(key[0]) == key[1]}
        return Drawing(arm, self.exact, unchanged)

    def draw_again(self, exact: bool) -> None:
        """Draw the meshes again, with all triangles or simplified.

        Returns at once and drops the results of pending reads.
        """
        with self._lock:
            if exact != self.exact:
                self.exact, self._read = exact, {}
            self._begin()

    def draw(self) -> bool:
        """Draw the next mesh. False where none is left."""
        with self._turn:  # one reads at a time
            with self._lock:
                meshes = self._meshes
            piece = next(meshes, None)  # without the lock, because reading a mesh may take seconds
            with self._lock:
                restarted = meshes is not self._meshes
                if piece is not None and not restarted:
                    self._add(piece)
                return restarted or piece is not None

    def _add(self, piece: MeshDrawing) -> None:
        """Replace the last drawing of a mesh. It stays if the mesh cannot be read."""
        self.left -= 1
        self.simplified = self.simplified or not piece.exact
        if piece.note and piece.note not in self.notes:
            self.notes += (piece.note,)
        if piece.node in self._places and not piece.readable:
            return
        for place in self._places.get(piece.node, ()):
            self.objects[place] = b""
        self._places[piece.node] = range(len(self.objects), len(self.objects) + len(piece.objects))
        self.objects += piece.objects

    def close(self) -> None:
        """Draw no further mesh. From any thread."""
        with self._lock:
            self.left, self._meshes = 0, iter(())

    def whole(self) -> Drawing:
        """The same, with every mesh."""
        while self.draw():
            pass
        return self

    def message(self) -> dict[str, Any]:
        """Progress of the drawing: objects so far, meshes left, and whether all triangles are drawn."""
        return {
            "type": "scene",
            "objects": sum(map(bool, self.objects)),
            "left": self.left,
            "exact": self.exact,
            "simplified": self.simplified,
            "notes": list(self.notes),
        }


def _plain(arm: Arm) -> list[bytes]:
    return draw_rods(arm) if arm.description is None else draw_plain(arm.description, arm_size(arm))


def _below(piece: MeshDrawing) -> MeshDrawing:
    """A mesh of the second arm, below its node."""
    objects = tuple(drawing.below(BESIDE, part) for part in piece.objects)
    return replace(piece, node=BESIDE + piece.node, objects=objects)


# screws and rods, which need no description ------------------------------------------------------------

KIND_COLOURS: dict[str, Colour] = {
    "revolute": (0.85, 0.15, 0.58, 1.0),
    "prismatic": (0.05, 0.60, 0.65, 1.0),
    "helical": (0.78, 0.57, 0.06, 1.0),
}
"""Colours of screws: without pitch, of infinite pitch (a slide), any other. The page's legend repeats them."""

AXIS_HALF = 0.18  # Half the arrow along an axis, in sizes of the arm.
PITCHLESS = 1e-9  # A pitch below this share of the arm's size counts as 0.


def arm_size(arm: Arm) -> float:
    """A length [m] that scales axes and frames: the reach, or the tool's distance without turning joints."""
    far = max(arm.reach, float(np.linalg.norm(arm.home[:3, 3])))
    return far if far > 1e-6 else 1.0


def anchors(arm: Arm, theta: Array | None = None) -> Array:
    """A point (m, 3) on each moving joint's axis at theta (n,), 0 by default.

    It is the origin of the joint's link. Without a description it is the point of the axis nearest to the last one.
    """
    x = np.zeros(arm.n) if theta is None else theta
    if arm.description is not None:
        poses = arm.poses(x)
        return np.array([poses[arm.description.joints[name].child][:3, 3] for name in arm.moving_names])
    return axis_points(poe.spatial_jacobian(arm.screws, arm.coupling.A @ x), np.zeros(3))


def screw_kinds(arm: Arm) -> list[str]:
    """`revolute`, `prismatic` or `helical` for each moving joint, by the pitch of its screw."""
    size = arm_size(arm)
    pitches = [float(to_screw(xi).pitch) for xi in arm.screws.T]
    return ["prismatic" if np.isinf(h) else "revolute" if abs(h) < PITCHLESS * size else "helical" for h in pitches]


def draw_screws(arm: Arm) -> list[bytes]:
    """An arrow along each axis at theta = 0. The joint's partial product carries it."""
    objects: list[bytes] = []
    size = arm_size(arm)
    for i, (xi, anchor, kind) in enumerate(zip(arm.screws.T, anchors(arm), screw_kinds(arm), strict=True)):
        half, path = AXIS_HALF * size * to_screw(xi).axis, f"{screw_path(i)}/axis"
        objects += drawing.arrow(path, anchor - half, anchor + half, 0.0055 * size, KIND_COLOURS[kind])
    return objects


def draw_rods(arm: Arm) -> list[bytes]:
    """Rods between axes at theta = 0, each in its joint's node, and a rail under each slide."""
    size = arm_size(arm)
    points = [np.zeros(3), *anchors(arm), arm.home[:3, 3]]
    paths = ["/arm/rod:base", *(rod_path(i) for i in range(arm.screws.shape[1]))]
    objects: list[bytes] = []
    for path, start, end in zip(paths, points[:-1], points[1:], strict=True):
        objects.append(drawing.sphere(f"{path}/origin", 0.02 * size, STICK, drawing.at(start)))
        if np.linalg.norm(end - start) > 1e-3 * size:
            objects.append(drawing.rod(f"{path}/rod", start, end, 0.012 * size, STICK))
    lower, upper = (np.clip(arm.coupling.A @ bound, -size, size) for bound in arm.sampling_bounds)
    for i, kind in enumerate(screw_kinds(arm)):
        if slides(kind):
            axis = to_screw(arm.screws[:, i]).axis
            ends = points[i + 1] + lower[i] * axis, points[i + 1] + upper[i] * axis
            objects.append(drawing.rod(f"{paths[i]}/rail", *ends, 0.006 * size, STICK))
    return objects
