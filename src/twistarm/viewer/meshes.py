"""Mesh files as triangles with normals and a colour: one part per material, creases kept sharp."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..checks import Array, frozen
from ..errors import DescriptionError, missing_extra
from ..interrupts import interrupts_held
from .drawing import Colour

CREASE = np.cos(np.radians(35.0))
"""Neighbouring faces that meet at a larger angle keep an edge between them: most machined parts round off below it."""

WELD = 1e-6
"""Vertices closer than this share of the mesh's size are one: formats with single triangles repeat them in rounding."""


@dataclass(frozen=True)
class Part:
    """Triangles of one material: vertices (N, 3), unit normals (N, 3), faces (F, 3); colour None where not given."""

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    colour: Colour | None


def load_parts(path: Path) -> list[Part]:
    """The parts of a mesh file (STL, DAE, OBJ and what else trimesh reads), in the file's own frame.

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
            scene = trimesh.load_scene(str(path))
            metres = trimesh.units.unit_conversion(scene.units, "meters") if scene.units else 1.0
            meshes = [mesh for mesh in scene.dump() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
            parts = [_part(mesh, metres) for mesh in meshes]
    except Exception as error:  # the readers of trimesh raise whatever their format made them stumble over
        reason = str(error) or type(error).__name__
        raise DescriptionError(f"cannot read mesh {path}: {reason}; export it again as STL, DAE or OBJ") from error
    if not parts:
        raise DescriptionError(f"cannot read mesh {path}: it holds no triangles; export it again as STL, DAE or OBJ")
    return parts


def _part(mesh: Any, metres: float) -> Part:
    corners = metres * np.asarray(mesh.vertices, dtype=np.float64)[np.asarray(mesh.faces)]
    vertices, normals, faces = shaded(corners)
    return Part(vertices, normals, faces, _own_colour(mesh))


def _own_colour(mesh: Any) -> Colour | None:
    if mesh.visual.kind is None:
        return None
    paint = mesh.visual.material if mesh.visual.kind == "texture" else mesh.visual
    if paint.main_color is None:  # of several materials, none of which has one
        return None
    red, green, blue, alpha = (float(part) / 255.0 for part in np.ravel(paint.main_color)[:4])
    return (red, green, blue, alpha)


def shaded(corners: Array) -> tuple[Array, Array, NDArray[np.int64]]:
    """Vertices, unit normals and faces of triangles given as corners (F, 3, 3).

    A corner's normal is the area-weighted mean of the faces round its vertex that lie within the crease angle of its
    own face; corners with equal vertex and normal become one vertex.
    """
    points = corners.reshape(-1, 3)
    vertex = _weld(points)
    normals = _corner_normals(corners, vertex)
    steps = np.round((normals + 1.0) * 500.0).astype(np.int64)
    key = ((vertex * 1024 + steps[:, 0]) * 1024 + steps[:, 1]) * 1024 + steps[:, 2]
    _, first, faces = np.unique(key, return_index=True, return_inverse=True)
    return frozen(points[first]), frozen(normals[first]), faces.reshape(-1, 3)


def _weld(points: Array) -> NDArray[np.int64]:
    """The number of the vertex each point belongs to."""
    low = points.min(axis=0)
    grid = max(WELD * float(np.ptp(points, axis=0).max()), np.finfo(np.float64).tiny)
    cell = np.round((points - low) / grid).astype(np.int64)
    side = int(cell.max()) + 1
    _, vertex = np.unique((cell[:, 0] * side + cell[:, 1]) * side + cell[:, 2], return_inverse=True)
    return np.asarray(vertex.reshape(-1), dtype=np.int64)


def _corner_normals(corners: Array, vertex: NDArray[np.int64]) -> Array:
    areas = np.repeat(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), 3, axis=0)
    units = _unit(areas)
    order = np.argsort(vertex, kind="stable")
    _, start, count = np.unique(vertex[order], return_index=True, return_counts=True)
    rank = np.arange(len(order)) - np.repeat(start, count)
    begin, size = np.repeat(start, count), np.repeat(count, count)
    total = np.zeros_like(areas)
    active = np.arange(len(order))
    for k in range(int(count.max())):
        active = active[size[active] > k]
        own = order[active]
        other = order[begin[active] + (rank[active] + k) % size[active]]
        smooth = (units[own] * units[other]).sum(axis=1) >= CREASE
        total[own] += np.where(smooth[:, None], areas[other], 0.0)
    return _unit(np.where(total.any(axis=1, keepdims=True), total, areas))


def _unit(vectors: Array) -> Array:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    unit: Array = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return unit
