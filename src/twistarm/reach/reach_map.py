"""`ReachMap`: the share of tool directions that an arm reaches in each cube of space."""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, as_number, as_vector, require_choice
from ..support.errors import InputError, missing_extra, one_line
from ..support.files import as_path, read_bounded, write_whole
from .grid import Grid

FORMAT = "twistarm reach map 1"

MAX_BYTES = 2**36
"""Of a map's file."""

Quantity = NDArray[np.float32]


@dataclass(frozen=True, eq=False, repr=False)
class ReachMap:
    """What an arm reaches in each cube of `grid`, in the frame `frame`, the arm's base.

    `counts` (nx, ny, nz) are the numbers of `directions` (N, 3) reached at the cube's centre; without directions N = 1
    stands for the position alone. `manipulability` is the best Yoshikawa measure among the configurations found, as
    `arm.manipulability` gives it. `margin` [rad, m] is the best of their least distances of a joint from its limits,
    inf where no joint has limits. Both are NaN in a cube without a configuration.

    `settings` say how the map was made. `digest` tells the arm by its axes, coupling, tool and limits.
    """

    name: str
    frame: str
    digest: str
    grid: Grid
    directions: Array
    counts: NDArray[np.uint16]
    manipulability: Quantity
    margin: Quantity
    settings: dict[str, Any]

    def __repr__(self) -> str:
        return f"ReachMap({self.name}: {self.grid.shape} cubes of {self.voxel:g} m, {self.volume:.3g} m³ reached)"

    @property
    def voxel(self) -> float:
        """The side of a cube [m]."""
        return self.grid.voxel

    @property
    def share(self) -> Array:
        """The share of the directions reached, (nx, ny, nz) in [0, 1]."""
        return self.counts / max(len(self.directions), 1)

    @property
    def volume(self) -> float:
        """The volume [m³] of the cubes with a direction reached."""
        return int(np.count_nonzero(self.counts)) * self.voxel**3

    def at(self, p: ArrayLike) -> Array:
        """The share in [0, 1] of the cube that holds each point (..., 3) [m], (...); 0 outside the grid."""
        cells = self.grid.cells(as_vector(p, "p"))
        return np.where(cells >= 0, self.counts.reshape(-1)[cells] / max(len(self.directions), 1), 0.0)

    def slice(self, axis: str, at: float) -> Array:
        """The share in the layer of cubes that holds the plane axis = `at` [m], over the other two axes in order.

        Args:
            axis: "x", "y" or "z".
            at: Where along it [m].

        Raises:
            InputError: There is no such axis, or the plane is outside the grid.
        """
        k = "xyz".index(require_choice(axis, ("x", "y", "z"), "axis"))
        along = self.grid.along(k)
        i = int(np.floor(as_number(at, "at") / self.voxel + 0.5)) - self.grid.lower[k]
        if not 0 <= i < len(along):
            raise InputError(f"at must be from {along[0]:g} to {along[-1]:g} m along {axis}; got {at:g}")
        return np.take(self.counts, i, axis=k) / max(len(self.directions), 1)

    def require(self, arm: Arm) -> ReachMap:
        """The map, or InputError if it is one of another arm: other axes, coupling, tool or limits."""
        if digest_of(require_arm(arm)) != self.digest:
            raise InputError(
                f"the map is one of another arm ({self.name}) than {arm.name}: make it with reach_map(arm)"
            )
        return self

    # -- files ---------------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the map as .npz, whole or not at all. The same map gives the same bytes. Returns the path."""
        return write_whole(path, self.npz())

    def to_ply(self, path: str | os.PathLike[str]) -> Path:
        """Write the reached cubes' centres as a PLY point cloud with colour and `share`. Returns the path."""
        return write_whole(path, self.ply())

    def to_png(self, path: str | os.PathLike[str], through: ArrayLike | None = None) -> Path:
        """Write a picture of the three slices through a point, as `png` draws it. Returns the path."""
        return write_whole(path, self.png(through))

    def npz(self) -> bytes:
        """The content of `save`: the arrays, and the rest as JSON."""
        head: dict[str, Any] = {"format": FORMAT, "name": self.name, "frame": self.frame, "digest": self.digest}
        head |= {"voxel": self.voxel, "lower": self.grid.lower, "settings": self.settings}
        file = io.BytesIO()
        arrays = {name: getattr(self, name) for name in ("directions", "counts", "manipulability", "margin")}
        np.savez_compressed(file, head=np.array(json.dumps(head)), **arrays)
        return file.getvalue()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> ReachMap:
        """Read a map that `save` wrote. InputError for any other file."""
        file = as_path(path)
        try:
            with np.load(io.BytesIO(read_bounded(file, MAX_BYTES)), allow_pickle=False) as arrays:
                head = json.loads(str(arrays["head"]))
                if head["format"] != FORMAT:
                    raise ValueError(f"its format is {head['format']!r}, not {FORMAT!r}")
                counts, directions = arrays["counts"], arrays["directions"]
                grid = Grid(float(head["voxel"]), tuple(map(int, head["lower"])), counts.shape)
                names = {name: str(head[name]) for name in ("name", "frame", "digest")}
                quantities = (arrays["manipulability"], arrays["margin"])
                return cls(**names, grid=grid, directions=directions, counts=counts, manipulability=quantities[0],
                           margin=quantities[1], settings=dict(head["settings"]))  # fmt: skip
        except OSError as error:
            raise InputError(f"cannot read {file}: {error.strerror or error}") from error
        except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(
                f"{file} is no reach map ({one_line(str(error), 80)}); ReachMap.save writes one"
            ) from error

    def ply(self) -> bytes:
        """The content of `to_ply`, binary: red for a small share, green for all directions."""
        cells = np.flatnonzero(self.counts)
        share = self.share.reshape(-1)[cells]
        kinds = [(name, "<f4") for name in ("x", "y", "z", "share")] + [
            (name, "u1") for name in ("red", "green", "blue")
        ]
        vertices = np.zeros(len(cells), dtype=kinds)
        vertices["x"], vertices["y"], vertices["z"] = self.grid.centres(cells).T
        vertices["share"], vertices["red"], vertices["green"] = (
            share,
            np.round(255 * (1 - share)),
            np.round(255 * share),
        )
        names = {"<f4": "float", "u1": "uchar"}
        properties = "".join(f"property {names[kind]} {name}\n" for name, kind in kinds)
        head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(cells)}\n{properties}end_header\n"
        return head.encode() + vertices.tobytes()

    def png(self, through: ArrayLike | None = None) -> bytes:
        """A picture of the slices across x, y and z that hold a point (3,) [m], by default where most is reached.

        Raises MissingExtraError without matplotlib.
        """
        try:
            from matplotlib.figure import Figure
        except ImportError as error:
            raise missing_extra("a picture of a map", "matplotlib", "guide") from error
        figure = Figure(figsize=(12, 4.2), layout="constrained")
        for k, ax in enumerate(figure.subplots(1, 3)):
            others = tuple(i for i in range(3) if i != k)
            layer = int(self.counts.sum(axis=others).argmax())
            at = self.grid.along(k)[layer] if through is None else as_vector(through, "through")[k]
            share = 100.0 * self.slice("xyz"[k], float(at))
            ends = [end for i in others for end in self.grid.along(i)[[0, -1]] + np.array([-0.5, 0.5]) * self.voxel]
            drawn = ax.imshow(np.ma.masked_equal(share, 0.0).T, origin="lower", extent=ends, vmin=0.0, vmax=100.0)
            ax.set(title=f"{'xyz'[k]} = {at:.3g} m", xlabel=f"{'xyz'[others[0]]} [m]", ylabel=f"{'xyz'[others[1]]} [m]")
        figure.colorbar(drawn, ax=figure.axes, label="directions reached [%]")
        figure.suptitle(f"{self.name}: reach in the frame {self.frame}", parse_math=False)
        file = io.BytesIO()
        figure.savefig(file, format="png", dpi=100)
        return file.getvalue()


def digest_of(arm: Arm) -> str:
    """`sha256:…` of what decides the reach of an arm, rounded to nine decimals."""
    numbers = arm.screws, arm.home, arm.coupling.A, arm.limits.lower, arm.limits.upper
    parts = [arm.base, arm.tip, arm.joint_names, *((np.round(each, 9) + 0.0).tolist() for each in numbers)]
    return f"sha256:{hashlib.sha256(json.dumps(parts).encode()).hexdigest()}"
