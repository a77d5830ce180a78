"""Simplify a mesh: the vertices in each cell of a grid become one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array
from .shading import Numbers, sums

FINEST, COARSEST = 4096, 4
"""Cells along the longest side of the mesh."""

FEWEST = 8
"""Cells along any other side, so that what is thin does not fall flat."""

STEPS, SAMPLE = 10, 10_000
"""Of the search for the grid, and triangles that it looks at: their number is met to a few percent."""

STRAY = 1e-3
"""How much a vertex is drawn to the middle of its points where the planes through them say nothing."""


def simplified(corners: Array, most: int) -> Array:
    """About `most` triangles for the triangles (F, 3, 3), which stay the same if they are at most `most`.

    The vertices in a cell become one point. It has the least squared distance to the planes of the triangles there,
    weighted by area, so edges and corners stay (Lindstrom, "Out-of-core simplification of large polygonal models",
    2000). No vertex moves by more than a cell. A mesh smaller than its cells stays the same.
    """
    if len(corners) <= most:
        return corners
    low, extent = corners.min(axis=(0, 1)), np.ptp(corners, axis=(0, 1))
    cell = _cells(corners - low, extent, _fitting(corners - low, extent, most))
    _, first, vertex = np.unique(cell, return_index=True, return_inverse=True)
    vertex = vertex.reshape(-1, 3)
    kept = _distinct(vertex)
    if not kept.any():
        return corners
    places = _places(corners, vertex, len(first))
    # A cell holds both sides of a thin wall: each triangle once, as it is turned.
    least = vertex[kept].argmin(axis=1)
    turned = np.take_along_axis(vertex[kept], (least[:, None] + np.arange(3)) % 3, axis=1)
    made: Array = places[np.unique(turned, axis=0)]
    return made


def _fitting(corners: Array, extent: Array, most: int) -> float:
    """How many cells along the longest side leave about `most` triangles: by bisection."""
    coarse, fine = float(COARSEST), float(FINEST)
    sample = corners[:: 1 + len(corners) // SAMPLE]
    for _ in range(STEPS):
        middle = (coarse * fine) ** 0.5
        if np.count_nonzero(_distinct(_cells(sample, extent, middle))) * len(corners) > most * len(sample):
            fine = middle
        else:
            coarse = middle
    return coarse


def _cells(corners: Array, extent: Array, count: float) -> Numbers:
    """The number of the cell of each corner in a box from 0 to `extent`, with `count` cells along its longest side."""
    length = float(extent.max()) / count
    size = np.where(extent > 0, np.minimum(length, extent / FEWEST), length)
    at = (corners / size).astype(np.int64)
    side = np.ceil(extent / size).astype(np.int64) + 1
    cell: Numbers = (at[..., 0] * side[1] + at[..., 1]) * side[2] + at[..., 2]
    return cell


def _distinct(vertex: Numbers) -> NDArray[np.bool_]:
    """Which triangles have three different vertices."""
    a, b, c = vertex.T
    kept: NDArray[np.bool_] = (a != b) & (b != c) & (c != a)
    return kept


def _places(corners: Array, vertex: Numbers, count: int) -> Array:
    """The vertex of each of `count` cells: the solution x of Σ w n nᵀ (x − p) = 0 near the mean of the p."""
    flat, points = vertex.ravel(), corners.reshape(-1, 3)
    mean = sums(points, flat, count) / np.bincount(flat, minlength=count)[:, None]
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    weight = np.linalg.norm(areas, axis=1)
    root = np.divide(areas, np.sqrt(weight)[:, None], out=np.zeros_like(areas), where=weight[:, None] > 0)  # √w n
    root = np.repeat(root, 3, axis=0)
    off = (root * (points - mean[flat])).sum(axis=1)
    A = sums((root[:, :, None] * root[:, None, :]).reshape(-1, 9), flat, count).reshape(-1, 3, 3)
    b = sums(root * off[:, None], flat, count)
    pull = STRAY * np.trace(A, axis1=1, axis2=2) + np.finfo(np.float64).tiny
    x = np.linalg.solve(A + pull[:, None, None] * np.eye(3), b[:, :, None])[..., 0]
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, flat, points)
    np.maximum.at(high, flat, points)
    return np.clip(mean + x, low, high)
