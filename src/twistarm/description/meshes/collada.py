"""COLLADA by pycollada: triangles in metres, and the colours of materials."""

from __future__ import annotations

import io
import re
from typing import Any

import numpy as np

from ...support.checks import Array
from ...support.wheels import Wheel, load
from ..document import decoded
from .mesh import Colour, Piece, RefusedError

LUMINANCE = (0.212671, 0.715160, 0.072169)
"""Weights of red, green and blue by ITU-R BT.709. COLLADA 1.5 takes them for the opacity of a colour."""

_DECLARATION = re.compile(r"\s*<\?xml[^>]*\?>")

_PYCOLLADA = Wheel("collada", "pycollada", has="Collada", oldest="0.8")


def collada_pieces(data: bytes) -> list[Piece]:
    """A piece for each set of triangles or polygons. The up axis is ignored, as in RViz."""
    text = _DECLARATION.sub("", decoded(data), count=1)  # so that its parser reads what is examined here
    if not text.lstrip().startswith("<") or "PK\5\6" in text:  # pycollada would unpack an archive
        raise RefusedError("it is no XML")
    if "<!DOCTYPE" in text:
        raise RefusedError("it has a document type, which is not allowed in any file")
    collada = load(_PYCOLLADA)
    document = collada.Collada(io.BytesIO(text.encode()), ignore=[collada.DaeError])
    metres = document.assetInfo.unitmeter
    metres = 1.0 if metres is None else float(metres)
    if not (np.isfinite(metres) and metres > 0):
        raise RefusedError(f"its unit is {metres:g} m")
    shapes = [] if document.scene is None else document.scene.objects("geometry")
    return [piece for shape in shapes for piece in _pieces(collada, shape, metres)]


def _pieces(collada: Any, shape: Any, metres: float) -> list[Piece]:
    """The pieces of one geometry where a node places it."""
    g = np.asarray(shape.matrix, dtype=np.float64)
    made = []
    for primitive in shape.original.primitives:
        if isinstance(primitive, collada.polylist.Polylist):
            primitive = primitive.triangleset()
        if not isinstance(primitive, collada.triangleset.TriangleSet) or primitive.vertex is None:
            continue  # lines
        vertices = np.asarray(primitive.vertex, dtype=np.float64) @ g[:3, :3].T + g[:3, 3]
        corners = metres * vertices[primitive.vertex_index]
        node = shape.materialnodebysymbol.get(primitive.material)
        colour = _of_vertices(primitive) if node is None else _of_effect(node.target.effect)
        made.append(Piece(corners[:, ::-1] if np.linalg.det(g[:3, :3]) < 0 else corners, colour))
    return made


def _of_effect(effect: Any) -> Colour:
    """The diffuse colour with the opacity of the effect. White in place of a texture."""
    if not isinstance(effect.diffuse, tuple):
        return 1.0, 1.0, 1.0, 1.0
    red, green, blue = np.clip(effect.diffuse[:3], 0.0, 1.0).tolist()
    return red, green, blue, _opacity(effect.xmlnode)


def _opacity(effect: Any) -> float:
    """The share of light that is held back, by the mode of `transparent`. The alpha of `diffuse` has no effect."""
    share = float(effect.findtext(".//{*}transparency/{*}float") or 1.0)
    mode, transparent = "A_ONE", effect.find(".//{*}transparent")
    if transparent is not None:
        mode, colour = transparent.get("opaque", mode), transparent.findtext("{*}color")
        if colour is None:  # a texture, which is not drawn
            return 1.0
        *light, alpha = ([float(x) for x in colour.split()] + [1.0] * 4)[:4]
        share *= float(np.dot(LUMINANCE, light)) if mode.startswith("RGB") else alpha
    return min(max(0.0, 1.0 - share if mode.endswith("ZERO") else share), 1.0)


def _of_vertices(primitive: Any) -> Colour | None:
    """The colour of most corners, where each vertex has one."""
    sources = primitive.sources.get("COLOR")
    if not sources or not len(primitive.index):
        return None
    colours: Array = np.asarray(sources[0][4].data)[primitive.index[:, :, sources[0][0]]]
    values, counts = np.unique(colours.reshape(-1, colours.shape[-1]), axis=0, return_counts=True)
    red, green, blue, alpha = np.clip([*values[counts.argmax()], 1.0][:4], 0.0, 1.0).tolist()
    return red, green, blue, alpha
