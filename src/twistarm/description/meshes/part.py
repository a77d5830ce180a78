"""Parts of a mesh file: one for each material."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array

Colour = tuple[float, float, float, float]


@dataclass(frozen=True)
class Part:
    """Triangles of one material: vertices (N, 3), unit normals (N, 3), faces (F, 3); colour None if not given.

    `exact`: they are the file's triangles.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    colour: Colour | None
    exact: bool = True
