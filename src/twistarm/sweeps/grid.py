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

STARTS = 81
"""Points of the first axis, of which the one with the shortest path to the tool is taken."""


@dataclass(frozen=True)
class Grid:
    """Cubes of side `voxel` [m] along the base's axes. The cube of index i (3,) has its centre at (lower + i) voxel."""

    voxel: float
    lower: tuple[int, ...]
    shape: tuple[int, ...]

    @classmethod
    def about(cls, centre: Array, radius: float, voxel: float) -> Grid:
        """The smallest grid that holds a sphere."""
        lower, upper = (np.floor((centre + end) / voxel + 0.5) for end in (-radius, radius))
        return cls(voxel, tuple(map(int, lower)), tuple(map(int, upper - lower + 1)))

    @property
    def count(self) -> int:
        """The number of cubes."""
        return prod(self.shape)

    def centres(self, cells: NDArray[np.int64]) -> Array:
        """The centres (k, 3) [m] of cubes by their numbers (k,), z fastest."""
        return np.array(self.voxel * (np.column_stack(np.unravel_index(cells, self.shape)) + self.lower))

    def cells(self, p: Array) -> NDArray[np.int64]:
        """The numbers (...) of the cubes that hold points (..., 3) [m]; −1 outside the grid."""
        index = np.floor(p / self.voxel + 0.5) - self.lower
        inside = np.logical_and.reduce((index >= 0) & (index < self.shape), axis=-1)
        plain = np.where(inside[..., None], index, 0).astype(np.int64)
        return np.where(inside, np.ravel_multi_index(tuple(np.moveaxis(plain, -1, 0)), self.shape), -1)

    def along(self, axis: int) -> Array:
        """The centres [m] along an axis."""
        return np.array(self.voxel * np.arange(self.lower[axis], self.lower[axis] + self.shape[axis]))


def sphere(arm: Arm) -> tuple[Array, float]:
    """A centre (3,) and a radius [m] of a sphere that the tool's origin never leaves.

    A path leads from a point of the first turning axis by points of the others to the tool. Turning about an axis keeps
    the lengths of its parts. A slide or thread adds at most its travel, ±1 m without limits.
    """
    v, w = arm.screws[:3], arm.screws[3:]
    size = np.linalg.norm(w, axis=0)
    turns = size > 0.0
    advance = np.where(turns, np.abs((v * w).sum(axis=0)) / np.where(turns, size, 1.0), np.linalg.norm(v, axis=0))
    travel = float(advance @ np.abs(arm.coupling.A) @ np.abs(arm.sampling_bounds).max(axis=0))
    tool, axes = arm.home[:3, 3], [to_screw(xi) for xi in arm.screws[:, turns].T]
    best = (tool, np.inf if axes else 0.0)
    for shift in np.linspace(-arm.reach, arm.reach, STARTS) if axes else ():
        path = [axes[0].point + (axes[0].axis @ (tool - axes[0].point) + shift) * axes[0].axis]
        for screw in axes[1:]:
            path.append(screw.point + (screw.axis @ (path[-1] - screw.point)) * screw.axis)
        length = float(sum(np.linalg.norm(b - a) for a, b in pairwise([*path, tool])))
        best = min(best, (path[0], length), key=lambda each: each[1])
    return best[0], best[1] + travel
