"""A mesh file's bytes as triangles, by trimesh's readers. Runs in the worker, which limits time and memory."""

from __future__ import annotations

import io
import xml.parsers.expat
from math import ceil, inf
from typing import Any

import numpy as np

from ...support.checks import Array
from .limits import LONGEST, PARTS, TRIANGLES
from .mending import mended
from .mesh_file import Colour, MeshFile, Part, RefusedError
from .references import References
from .shading import shaded
from .simplifying import simplified

CHUNK = 4096
"""Bytes."""

COMPRESSED = (b"KHR_draco_mesh_compression", b"EXT_meshopt_compression", b"KHR_meshopt_compression")
"""Extensions of glTF whose buffers are packed."""

Piece = tuple[Array, Colour | None]
"""Corners (F, 3, 3) [m] of the triangles of one material, and its colour."""


def pieces_of(file: MeshFile) -> list[Piece]:
    """The triangles of the mesh in the file's frame.

    They are in metres where the file names its unit, as COLLADA does, else in the file's numbers. The up axis is
    ignored, as in RViz. Raises RefusedError, and any error of trimesh's readers.
    """
    import trimesh

    references: Any = References(file)
    if file.kind == "dae":
        _require_plain_xml(file.data)
    data = mended(file)
    if file.kind in ("gltf", "glb") and any(word in file.data for word in COMPRESSED):
        raise RefusedError("it is compressed by Draco or meshopt, which is not read here")
    # `shaded` welds what trimesh would merge.
    scene = trimesh.load_scene(io.BytesIO(data), file_type=file.kind, resolver=references, process=False)
    if references.refused:
        raise references.refused
    metres = trimesh.units.unit_conversion(scene.units, "meters") if scene.units else 1.0
    if not (np.isfinite(metres) and metres > 0):
        raise RefusedError(f"its unit is {metres:g} m")
    placed = ((scene.geometry[name], g) for g, name in (scene.graph[node] for node in scene.graph.nodes_geometry))
    meshes = [(mesh, g) for mesh, g in placed if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)]
    _require_few(sum(len(mesh.faces) for mesh, _ in meshes), len(meshes))
    return [(metres * _corners(mesh, g, metres), _own_colour(mesh)) for mesh, g in meshes]


def length_of(pieces: list[Piece]) -> float:
    """The longest side of the box around the pieces. RefusedError where the box is a point."""
    low = np.min([corners.min(axis=(0, 1)) for corners, _ in pieces], axis=0)
    high = np.max([corners.max(axis=(0, 1)) for corners, _ in pieces], axis=0)
    length = float((high - low).max())
    if not length > 0:
        raise RefusedError("all its triangles are one point")
    return length


def parts_from(pieces: list[Piece], most: float = inf) -> list[Part]:
    """A part for each piece, simplified to about `most` triangles in all, each in proportion.

    Normals come from the geometry, because many exporters write zeros.
    """
    share = most / sum(len(corners) for corners, _ in pieces)
    parts = []
    for corners, colour in pieces:
        fewer = corners if share >= 1.0 else simplified(corners, ceil(share * len(corners)))
        parts.append(Part(*shaded(fewer), colour, exact=fewer is corners))
    return parts


def _require_few(triangles: int, parts: int) -> None:
    if not triangles:
        raise RefusedError("it holds no triangles")
    for count, most, what in ((triangles, TRIANGLES, "triangles"), (parts, PARTS, "parts")):
        if count > most:
            raise RefusedError(f"it holds {count:,} {what}; at most {most:,} are drawn")


def _corners(mesh: Any, g: Array, metres: float) -> Array:
    """The triangles (F, 3, 3) of `mesh` at the pose `g`. A mirroring pose reverses their order of corners."""
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise RefusedError("its triangles name vertices that it does not have")
    with np.errstate(all="ignore"):  # it is looked at below
        if not np.array_equal(g, np.eye(4)):
            vertices = vertices @ g[:3, :3].T + g[:3, 3]
            faces = faces[:, ::-1] if np.linalg.det(g[:3, :3]) < 0 else faces
        corners: Array = vertices[faces]
        if not (np.abs(corners) * metres <= LONGEST).all():
            raise RefusedError(f"it has points that are no finite numbers, or are beyond {LONGEST:g} m")
    return corners


def _own_colour(mesh: Any) -> Colour | None:
    if mesh.visual.kind is None:
        return None
    paint = mesh.visual.material if mesh.visual.kind == "texture" else mesh.visual
    if paint.main_color is None:  # of several materials, none of which has one
        return None
    red, green, blue, alpha = (min(max(0.0, float(part) / 255.0), 1.0) for part in np.ravel(paint.main_color)[:4])
    return (red, green, blue, alpha)


class _RootReachedError(Exception):
    """The parser has reached the root element."""


def _require_plain_xml(data: bytes) -> None:
    """RefusedError for data that is not XML, as an archive, or that has a document type."""

    def refuse(*_: object) -> None:
        raise RefusedError("it has a document type, which is not allowed in any file")

    def stop(*_: object) -> None:
        raise _RootReachedError

    parser = xml.parsers.expat.ParserCreate()
    parser.StartDoctypeDeclHandler, parser.StartElementHandler = refuse, stop
    try:
        for start in range(0, len(data), CHUNK):  # it ends with the chunk in which it is stopped
            parser.Parse(data[start : start + CHUNK], False)
        parser.Parse(b"", True)
    except _RootReachedError:
        return
    except xml.parsers.expat.ExpatError as error:
        raise RefusedError(f"it is no XML: {error}") from None
