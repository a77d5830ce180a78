"""Vertices and normals for shading, shared on smooth surfaces and separate at creases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array, frozen

CREASE = np.cos(np.radians(35.0))
"""Cosine of the angle of a crease. Neighbouring faces at a larger angle keep a sharp edge between them."""

WELD = 1e-6
"""Vertices closer than this share of the mesh's size are one. Some formats repeat them for each triangle."""

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
    steps = np.round((normals + 1.0) * 500.0).astype(np.int64)
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
    made: Array = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return made


def _corner_normals(corners: Array, vertex: Numbers) -> Array:
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = unit(areas)
    group = _components(*_smooth_pairs(normals, vertex), len(vertex))
    mean = unit(sums((areas[:, None] * _angles(corners)[..., None]).reshape(-1, 3), group, len(group))[group])
    own = np.repeat(normals, 3, axis=0)
    near = (mean * own).sum(axis=1) >= CREASE
    # A face without area has no normal of its own, and takes that of its neighbours.
    return np.where((near | ~own.any(axis=1))[:, None], mean, own)


def _angles(corners: Array) -> Array:
    """Of each triangle at each of its corners (F, 3)."""
    ahead = unit(np.roll(corners, -1, axis=1) - corners)
    behind = -np.roll(ahead, 1, axis=1)
    made: Array = np.arccos(np.clip((ahead * behind).sum(axis=-1), -1.0, 1.0))
    return made


def _smooth_pairs(normals: Array, vertex: Numbers) -> tuple[Numbers, Numbers]:
    """Corners (numbers 3 F) at one vertex with faces that share a smooth edge there, as two lists."""
    corner = np.arange(len(vertex)).reshape(-1, 3)
    start, end = corner.ravel(), np.roll(corner, -1, axis=1).ravel()
    turned = vertex[start] > vertex[end]  # the same edge from the other side
    start, end = np.where(turned, end, start), np.where(turned, start, end)
    order = np.lexsort((vertex[end], vertex[start]))
    start, end = start[order], end[order]
    a, b = slice(None, -1), slice(1, None)
    same = (vertex[start[a]] == vertex[start[b]]) & (vertex[end[a]] == vertex[end[b]])
    smooth = same & ((normals[start[a] // 3] * normals[start[b] // 3]).sum(axis=1) >= CREASE)
    return np.concatenate([start[a][smooth], end[a][smooth]]), np.concatenate([start[b][smooth], end[b][smooth]])


def _components(one: Numbers, other: Numbers, count: int) -> Numbers:
    """The least number in the connected component of each of `count` nodes, by edges between `one` and `other`.

    Each round hooks every root to a smaller neighbour and follows the hooks. The roots that can still be hooked at
    least halve (Shiloach & Vishkin 1982).
    """
    root = np.arange(count)
    while True:
        a, b = root[one], root[other]
        apart = a != b
        if not apart.any():
            return root
        np.minimum.at(root, np.maximum(a, b)[apart], np.minimum(a, b)[apart])
        while (further := root[root]).tobytes() != root.tobytes():
            root = further


def sums(vectors: Array, group: Numbers, count: int) -> Array:
    """The sums (count, k) of the vectors (N, k) of each group."""
    return np.stack([np.bincount(group, column, minlength=count) for column in vectors.T], axis=1)
