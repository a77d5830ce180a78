"""Point clouds as bodies: the voxels that points occupy, as octrees of the collision library."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array
from ..support.errors import InputError

# Side of a tile [m], about: it is a power of two of voxels. One octree of all voxels takes twice as long, because its
# box holds most links of an arm.
TILE = 0.4
# The most tiles: as bodies, they make the checker slow to build. Larger tiles keep to it.
MOST_TILES = 300
# The most voxels of a cloud. A room of 5 × 5 × 3 m has some 200,000 of 2 cm on its walls.
MOST_VOXELS = 500_000
MOST_CELLS = 2**62  # The most cells of the box round a cloud, which are numbered.
# Voxels along a side of a part. A distance measures few parts, and a part has few voxels.
PART = 16

Cells = NDArray[np.int64]


class Cloud:
    """The voxels of side `voxel` [m] that points (N, 3) occupy, aligned with the axes of the cloud's frame.

    `centres` (k, 3) are those of the voxels. `tiles` are octrees of some 0.4 m, which hold them. The `parts` of
    a tile are octrees of `PART` voxels along a side, for distances.
    """

    def __init__(self, coal: Any, points: Array, voxel: float) -> None:
        self.voxel = voxel
        self.centres: Array = np.empty((0, 3))
        self.tiles: list[Any] = []
        if not len(points):
            return
        cells = np.floor(points / voxel).astype(np.int64)
        low = cells.min(axis=0)
        span = cells.max(axis=0) - low + 1
        if not np.prod(span.astype(float)) < MOST_CELLS:
            raise InputError(f"voxels of {voxel:g} m are too fine for points that are {span.max() * voxel:.3g} m apart")
        numbers = _distinct(_numbered(cells))
        if len(numbers) > MOST_VOXELS:
            raise InputError(
                f"the points occupy {len(numbers):,} voxels of {voxel:g} m; at most {MOST_VOXELS:,} are checked: "
                "give a larger voxel, or leave out points that the arm cannot reach"
            )
        cells = np.column_stack(np.unravel_index(numbers, span))
        cells += low
        # Octrees divide space at powers of two from the origin: a tile is one of their nodes.
        side = 2 ** max(0, round(np.log2(TILE / voxel)))
        while len(_distinct(tiles := _numbered(cells // side))) > MOST_TILES:
            side *= 2
        self.centres = voxel * (cells.astype(np.float64) + 0.5)
        for rows in _groups(tiles):
            # Each octree holds the interpreter for its own points only. Between them other threads run, as a servo's.
            time.sleep(0.0)
            tile = coal.makeOctree(self.centres[rows], voxel)
            inner = _groups(_numbered(cells[rows] // PART))
            tile.parts = [coal.makeOctree(self.centres[rows[cells]], voxel) for cells in inner]
            for part in tile.parts:
                part.computeLocalAABB()
            self.tiles.append(tile)  # its parts go where it goes


def _numbered(cells: Cells) -> Cells:
    """A number (k,) for each cell (k, 3)."""
    cells = cells - cells.min(axis=0)
    span = cells.max(axis=0) + 1
    numbers: Cells = (cells * [span[1] * span[2], span[2], 1]).sum(axis=1)
    return numbers


def _distinct(numbers: Cells) -> Cells:
    """The distinct numbers in order. NumPy's `unique` holds the interpreter for 30 ms of 100,000; sorting does not."""
    numbers = np.sort(numbers)
    return numbers[np.diff(numbers, prepend=numbers[0] - 1) > 0]


def _groups(numbers: Cells) -> list[NDArray[np.intp]]:
    """The places of each number (k,)."""
    order = np.argsort(numbers, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1)
