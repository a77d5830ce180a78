"""The first collision of a planned motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arm.arm import Arm
from ..collision import Scene, require_scene
from ..support.checks import Array
from .cartesian.refusal import PathError
from .trajectory import Trajectory


@dataclass(frozen=True, eq=False)
class Hit:
    """A collision of a motion: on the way to waypoint `leg` + 1, at `theta` (n,), in words."""

    leg: int
    theta: Array
    words: str

    def __str__(self) -> str:
        return self.words


def first_collision(scene: Scene, motion: Trajectory) -> Hit | None:
    """The first collision of a motion, or None."""
    found = scene.first_collision(motion.breakpoints, motion.coefficients)
    if found is None:
        return None
    leg = int(np.clip(np.searchsorted(motion.times, found.time, side="right") - 1, 0, max(len(motion.times) - 2, 0)))
    pairs = ", ".join(map(str, found.contacts[:2])) or "a near miss"
    return Hit(leg, found.theta, f"it collides {found.time:.2f} s after the start: {pairs}")


def require_free(scene: Scene, arm: Arm, motion: Trajectory) -> None:
    """Raise PathError if a motion through waypoints collides; a start in collision may be left."""
    hit = first_collision(require_scene(scene, arm).leaving(motion.waypoints[0]), motion)
    if hit is not None:
        place = f"the way from waypoint {hit.leg} to {hit.leg + 1} (counted from 0)"
        raise PathError(
            f"{hit}; add waypoints round it", theta=hit.theta, reason="collision", segment=hit.leg, place=place
        )
