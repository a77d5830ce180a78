"""The triangles of a mesh file, simplified, and shaded for drawing: smooth surfaces with creases."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array, frozen
from ...support.errors import DescriptionError

LONGEST = 1e9  # Largest coordinate [m], as in a description. Its fourth power is still a finite number.

REMEDY = "export it as STL, OBJ, DAE, PLY or GLB"

Colour = tuple[float, float, float, float]


class UnreadableMeshError(DescriptionError):
    """A mesh that cannot be drawn: its name, `reason` and `remedy`. The message does not show the folder."""

    def __init__(self, path: Path, reason: str, remedy: str = REMEDY) -> None:
        super().__init__(f"cannot read mesh {path.name}: {reason}; {remedy}")
        self.path, self.reason, self.remedy = path, reason, remedy

    def __reduce__(self) -> tuple[type[UnreadableMeshError], tuple[Path, str, str]]:
        return type(self), (self.path, self.reason, self.remedy)


class RefusedError(Exception):
    """Why a mesh is not read, in words that follow its name."""


class Piece(NamedTuple):
    """The triangles of one material as corners (F, 3, 3) [m], and its colour, None where the file gives none."""

    corners: Array
    colour: Colour | None


@dataclass(frozen=True)
class Part:
    """Triangles of one material for drawing: vertices (N, 3), unit normals (N, 3), faces (F, 3).

    `colour` is None where the file gives none. `exact` means that the triangles are not simplified.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    colour: Colour | None
    exact: bool = True


class Mesh:
    """The triangles of a mesh file in its frame.

    They are in metres where the file names its unit, as COLLADA does, else in the file's numbers. `length` is the
    longest side of the box around them. RefusedError without a triangle, for a single point, and for points that are
    not finite.
    """

    def __init__(self, pieces: Iterable[Piece]) -> None:
        self.pieces = [piece for piece in pieces if len(piece.corners)]
        self.triangles = sum(len(piece.corners) for piece in self.pieces)
        if not self.triangles:
            raise RefusedError("it holds no triangles")
        low = np.min([piece.corners.min(axis=(0, 1)) for piece in self.pieces], axis=0)
        high = np.max([piece.corners.max(axis=(0, 1)) for piece in self.pieces], axis=0)
        if not (np.abs([low, high]) <= LONGEST).all():
            raise RefusedError(f"it has points that are no finite numbers, or are beyond {LONGEST:g} m")
        self.length = float((high - low).max())
        if not self.length > 0:
            raise RefusedError("all its triangles are one point")

    def parts(self, most: float = inf) -> list[Part]:
        """A part for each piece, simplified to about `most` triangles in all.

        Normals come from the geometry, because many exporters write zeros.
        """
        fewer = self._simplified(most)
        return [
            Part(*shaded(corners), piece.colour, exact=corners is piece.corners)
            for piece, corners in zip(self.pieces, fewer, strict=True)
        ]

    def solid(self, most: float = inf) -> tuple[Array, NDArray[np.int64]]:
        """The points (N, 3) and faces (F, 3) of all pieces together, simplified to about `most` triangles."""
        points = np.concatenate(self._simplified(most)).reshape(-1, 3)
        _, first, faces = np.unique(welded(points), return_index=True, return_inverse=True)
        return points[first], faces.reshape(-1, 3)

    def _simplified(self, most: float) -> list[Array]:
        """The corners of each piece, each simplified by the same share."""
        share = most / self.triangles
        if share >= 1.0:
            return [piece.corners for piece in self.pieces]
        return [simplified(piece.corners, ceil(share * len(piece.corners))) for piece in self.pieces]


FINEST, COARSEST = 4096, 4  # Cells along the longest side of the mesh.
FEWEST = 8  # Cells along any other side, so that what is thin does not fall flat.
# Of the search for the grid, and triangles that it looks at: it comes within a few percent of their number.
STEPS, SAMPLE = 10, 10_000
# How much a vertex is drawn to the middle of its points where the planes through them say nothing.
STRAY = 1e-3
# Cosine of the angle of a crease. Neighbouring faces at a larger angle keep a sharp edge between them.
CREASE = np.cos(np.radians(35.0))
# Vertices closer than this share of the mesh's size are one. Some formats repeat them for each triangle.
WELD = 1e-6

Numbers = NDArray[np.int64]


