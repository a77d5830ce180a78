"""The triangles of a mesh file, simplified and shaded for drawing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, inf
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array
from ...support.errors import DescriptionError
from .shading import shaded, simplified, welded

LONGEST = 1e9
"""Largest coordinate [m], as in a description. Its fourth power is still a finite number."""

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

    `colour` is None where the file gives none. `exact` tells that the triangles are not simplified.
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
