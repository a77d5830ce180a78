"""Shapes of visuals and collisions: sizes, colours, and mesh URIs resolved to absolute paths."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..support.checks import Array
from ..support.errors import listed
from ..support.path_redaction import without_places
from ..theory.rotations import from_rpy, from_xyzw
from .document import Reading
from .materials import Colour, Materials
from .mesh_paths import resolve_uri, why_missing
from .numerals import floats, number
from .tree import Geometry


class Geometries:
    """Reads the shapes of one description; remembers its materials and which meshes are missing."""

    def __init__(self, robot: ET.Element, reading: Reading) -> None:
        self._reading = reading
        self._missing: list[str] = []
        self._materials = Materials(robot, reading)

    def of(self, link: ET.Element, kind: str) -> tuple[Geometry, ...]:
        """The link's shapes; `kind` is "visual" or "collision". One that makes no sense is noted and left out."""
        return tuple(shape for element in link.findall(kind) if (shape := self._read(link, element)) is not None)

    def note_odd(self) -> None:
        """Note odd colours, and missing meshes by their remedy."""
        self._materials.note_odd()
        causes: dict[tuple[str, str], list[str]] = {}
        for uri in dict.fromkeys(self._missing):
            cause = why_missing(uri, self._reading.path, self._reading.packages)
            causes.setdefault(cause, []).append(without_places(uri, Path(uri.removeprefix("file://"))))
        for (why, remedy), names in causes.items():
            self._reading.note(
                "mesh-missing",
                None,
                f"{len(names)} mesh file{'s' * (len(names) > 1)} not found: {listed(names, 2)}; {why}; "
                "the kinematics is whole",
                f"{remedy}; simple shapes are drawn instead",
            )

    def _read(self, link: ET.Element, element: ET.Element) -> Geometry | None:
        geometry = element.find("geometry")
        if geometry is None or len(geometry) == 0:
            return None
        shape, material = geometry[0], element.find("material") if element.tag == "visual" else None
        try:
            return self._shape(link, shape, read_origin(element), self._materials.colour(material))
        except ValueError:
            self._reading.note(
                "bad-geometry",
                link,
                f"its <{element.tag}> <{shape.tag}> has no usable size or place; it is not drawn",
                "give every size and origin as numbers",
                repaired=True,
            )
            return None

    def _shape(self, link: ET.Element, shape: ET.Element, origin: Array, colour: Colour | None) -> Geometry | None:
        def sizes(*names: str) -> tuple[float, ...]:
            return tuple(floats(shape.get(name, ""), 1)[0] for name in names)

        readers: dict[str, Callable[[], tuple[float, ...]]] = {
            "box": lambda: tuple(floats(shape.get("size", ""), 3)),
            "cylinder": lambda: sizes("radius", "length"),
            "capsule": lambda: sizes("radius", "length"),
            "sphere": lambda: sizes("radius"),
            "mesh": lambda: mesh_scale(shape.get("scale")),
        }
        if shape.tag not in readers:
            raise ValueError(shape.tag)
        size = readers[shape.tag]()
        if shape.tag == "mesh":
            return Geometry("mesh", origin, size, self._mesh(shape.get("filename", "")), colour)
        if not self._seen(link, shape.tag, size):
            return None
        return Geometry(shape.tag, origin, tuple(map(abs, size)), None, colour)  # type: ignore[arg-type]

    def _seen(self, link: ET.Element, shape: str, size: tuple[float, ...]) -> bool:
        """Whether a shape is visible: a box may be flat, a cylinder a disc, a capsule a ball."""
        if min(size) > 0.0:
            return True
        numbers = " ".join(f"{x:g}" for x in size)
        seen = np.count_nonzero(size) >= 2 if shape == "box" else size[0] != 0.0
        if min(size) < 0.0 or not seen:
            drawn = "the size without its sign is drawn" if seen else "nothing of it is to be seen"
            what = f"its <{shape}> has the size {numbers}; {drawn}"
            self._reading.note("bad-geometry", link, what, "give sizes above 0", repaired=True)
        return bool(seen)

    def _mesh(self, uri: str) -> Path | None:
        path = resolve_uri(uri, self._reading.path, self._reading.packages)
        if path is None:
            self._missing.append(uri)
            return None
        return path


def read_origin(element: ET.Element) -> Array:
    """The `<origin>` of an element as a pose (4, 4); the identity without one. ValueError if it is malformed."""
    g = np.eye(4)
    origin = element.find("origin")
    if origin is not None:
        g[:3, :3] = _rotation(origin)
        g[:3, 3] = floats(origin.get("xyz", "0 0 0"), 3)
    return g


def _rotation(origin: ET.Element) -> Array:
    """R (3, 3) from rpy, or from URDF 1.1's quaternion of any length."""
    quaternion = origin.get("quat_xyzw")
    if quaternion is None:
        return from_rpy(floats(origin.get("rpy", "0 0 0"), 3))
    if "rpy" in origin.attrib:
        raise ValueError("it has both rpy and quat_xyzw")
    return from_xyzw(floats(quaternion, 4))


def mesh_scale(text: str | None) -> tuple[float, ...]:
    """The mesh scale: three numbers, or one for all three."""
    values = [number(word) for word in (text or "1 1 1").split()]
    return tuple(floats(text or "1 1 1", 3)) if len(values) != 1 else (values[0],) * 3
