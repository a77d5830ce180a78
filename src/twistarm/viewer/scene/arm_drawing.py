"""The drawing of an arm: parts without files first, then its meshes one by one."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import chain
from typing import Any

from ...arm.arm import Arm
from . import drawing
from .axes import arm_size, draw_rods, draw_screws
from .drawing import link_path
from .links import Drawn, Source, count_meshes, draw_meshes, draw_plain, lost_meshes

BESIDE = "/beside"
"""The node that carries all of a second arm."""


class Drawing:
    """An arm's drawing: messages in order, the node of each link, and failures.

    Everything that moves has a node. So a configuration is one matrix per node, {path: (4, 4) by columns}. `draw`
    appends to `objects`, from any thread. The first `plain` objects are not meshes, and replaced ones are empty. Meshes
    with more triangles than a screen shows are simplified unless `exact`. `simplified`: whether any was.

    `live` are the objects of a second arm `beside`, below its node. Saved pages leave them out.

    An unreadable mesh is reported. A frame and simple shapes replace it: the link's collision shapes, or capsules from
    its origin to the joints that it carries. An arm without a description is drawn as rods between points of its axes.
    """

    def __init__(
        self, arm: Arm, exact: bool = False, known: Mapping[Source, Drawn] | None = None, beside: Arm | None = None
    ) -> None:
        """known: drawn meshes, which are not read again."""
        drawing.require_meshcat()
        self._known = dict(known or {})
        self.exact, self.simplified = exact, False
        self._description, self._size, self._beside = arm.description, arm_size(arm), beside
        self.objects = [*draw_screws(arm), *_frames(self._size), *_plain(arm)]
        self.links: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()
        self.live: frozenset[bytes] = frozenset()
        self._pieces: dict[str, Drawn] = {}  # by node
        self._places: dict[str, range] = {}  # in `objects`, of each mesh drawn
        self._meshes: Iterator[Drawn]
        self._turn, self._lock = threading.Lock(), threading.Lock()
        if arm.description is not None:
            self.links = {name: link_path(name) for name in arm.description.links}
            self.notes = lost_meshes(arm.description)
        if beside is not None:
            self._draw_live([drawing.below(BESIDE, each) for each in _plain(beside)])
            self.notes += () if beside.description is None else lost_meshes(beside.description)
        self.plain = len(self.objects)
        self._begin()

    def _begin(self) -> None:
        self.left, self._meshes = 0, iter(())
        if self._description is not None:
            self.left = count_meshes(self._description)
            self._meshes = draw_meshes(self._description, self._size, self.exact, self._known)
        if self._beside is not None and (other := self._beside.description) is not None:
            self.left += count_meshes(other)
            pieces = draw_meshes(other, arm_size(self._beside), self.exact, {})
            self._meshes = chain(self._meshes, map(_below, pieces))

    def successor(self, arm: Arm) -> Drawing:
        """The drawing of another arm. Unchanged files are not read again."""
        return Drawing(arm, self.exact, {piece.source: piece for piece in self._pieces.values() if piece.drawn})

    def draw_again(self, exact: bool) -> None:
        """Draw the meshes again, with all triangles or simplified.

        Returns at once and drops the results of pending reads.
        """
        with self._lock:
            self.exact = exact
            self._begin()

    def draw(self) -> bool:
        """Draw the next mesh; False where none is left."""
        with self._turn:  # one reads at a time
            with self._lock:
                meshes = self._meshes
            piece = next(meshes, None)
            with self._lock:
                anew = meshes is not self._meshes
                if piece is not None and not anew:
                    self._add(piece)
                return anew or piece is not None

    def _add(self, piece: Drawn) -> None:
        self._replace(piece)
        self.simplified = self.simplified or not piece.exact
        if piece.note and piece.note not in self.notes:
            self.notes += (piece.note,)
        self.left -= 1

    def _draw_live(self, drawn: Iterable[bytes]) -> None:
        self.objects += drawn
        self.live |= {*drawn}

    def close(self) -> None:
        """Draw no further mesh. From any thread."""
        with self._lock:
            self.left, self._meshes = 0, iter(())

    def _replace(self, piece: Drawn) -> None:
        if piece.node in self._places and not piece.drawn:
            return  # what was read before is better than nothing
        for place in self._places.get(piece.node, ()):
            self.objects[place] = b""
        self._places[piece.node] = range(len(self.objects), len(self.objects) + len(piece.objects))
        if piece.node.startswith(BESIDE):
            return self._draw_live(piece.objects)
        self._pieces[piece.node] = piece
        self.objects += piece.objects

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


def _frames(size: float) -> list[bytes]:
    return [*drawing.triad("/frames/space", 0.16 * size), *drawing.axes("/frames/tool", 0.11 * size)]


def _plain(arm: Arm) -> list[bytes]:
    return draw_rods(arm) if arm.description is None else draw_plain(arm.description, arm_size(arm))


def _below(piece: Drawn) -> Drawn:
    """A mesh of the second arm, below its node."""
    drawn = tuple(drawing.below(BESIDE, each) for each in piece.objects)
    return replace(piece, node=BESIDE + piece.node, objects=drawn)
