"""Shapes within milliseconds and without trimesh: hulls of a few outer points of binary STLs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...support.checks import Array
from ...support.errors import InputError
from ...support.files import read_bounded
from ..bodies import Shapes

LARGEST, HEAD, TRIANGLE = 10_000_000, 84, 50
"""Bytes of the largest file, of an STL's head and of a triangle."""

VERTICES = 3_000
"""The most vertices to look at, evenly spread over the file."""

DIRECTIONS = np.array([d for d in np.ndindex(5, 5, 5) if 0 < np.abs(np.subtract(d, 2)).sum() <= 3]) - 2.0
"""Along the axes, between two or three of them, and between those."""


class QuickShapes(Shapes):
    """Shapes that need no other process, so that every installation computes the same ready pose.

    A link whose meshes are no binary STL has visuals or capsules, as one without shapes.
    """

    def mesh(self, path: Path, scale: tuple[float, ...]) -> Any:
        """The hull of the outermost points of a binary STL. InputError for any other file."""
        points = _vertices(path) * scale
        return self._hull(points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))])


def _vertices(path: Path) -> Array:
    """Up to `VERTICES` vertices (N, 3) of a binary STL."""
    try:
        data = read_bounded(path, LARGEST) if path.suffix.lower() == ".stl" else b""
    except OSError as error:
        raise InputError(str(error)) from None
    count = int.from_bytes(data[80:HEAD], "little")
    if count == 0 or len(data) != HEAD + TRIANGLE * count:
        raise InputError("it is no binary STL")
    every = np.ndarray((count, 3, 3), "<f4", data, HEAD + 12, (TRIANGLE, 12, 4))
    points = every[:: 1 + 3 * count // VERTICES].reshape(-1, 3).astype(np.float64)
    if not np.isfinite(points).all():
        raise InputError("a vertex is not finite")
    return points
