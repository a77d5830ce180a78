"""Mesh files as triangles with normals and a colour: one part per material."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array
from ..errors import DescriptionError, missing_extra
from ..interrupts import interrupts_held
from .drawing import Colour
from .shading import shaded
from .simplifying import simplified


@dataclass(frozen=True)
class Part:
    """Triangles of one material: vertices (N, 3), unit normals (N, 3), faces (F, 3); colour None where not given.

    `exact`: they are those of the file.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    colour: Colour | None
    exact: bool = True


def load_parts(path: Path, most: float = inf) -> list[Part]:
    """The parts of a mesh file (STL, DAE, OBJ and what else trimesh reads), in the file's own frame.

    A file of more than `most` triangles is simplified to about so many, each part to its share.

    In metres where the file names its unit, as COLLADA does, else in the file's numbers; its up axis is not looked
    at, as in RViz. Normals come from the geometry, never from the file: many exporters write zeros.

    Raises DescriptionError for a file that is not a mesh, MissingExtraError without trimesh.
    """
    try:
        with interrupts_held():
            import trimesh
    except ImportError as error:
        raise missing_extra("drawing a mesh", "trimesh", "view") from error
    try:
        with interrupts_held():
            scene = trimesh.load_scene(str(path), process=False)  # what it would merge is welded here
            metres = trimesh.units.unit_conversion(scene.units, "meters") if scene.units else 1.0
            meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
            share = most / max(sum(len(mesh.faces) for mesh in meshes), 1)
            parts = [_part(mesh, metres, share) for mesh in meshes]
    except Exception as error:  # the readers of trimesh raise whatever their format made them stumble over
        reason = str(error) or type(error).__name__
        raise DescriptionError(f"cannot read mesh {path}: {reason}; export it again as STL, DAE or OBJ") from error
    if not parts:
        raise DescriptionError(f"cannot read mesh {path}: it holds no triangles; export it again as STL, DAE or OBJ")
    return parts


def _part(mesh: Any, metres: float, share: float) -> Part:
    corners = metres * np.asarray(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces)]
    fewer = corners if share >= 1.0 else simplified(corners, ceil(share * len(corners)))
    return Part(*shaded(fewer), _own_colour(mesh), exact=fewer is corners)


def _own_colour(mesh: Any) -> Colour | None:
    if mesh.visual.kind is None:
        return None
    paint = mesh.visual.material if mesh.visual.kind == "texture" else mesh.visual
    if paint.main_color is None:  # of several materials, none of which has one
        return None
    red, green, blue, alpha = (float(part) / 255.0 for part in np.ravel(paint.main_color)[:4])
    return (red, green, blue, alpha)
