"""A mesh file's bytes as triangles, by trimesh's readers, and repairs of files that other readers take.

Runs in the worker, which limits time and memory.
"""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ET
from math import ceil, inf
from typing import Any

import numpy as np

from ...support.checks import Array
from .mesh_file import LONGEST, PARTS, TRIANGLES, Colour, MeshFile, Part, RefusedError
from .references import References
from .shading import shaded, simplified

HEAD, COUNT, FACET = 84, 80, 50
"""Bytes of a binary STL before its first facet, before the count of facets, and of one facet."""

LOOKED_AT = 1_000
"""Bytes at the beginning of a text STL with its first facet."""

LUMINANCE = (0.212671, 0.715160, 0.072169)
"""Weights of red, green and blue by ITU-R BT.709. COLLADA 1.5 takes them for the opacity of a colour."""

MOST_MISSING = 1000
"""A file that announces so many times its facets is not a binary STL."""

_EFFECTS = re.compile(rb"<library_effects\b.*?</library_effects>", re.DOTALL)

_ENCODING = rb"utf-?8|utf-?16(?:le|be)?|(?:us-)?ascii|iso-8859-\d+|windows-125\d"
_XML = re.compile(
    rb"(?:\xef\xbb\xbf|\xff\xfe|\xfe\xff)?\s*<(?!\?xml[^>]*\sencoding\s*=\s*[\"'](?!(?:%b)[\"']))" % _ENCODING, re.I
)
"""The beginning of a text in XML, behind its byte-order mark, in an encoding that spells ASCII as ASCII does."""

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


def mended(file: MeshFile) -> bytes:
    """The bytes to read. RefusedError for a file that is empty or cut short."""
    if not file.data.strip():
        raise RefusedError("it is empty")
    if file.kind == "stl":
        return _stl(file.data)
    return _EFFECTS.sub(_with_opacity, file.data) if file.kind == "dae" else file.data


def _stl(data: bytes) -> bytes:
    """A binary STL without bytes after its last facet, or a text STL with its end. assimp takes both."""
    start = data[:LOOKED_AT].lstrip().lower()
    promised = int.from_bytes(data[COUNT:HEAD], "little") if len(data) >= HEAD else -1
    if len(data) != HEAD + FACET * promised and start.startswith(b"solid") and b"\0" not in data[:HEAD]:
        return _text(data)
    present = (len(data) - HEAD) // FACET
    if promised > MOST_MISSING * present > 0:
        return data  # another kind of file, whose bytes no message may tell
    if promised > present or promised < 0:
        told = f": {promised:,} triangles are announced and {present:,} are there" if promised >= 0 else ""
        raise RefusedError(f"it is cut short{told}")
    return data[: HEAD + FACET * promised]


def _text(data: bytes) -> bytes:
    lowered = data.lower()
    if lowered.rfind(b"endsolid") >= 0 and lowered.count(b"endsolid") >= lowered.count(b"solid") // 2:
        return data
    if b"vertex" in lowered and not lowered.rstrip().endswith((b"endfacet", b"endloop")):
        raise RefusedError("it is cut short in the middle of a facet")
    return data + b"\nendsolid\n"


def _with_opacity(match: re.Match[bytes]) -> bytes:
    """COLLADA's effects, with the opacity of each as the alpha of its diffuse colour, for trimesh."""
    try:
        effects = ET.fromstring(match[0])
        for technique in effects.findall(".//technique/*"):
            _put_opacity(technique)
    except (ET.ParseError, ValueError):  # which the reader behind will meet too
        return match[0]
    return ET.tostring(effects)


def _put_opacity(technique: ET.Element) -> None:
    diffuse = technique.find("diffuse/color")
    if diffuse is None or diffuse.text is None:
        return
    rgb = diffuse.text.split()[:3]
    diffuse.text = " ".join([*rgb, repr(_opacity(technique))])
    for transparent in technique.findall("transparent"):
        technique.remove(transparent)


def _opacity(technique: ET.Element) -> float:
    """The share of light that is held back, by the mode of `transparent`. The alpha of `diffuse` has no effect."""
    transparent = technique.find("transparent")
    factor = float(technique.findtext("transparency/float") or 1.0)
    mode = "A_ONE" if transparent is None else transparent.get("opaque", "A_ONE")
    colour = None if transparent is None else transparent.findtext("color")
    red, green, blue, alpha = ([float(x) for x in colour.split()] + [1.0] * 4)[:4] if colour else (1.0,) * 4
    if transparent is not None and colour is None:  # a texture, which is not drawn
        return 1.0
    light = sum(weight * x for weight, x in zip(LUMINANCE, (red, green, blue), strict=True))
    share = factor * (light if mode.startswith("RGB") else alpha)
    return min(max(0.0, 1.0 - share if mode.endswith("ZERO") else share), 1.0)


def _require_plain_xml(data: bytes) -> None:
    """RefusedError for data that is not XML, as an archive, or that has a document type."""
    text = data.replace(b"\0", b"")  # UTF-16 too
    if not _XML.match(text):
        raise RefusedError("it is no XML in UTF-8")
    if b"<!DOCTYPE" in text:
        raise RefusedError("it has a document type, which is not allowed in any file")
