"""STL, binary and text, as arrays."""

from __future__ import annotations

import re

import numpy as np

from ...support.checks import Array
from .mesh import RefusedError

COUNT, HEAD, FACET = 80, 84, 50
"""Bytes of a binary STL before the count of facets, before the first facet, and of one facet."""

LOOKED_AT = 1_000
"""Bytes at the beginning of a text with its first facet."""

MOST_MISSING = 1000
"""A file that announces so many times its facets is not a binary STL."""

_VERTEX = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.I)


def stl_corners(data: bytes) -> Array:
    """The triangles (F, 3, 3). As in assimp, bytes may follow the last facet, and a text may lack its end."""
    promised = int.from_bytes(data[COUNT:HEAD], "little") if len(data) >= HEAD else -1
    is_solid = data[:LOOKED_AT].lstrip().lower().startswith(b"solid") and b"\0" not in data[:HEAD]
    if is_solid and len(data) != HEAD + FACET * promised:
        vertices = _VERTEX.findall(data)
        if len(vertices) % 3:
            raise RefusedError("it is cut short in the middle of a facet")
        return np.array(vertices, dtype=np.bytes_).astype(np.float64).reshape(-1, 3, 3)
    present = (len(data) - HEAD) // FACET
    if promised > MOST_MISSING * present > 0:
        raise RefusedError("it is no STL")  # the count would tell bytes of another kind of file
    if promised > present or promised < 0:
        what = f": {promised:,} triangles are announced and {present:,} are there" if promised >= 0 else ""
        raise RefusedError(f"it is cut short{what}")
    return np.ndarray((promised, 3, 3), "<f4", data, HEAD + 12, (FACET, 12, 4))
