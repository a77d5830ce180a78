"""Repairs of mesh files that other readers take and trimesh does not. Runs in the worker."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from .mesh_file import MeshFile, RefusedError

HEAD, COUNT, FACET = 84, 80, 50
"""Bytes of a binary STL before its first facet, before the count of facets, and of one facet."""

LOOKED_AT = 1_000
"""Bytes at the beginning of a text STL with its first facet."""

LUMINANCE = (0.212671, 0.715160, 0.072169)
"""Weights of red, green and blue by ITU-R BT.709. COLLADA 1.5 takes them for the opacity of a colour."""

MOST_MISSING = 1000
"""A file that announces so many times its facets is not a binary STL."""

_EFFECTS = re.compile(rb"<library_effects\b.*?</library_effects>", re.DOTALL)


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
