"""Cubes of space about an arm, and the sphere that holds every position of its tool."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import prod

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..support.checks import Array
from ..theory.screws import to_screw

TRIES = 81
"""Starts along the first axis, of which the one with the shortest path is taken."""


@dataclass(frozen=True)
class Grid:
    """Cubes of side `voxel` [m] along the base's axes. The cube of index i (3,) has its centre at (lower + i) voxel."""

    voxel: float
    lower: tuple[int, ...]
    shape: tuple[int, ...]

    @classmethod
    def about(cls, centre: Array, radius: float, voxel: float) -> Grid:
        """The smallest grid with every cube whose centre lies in a sphere."""
        lower = np.ceil((centre - radius) / voxel).astype(int)
        upper = np.floor((centre + radius) / voxel).astype(int)
        return cls(voxel, tuple(lower.tolist()), tuple(np.maximum(upper - lower + 1, 1).tolist()))

    @property
    def count(self) -> int:
        """The number of cubes."""
        return prod(self.shape)

    def centres(self, cells: NDArray[np.int64]) -> Array:
        """The centres (k, 3) [m] of cubes by their number (k,), x slowest."""
        return (np.column_stack(np.unravel_index(cells, self.shape)) + self.lower) * self.voxel

    def cells(self, p: Array) -> NDArray[np.int64]:
        """The numbers (...) of the cubes that hold points (..., 3) [m]; −1 outside the grid."""
        index = np.floor(p / self.voxel + 0.5).astype(np.int64) - self.lower
        inside = ((index >= 0) & (index < self.shape)).all(axis=-1)
        number = np.ravel_multi_index(tuple(np.moveaxis(index, -1, 0)), self.shape, mode="clip")
        return np.where(inside, number, -1)

    def along(self, axis: int) -> Array:
        """The centres [m] along an axis."""
        along: Array = (np.arange(self.shape[axis]) + self.lower[axis]) * self.voxel
        return along


def sphere(arm: Arm) -> tuple[Array, float]:
    """A centre (3,) and a radius [m]: no configuration brings the tool's origin farther from that point.

    A path leads from a point of the first turning axis over points of the next ones to the tool. Turning about an axis
    leaves the lengths of the path's parts. A slide or thread adds at most its travel, ±1 m where it has no limits.
    """
    v, w = arm.screws[:3], arm.screws[3:]
    size = np.linalg.norm(w, axis=0)
    turns = size > 1e-12
    advance = np.where(turns, np.abs((v * w).sum(axis=0)) / np.where(turns, size, 1.0), np.linalg.norm(v, axis=0))
    travel = float(advance @ np.abs(arm.coupling.A) @ np.abs(arm.sampling_bounds).max(axis=0))
    tool, axes = arm.home[:3, 3], [to_screw(xi) for xi in arm.screws[:, turns].T]
    if not axes:
        return tool, travel
    best: tuple[Array, float] = tool, np.inf
    for shift in np.linspace(-arm.reach, arm.reach, TRIES):
        path = [axes[0].point + axes[0].axis * (axes[0].axis @ (tool - axes[0].point) + shift)]
        for screw in axes[1:]:
            path.append(screw.point + screw.axis * (screw.axis @ (path[-1] - screw.point)))
        length = float(sum(np.linalg.norm(b - a) for a, b in pairwise([*path, tool])))
        best = min(best, (path[0], length + travel), key=lambda each: each[1])
    return best
