"""What is drawn of an arm: at once what needs no file, then its meshes one after the other."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

from ..arm import Arm
from . import drawing
from .axes import arm_size, draw_rods, draw_screws
from .links import Drawn, count_meshes, draw_meshes, draw_plain, lost_meshes
from .nodes import link_path


class Scene:
    """Messages that draw the arm once, in order; the node of each link; what could not be drawn, in words.

    Whatever moves has a node of its own: a configuration is then one matrix per node, {path: (4, 4) by columns}.
    `objects` only ever grows, by `draw`, whichever thread calls it; the first `plain` of them are no meshes.
    """

    def __init__(self, arm: Arm) -> None:
        drawing.require_meshcat()
        size = arm_size(arm)
        self.objects = [*draw_screws(arm), *_frames(size)]
        self.links: dict[str, str] = {}
        self.notes: tuple[str, ...] = ()
        self.left = 0
        self._lock = threading.Lock()
        self._meshes: Iterator[Drawn] = iter(())
        if arm.description is None:
            self.objects += draw_rods(arm)
        else:
            self.objects += draw_plain(arm.description, size)
            self.links = {name: link_path(name) for name in arm.description.links}
            self.notes = lost_meshes(arm.description)
            self.left = count_meshes(arm.description)
            self._meshes = draw_meshes(arm.description, size)
        self.plain = len(self.objects)

    def draw(self) -> bool:
        """Draw the next mesh; False where none is left."""
        with self._lock:
            piece = next(self._meshes, None)
            if piece is None:
                return False
            self.objects += piece.objects
            self.notes += piece.notes
            self.left -= 1
            return True

    def whole(self) -> Scene:
        """The same, with every mesh."""
        more = True
        while more:
            more = self.draw()
        return self

    def message(self) -> dict[str, Any]:
        """How much there is to draw: objects so far, and meshes that are still to be read."""
        return {"type": "scene", "objects": len(self.objects), "left": self.left, "notes": list(self.notes)}


def build_scene(arm: Arm) -> Scene:
    """Draw `arm`, meshes included: a node per link, a node per screw, and the space and tool frames.

    A mesh that was not found or cannot be read is noted, and a frame and capsules stand in for it; a link with nothing
    to draw is a capsule from its origin to each joint that it carries. An arm without a description is drawn as rods
    between the points of its axes.
    """
    return Scene(arm).whole()


def _frames(size: float) -> list[bytes]:
    return [*drawing.triad("/frames/space", 0.16 * size), *drawing.triad("/frames/tool", 0.16 * size)]