def shaded(corners: Array) -> tuple[Array, Array, Numbers]:
    """Vertices, unit normals and faces of triangles given as corners (F, 3, 3).

    A corner's normal is a mean over the faces round its vertex that connect to its face without a crease. The weights
    are area times angle, so the mean does not depend on the triangulation. If it differs from the face's normal by more
    than a crease, as at the tip of a cone, the face's normal counts. Corners with equal vertex and normal become one
    vertex. The time is O(F log F).
    """
    points = corners.reshape(-1, 3)
    vertex = welded(points)
    normals = _corner_normals(corners, vertex)
    steps = np.round((normals + 1.0) * 500.0).astype(np.int64)  # 0 to 1000: below the 1024 of the key
    key = ((vertex * 1024 + steps[:, 0]) * 1024 + steps[:, 1]) * 1024 + steps[:, 2]
    _, first, faces = np.unique(key, return_index=True, return_inverse=True)
    return frozen(points[first]), frozen(normals[first]), faces.reshape(-1, 3)


def welded(points: Array) -> Numbers:
    """The vertex number of each point."""
    low = points.min(axis=0)
    grid = max(WELD * float(np.ptp(points, axis=0).max()), np.finfo(np.float64).tiny)
    cell = np.round((points - low) / grid).astype(np.int64)
    side = int(cell.max()) + 1
    _, vertex = np.unique((cell[:, 0] * side + cell[:, 1]) * side + cell[:, 2], return_inverse=True)
    return np.asarray(vertex.reshape(-1), dtype=np.int64)


def unit(vectors: Array) -> Array:
    """The vectors (..., 3) at length 1; zeros stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)


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
    rotated = np.take_along_axis(vertex[kept], (least[:, None] + np.arange(3)) % 3, axis=1)
    return places[np.unique(rotated, axis=0)]


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
    return (at[..., 0] * side[1] + at[..., 1]) * side[2] + at[..., 2]


def _distinct(vertex: Numbers) -> NDArray[np.bool_]:
    """Which triangles have three different vertices."""
    a, b, c = vertex.T
    return (a != b) & (b != c) & (c != a)


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


def _corner_normals(corners: Array, vertex: Numbers) -> Array:
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = unit(areas)
    group = components(*_smooth_pairs(normals, vertex), len(vertex))
    mean = unit(sums((areas[:, None] * _angles(corners)[..., None]).reshape(-1, 3), group, len(group))[group])
    own = np.repeat(normals, 3, axis=0)
    near = (mean * own).sum(axis=1) >= CREASE
    # A face without area has no normal of its own, and takes that of its neighbours.
    return np.where((near | ~own.any(axis=1))[:, None], mean, own)


def _angles(corners: Array) -> Array:
    """Of each triangle at each of its corners (F, 3)."""
    ahead = unit(np.roll(corners, -1, axis=1) - corners)
    behind = -np.roll(ahead, 1, axis=1)
    return np.arccos(np.clip((ahead * behind).sum(axis=-1), -1.0, 1.0))


def _smooth_pairs(normals: Array, vertex: Numbers) -> tuple[Numbers, Numbers]:
    """Corners (numbers 3 F) at one vertex with faces that share a smooth edge there, as two lists."""
    corner = np.arange(len(vertex)).reshape(-1, 3)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    rotated = vertex[start] > vertex[end]  # the same edge from the other side
    start, end = np.where(rotated, end, start), np.where(rotated, start, end)
    order = np.lexsort((vertex[end], vertex[start]))
    start, end = start[order], end[order]
    a, b = slice(None, -1), slice(1, None)
    same = (vertex[start[a]] == vertex[start[b]]) & (vertex[end[a]] == vertex[end[b]])
    smooth = same & ((normals[start[a] // 3] * normals[start[b] // 3]).sum(axis=1) >= CREASE)
    return np.concatenate([start[a][smooth], end[a][smooth]]), np.concatenate([start[b][smooth], end[b][smooth]])


def components(one: Numbers, other: Numbers, count: int) -> Numbers:
    """The least number in the connected component of each of `count` nodes, by edges between `one` and `other`.

    Each round hooks every root to a smaller neighbour and follows the hooks. The roots that can still be hooked at
    least halve (Shiloach & Vishkin 1982).
    """
    root = np.arange(count)
    while True:
        a, b = root[one], root[other]
        distinct = a != b
        if not distinct.any():
            return root
        np.minimum.at(root, np.maximum(a, b)[distinct], np.minimum(a, b)[distinct])
        while (further := root[root]).tobytes() != root.tobytes():
            root = further


def sums(vectors: Array, group: Numbers, count: int) -> Array:
    """The sums (count, k) of the vectors (N, k) of each group."""
    return np.stack([np.bincount(group, column, minlength=count) for column in vectors.T], axis=1)
