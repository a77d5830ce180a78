"""Cubes of space about an arm, and the sphere that holds every position of its tool."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..ik import Position
from ..ik.reach_ball import reach_ball
from ..support.checks import Array


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
    """The centre (3,) and radius [m] of a sphere that the tool's origin never leaves, slides without limits by ±1 m."""
    _, centre, radius = reach_ball(arm, Position([0.0] * 3), arm.sampling_bounds)
    return centre, radius
