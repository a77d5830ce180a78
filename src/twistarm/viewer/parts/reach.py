"""The reach on show: a map that the program gave, or a quick one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...design import ReachMap, reach_map
from ...design.mapping import sphere
from ...support.checks import Array, Progress
from ..jobs import Job
from ..messages import Message, packed
from .show import Part, Show

ACROSS = 12  # Cubes of a quick map from the middle to the end of the reach. With more, its samples leave holes.
MOST_CUBES = 80  # Cubes along an axis that pages draw, 3 MB at most. Finer maps are drawn coarser.
# Each moves every corner to the mean of its faces' middles. One is naive surface nets (S. F. F. Gibson, 1998).
SMOOTHINGS = 2


class Reach(Part):
    """A `map` as pages draw it, made when its layer is first switched on without one."""

    def __init__(self) -> None:
        self.map: Message | None = None
        self._requested = False

    def due(self, show: Show) -> Job | None:
        """A job that makes a quick map, if a page needs one."""
        if self._requested or self.map is not None or "reach" not in show.needed:
            return None
        self._requested = True
        return Job("reach", "mapping the reach", partial(quick, show.arm), self._finish)

    def messages(self, show: Show) -> Iterator[Message]:
        """The map, once it is there."""
        if self.map is not None:
            yield self.map

    def _finish(self, message: Message) -> None:
        self.map = self.map or message  # the program may have given one meanwhile


def quick(arm: Arm, progress: Progress) -> Message:
    """A map by random configurations, for drawing. It takes a second or two."""
    voxel = float(f"{max(sphere(arm)[1] / ACROSS, 1e-6):.1g}")
    return drawing(reach_map(arm, voxel, 26, method="fk", workers=1, progress=progress))


def drawing(m: ReachMap) -> Message:
    """A map for the pages: the `shares` of its cubes, and its surface.

    The surface has `points`, `faces`, and `values` at the points. Shares and values are 0 for nothing to 255 for
    `best`. The cube of index i (3,) has its centre at first + i voxel.
    """
    step = -(-max(m.grid.shape) // MOST_CUBES)
    padded = np.pad(m.counts, [(0, -size % step) for size in m.grid.shape])
    counts = padded.reshape([part for size in padded.shape for part in (size // step, step)]).max(axis=(1, 3, 5))
    first, voxel, n = m.grid.voxel * (np.array(m.grid.lower) + (step - 1) / 2), step * m.grid.voxel, len(m.directions)
    best, how = int(counts.max(initial=0)), "sampled" if m.settings.get("method") == "fk" else "by IK"
    which = f"Reached along {np.round(m.directions[0], 2) + 0.0}" if n else "Reached in any orientation"
    which = f"Share of {n} directions" if n > 1 else which
    shares = np.ceil(255.0 * counts / max(best, 1))
    points, faces, values = hull(shares)
    words = f"{which}, {how}; cubes of {voxel:.3g} m"
    cubes = {"first": first.tolist(), "voxel": voxel, "shape": list(shares.shape), "shares": packed(shares, "u1")}
    surface = {"points": packed(first + voxel * points, "<f4"), "faces": packed(faces, "<u4")}
    surface["values"] = packed(values, "u1")
    return {"type": "reach", "best": best / max(n, 1), "words": words, **cubes, **surface}


def hull(values: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """The closed surface of the cubes (nx, ny, nz) above 0, smoothed.

    Returns vertices (V, 3), triangles (F, 3) and values (V,). The unit of vertices is the side of a cube, and their
    origin the centre of the first. Triangles are counterclockwise seen from outside. A value is the mean of the cubes
    behind the vertex.
    """
    padded = np.pad(values, 1)
    corners, behind = [np.empty((0, 4, 3), dtype=np.int64)], [np.empty(0)]
    for k, (step, a, b) in enumerate(np.roll(np.eye(3, dtype=np.int64), -k, axis=0) for k in range(3)):
        change = np.diff((padded > 0).astype(np.int8), axis=k)
        for towards, ends in ((-1, [0 * a, a, a + b, b]), (1, [0 * a, b, a + b, a])):
            cells = np.argwhere(change == towards)
            corners.append(cells[:, None] + step + ends)
            behind.append(padded[tuple((cells + (step if towards > 0 else 0)).T)])
    lattice, places = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    places = places.ravel()  # of NumPy 2.0 a column
    count = np.maximum(np.bincount(places), 1)

    def spread(faces: Array) -> Array:
        """The mean (V,) at each corner of what its faces have (F,)."""
        return np.array(np.bincount(places, np.repeat(faces, 4)) / count)

    axes: list[Array] = [*(lattice.T - 1.5)]
    for _ in range(SMOOTHINGS):
        axes = [spread(axis[places].reshape(-1, 4).mean(axis=1)) for axis in axes]
    faces = places.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return np.stack(axes, axis=-1), faces, spread(np.concatenate(behind))
