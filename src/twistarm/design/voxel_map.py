"""`ReachMap`: the share of tool directions that an arm reaches in each cube of a grid."""

from __future__ import annotations

import hashlib
import io
import json
import os
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, as_number, as_vector, require_choice
from ..support.errors import InputError, missing_extra, one_line
from ..support.files import as_path, open_regular, why_no_file, writable, write_whole

FORMAT = "twistarm reach map 1"

LARGEST = 1e6  # The largest side of a cube [m] in a file.

ARRAYS = ("directions", "counts", "manipulability", "margin")


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


@dataclass(frozen=True, eq=False, repr=False)
class ReachMap:
    """What an arm reaches in each cube of `grid`, in the frame `frame`, the arm's base.

    `counts` (nx, ny, nz) are the numbers of `directions` (N, 3) reached. Without directions N = 1 is the position
    alone. `manipulability` is the greatest Yoshikawa measure of the configurations found, as of `arm.manipulability`.
    `margin` [rad, m] is the greatest of their least distances of a joint from its limits, inf without limits. Both are
    NaN where nothing is reached. `settings` say how the map was made, and `digest` identifies its arm.
    """

    name: str
    frame: str
    digest: str
    grid: Grid
    directions: Array
    counts: NDArray[np.uint16]
    manipulability: NDArray[np.float32]
    margin: NDArray[np.float32]
    settings: dict[str, Any]

    def __repr__(self) -> str:
        return f"ReachMap({self.name}: {self.grid.shape} cubes of {self.grid.voxel:g} m, {self.volume:.3g} m³ reached)"

    @property
    def share(self) -> Array:
        """The share of the directions reached, (nx, ny, nz) in [0, 1]."""
        return np.array(self.counts / max(len(self.directions), 1))

    @property
    def volume(self) -> float:
        """The volume [m³] of the cubes in which something is reached."""
        return float(np.count_nonzero(self.counts) * self.grid.voxel**3)

    def at(self, p: ArrayLike) -> Array:
        """The share in [0, 1] of the cubes that hold points (..., 3) [m], (...); 0 outside the grid."""
        cells = self.grid.cells(as_vector(p, "p"))
        return np.where(cells >= 0, self.counts.reshape(-1)[cells] / max(len(self.directions), 1), 0.0)

    def slice(self, axis: str, at: float) -> Array:
        """The share in the layer of cubes that holds a plane, over the other two axes in order.

        Args:
            axis: The axis across the plane: "x", "y" or "z".
            at: The place of the plane along it [m].

        Raises:
            InputError: There is no such axis, or the plane is outside the grid.
        """
        k = "xyz".index(require_choice(axis, ("x", "y", "z"), "axis"))
        along, i = self.grid.along(k), int(np.floor(as_number(at, "at") / self.grid.voxel + 0.5)) - self.grid.lower[k]
        if not 0 <= i < len(along):
            raise InputError(f"at must be from {along[0]:g} to {along[-1]:g} m along {axis}; got {at:g}")
        return np.array(np.take(self.share, i, axis=k))

    def require(self, arm: Arm) -> ReachMap:
        """The map, or InputError if it is one of another arm: other axes, coupling, tool or limits."""
        if digest_of(require_arm(arm)) != self.digest:
            raise InputError(
                f"the map belongs to another arm ({self.name}); make one of {arm.name} by reach_map or twistarm reach"
            )
        return self

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the map as .npz, whole or not at all. The same map gives the same bytes. Returns the path."""
        head = {name: getattr(self, name) for name in ("name", "frame", "digest", "settings")}
        head |= {"format": FORMAT, "voxel": self.grid.voxel, "lower": self.grid.lower}
        file = io.BytesIO()
        np.savez_compressed(file, head=np.array(json.dumps(head)), **{name: getattr(self, name) for name in ARRAYS})
        return write_whole(path, file.getvalue())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ReachMap:
        """Read a map that `save` wrote. InputError for any other file."""
        name = as_path(path)
        try:
            with open_regular(name) as file, np.load(file, allow_pickle=False) as content:
                head, arrays = json.loads(str(content["head"])), {array: content[array] for array in ARRAYS}
            if head.pop("format") != FORMAT:
                raise ValueError(f"its format is not {FORMAT!r}")
            grid = Grid(float(head.pop("voxel")), tuple(map(int, head.pop("lower"))), arrays["counts"].shape)
            most = max(len(arrays["directions"]), 1)
            fits = arrays["counts"].dtype == np.uint16 and arrays["directions"].shape[1:] == (3,)
            fits &= all(arrays[array].shape == grid.shape and arrays[array].dtype == np.float32 for array in ARRAYS[2:])
            fits &= 0.0 < grid.voxel < LARGEST and len(grid.lower) == len(grid.shape) == 3 and grid.count > 0
            if not (fits and arrays["counts"].max() <= most):
                raise ValueError("its arrays do not fit each other")
            return cls(grid=grid, **head, **arrays)
        except OSError as error:
            raise InputError(f"{name}: {why_no_file(name, error)}; give a map that `save` wrote") from error
        except Exception as error:  # of zipfile, zlib, NumPy and its tokenizer, json: of any kind in a damaged file
            raise InputError(f"{name} is no reach map ({one_line(str(error), 80)}); save writes one") from error

    def to_png(self, path: str | os.PathLike[str]) -> Path:
        """Write a picture of the slices across x, y and z in which most is reached. Returns the path.

        Raises MissingExtraError without matplotlib.
        """
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise missing_extra("a picture of a map", "matplotlib", "guide") from error
        path = writable(path)  # before it is drawn
        figure, half = Figure(layout="constrained", figsize=(12, 4.2)), 0.5 * self.grid.voxel
        for k, ax in enumerate(figure.subplots(1, 3)):
            across, up = (i for i in range(3) if i != k)
            at = float(self.grid.along(k)[self.counts.sum(axis=(across, up), dtype=np.int64).argmax()])
            ends = [end for i in (across, up) for end in self.grid.along(i)[[0, -1]] + [-half, half]]
            share = np.ma.masked_equal(100.0 * self.slice("xyz"[k], at), 0.0)
            drawn = ax.imshow(share.T, origin="lower", extent=ends, vmin=0.0, vmax=100.0)
            ax.set(title=f"{'xyz'[k]} = {at:.3g} m", xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]")
        figure.colorbar(drawn, ax=figure.axes, label="directions reached [%]")
        figure.suptitle(f"{self.name}: reach in the frame {self.frame}", parse_math=False)
        file = io.BytesIO()
        figure.savefig(file, format="png")
        return write_whole(path, file.getvalue())


def digest_of(arm: Arm) -> str:
    """`sha256:…` of what decides an arm's reach, rounded to nine decimals."""
    numbers = arm.screws, arm.home, arm.coupling.A, arm.limits.lower, arm.limits.upper
    parts = [arm.base, arm.tip, arm.joint_names, *((np.round(values, 9) + 0.0).tolist() for values in numbers)]
    return f"sha256:{hashlib.sha256(json.dumps(parts).encode()).hexdigest()}"
