"""The solid that the triangles of a mesh enclose: whether they are closed, and which points are inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..description.meshes.mesh import components, welded
from ..support.checks import Array
from ..theory.rotations import from_rpy

# A ray along its z axis hits no edge of a mesh with edges along the axes.
SKEW = from_rpy(np.array([0.7, 0.4, 0.9]))


class Solid:
    """The triangles `faces` (F, 3) between `points` (N, 3) [m].

    `closed`: each edge has two faces, or an even number. `samples` (k, 3): a point of each connected part.
    """

    def __init__(self, points: Array, faces: NDArray[np.int64]) -> None:
        numbers = welded(points)
        # Some exporters write each face twice, and faces without an area.
        vertex, first = np.unique(np.sort(numbers[faces], axis=1), axis=0, return_index=True)
        faces = faces[first[(np.diff(vertex, axis=1) > 0).all(axis=1)]]
        start, end = numbers[faces].ravel(), numbers[np.roll(faces, -1, axis=1)].ravel()
        edges = np.column_stack([np.minimum(start, end), np.maximum(start, end)])
        _, edge, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
        self.closed = bool(len(count)) and not (count % 2).any()
        # Where all faces point one way, a cavity differs from a part that overlaps another one.
        self._oriented = not np.bincount(edge.ravel(), np.where(start < end, 1.0, -1.0)).any()
        part = components(start, end, len(points))[numbers[faces[:, 0]]] if len(faces) else np.zeros(0)
        self.samples = points[faces[np.unique(part, return_index=True)[1], 0]]
        corners = points[faces] @ SKEW
        self._corners, self._low, self._high = corners, corners.min(axis=1), corners.max(axis=1)
        self._least, self._most = self._low.min(axis=0, initial=np.inf), self._high.max(axis=0, initial=-np.inf)

    def contains(self, points: Array) -> bool:
        """Whether one of the points (k, 3) is inside, by the faces that a ray from it passes through."""
        rotated = points @ SKEW
        near = ((rotated > self._least) & (rotated < self._most)).all(axis=1)
        return self.closed and any(map(self._inside, rotated[near]))

    def _inside(self, point: Array) -> bool:
        beside = ((self._low[:, :2] <= point[:2]) & (self._high[:, :2] >= point[:2])).all(axis=1)
        a, b, c = (self._corners[beside & (self._high[:, 2] >= point[2])] - point).transpose(1, 2, 0)
        areas = np.stack([u[0] * v[1] - u[1] * v[0] for u, v in ((b, c), (c, a), (a, b))])
        through = (areas > 0.0).all(axis=0) | (areas < 0.0).all(axis=0)
        whole = areas.sum(axis=0)
        ahead = through & ((areas * np.stack([a[2], b[2], c[2]])).sum(axis=0) * whole > 0.0)
        return bool(np.sign(whole[ahead]).sum() if self._oriented else np.count_nonzero(ahead) % 2)
