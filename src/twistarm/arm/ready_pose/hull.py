"""A few outer points of a binary STL: the farthest in each of some fixed directions."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...support.checks import Array
from ...support.files import read_bounded

LARGEST, HEAD, TRIANGLE = 10_000_000, 84, 50
"""Bytes of the largest file, of an STL's head and of a triangle."""

VERTICES = 3_000
"""The most vertices to look at, evenly spread over the file."""

THINNEST = 0.01
"""A hull flatter than this share of its length is left out, such as a plate."""

DIRECTIONS = np.array([d for d in np.ndindex(5, 5, 5) if 0 < np.abs(np.subtract(d, 2)).sum() <= 3]) - 2.0
"""Along the axes, between two or three of them, and between those."""


def outer_points(path: Path, scale: tuple[float, ...]) -> Array | None:
    """The outermost points (k, 3) of a mesh scaled by `scale` (3,).

    None for a format other than binary STL, and for a mesh without volume.
    """
    vertices = _vertices(path)
    if vertices is None or not np.isfinite(vertices).all():
        return None
    points = vertices * scale
    points = points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))]
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return points if len(points) > 3 and spread[2] > THINNEST * spread[0] else None


def _vertices(path: Path) -> Array | None:
    """Vertices (N, 3) of a binary STL; None for any other file."""
    if path.suffix.lower() != ".stl":
        return None
    try:
        data = read_bounded(path, LARGEST)
    except OSError:
        return None
    count = int.from_bytes(data[80:HEAD], "little")
    if count == 0 or len(data) != HEAD + TRIANGLE * count:
        return None
    every = np.ndarray((count, 3, 3), "<f4", data, HEAD + 12, (TRIANGLE, 12, 4))
    return every[:: 1 + 3 * count // VERTICES].reshape(-1, 3).astype(np.float64)
