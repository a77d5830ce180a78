"""An arm drawn as a line from axis to axis."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...support.checks import Array

PARALLEL = 1e-9
"""The squared length of a unit twist's turn that counts as zero."""


@dataclass(frozen=True)
class Sketch:
    """Corners at theta = 0, (k, 3), base to tool, and the moving joint that carries each (0: none), (k,).

    A revolute joint's corner is the point of its axis nearest to the corner before. A slide repeats that corner.
    What is before the corner of the `first` revolute joint is the mount.
    """

    corners: Array
    carriers: np.ndarray[tuple[int, ...], np.dtype[np.intp]]
    first: int

    def at(self, motions: Array) -> Array:
        """The corners (..., k, 3) for what each joint has undergone, (..., m + 1, 4, 4), the identity first."""
        moved = motions[..., self.carriers, :, :]
        placed: Array = np.einsum("...ij,...j->...i", moved[..., :3, :3], self.corners) + moved[..., :3, 3]
        return placed

    @cached_property
    def size(self) -> float:
        """Length of the stretched arm from its first axis to the tool [m]; 1 m for an arm without length."""
        return float(np.linalg.norm(np.diff(self.corners[self.first :], axis=0), axis=1).sum()) or 1.0


def sketched(screws: Array, tool: Array) -> Sketch:
    """The sketch of a chain of `screws` (6, m) to a tool with origin `tool` (3,) at theta = 0."""
    corners, carriers = [np.zeros(3)], [0]
    turning = np.sum(screws[3:] ** 2, axis=0) > PARALLEL
    for i, (v, w) in enumerate(screws.T.reshape(-1, 2, 3)):
        corner = corners[-1]
        if turning[i]:
            on_axis = np.cross(w, v) / (w @ w)
            corner = on_axis + w * ((corner - on_axis) @ w) / (w @ w)
        corners.append(corner)
        carriers.append(i + 1)
    return Sketch(np.array([*corners, tool]), np.array([*carriers, len(carriers) - 1]), 1 + int(np.argmax(turning)))
