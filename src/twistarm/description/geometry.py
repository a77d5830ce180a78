"""Shapes, masses and inertias of links: sizes, colours as urdfdom resolves them, and absolute paths of meshes."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..support.checks import Array
from ..support.errors import listed, without_places
from ..support.messages import plural
from ..theory.rotations import from_rpy, from_xyzw
from .document import Reading, floats
from .packages import resolve_uri, why_missing
from .structure import ATTRIBUTES
from .tree import Description, Geometry

Colour = tuple[float, float, float, float]


class Geometries:
    """Reads the shapes of one description, and collects odd colours and missing meshes.

    The name of a colour keeps its first one: the robot's, else that of the first visual in the file. Another colour for
    the same name later has no effect. A material without a name has the colour that it gives.
    """

    def __init__(self, robot: ET.Element, reading: Reading) -> None:
        self._reading = reading
        self._missing: list[str] = []
        self._colours: dict[str, Colour | None] = {}  # None for a texture
        self._twice: dict[str, None] = {}
        self._odd: dict[str, None] = {}
        self._unnamed: dict[str, None] = {}
        self._undefined: dict[str, None] = {}
        for material in robot.findall("material"):
            self._colour(material, robot)

    def of(self, link: ET.Element, kind: str) -> tuple[Geometry, ...]:
        """The link's shapes of a `kind`, "visual" or "collision". Unusable ones are noted and left out."""
        return tuple(shape for element in link.findall(kind) if (shape := self._read(link, element)) is not None)

    def note_odd(self) -> None:
        """Add findings for odd colours and missing meshes, one for all meshes with the same remedy."""
        if self._twice:
            names = listed(self._twice, 3)
            what = f"{plural(len(self._twice), 'material')} with several colours: {names}; the first of a name counts"
            self._reading.note("bad-geometry", None, what, "give each colour a name of its own")
        if self._unnamed:
            what = f"a <material> without a name in {listed(self._unnamed, 3)}; others drop it and the shapes"
            self._reading.note("word-unread", None, what, 'write <material name="…">')
        if self._undefined:
            what = f"no colour is defined before the <material> {listed(self._undefined, 3)}; drawn without one"
            self._reading.note("bad-geometry", None, what, "give it a <color>, or correct its name")
        for rgba in self._odd:
            what = f"the colour rgba={rgba[:60]!r} is not four numbers from 0 to 1; the nearest colour is drawn, if any"
            self._reading.note("bad-geometry", None, what, 'write rgba="RED GREEN BLUE ALPHA"')
        causes: dict[tuple[str, str], list[str]] = {}
        for uri in dict.fromkeys(self._missing):
            cause = why_missing(uri, self._reading.packages)
            causes.setdefault(cause, []).append(without_places(uri, Path(uri.removeprefix("file://"))))
        for (why, remedy), names_of in causes.items():
            missing = f"{plural(len(names_of), 'mesh file')} not found: {listed(names_of, 2)}"
            what = f"{missing}; {why}; the kinematics is not affected"
            self._reading.note("mesh-missing", None, what, f"{remedy}; simple shapes are drawn instead")

    def _colour(self, material: ET.Element | None, owner: ET.Element) -> Colour | None:
        """The colour of a `<material>` of the robot or a link, None if neither the element nor its name has one.

        Three numbers are opaque, and others become the nearest from 0 to 1.
        """
        if material is None:
            return None
        if "name" not in material.attrib:
            self._unnamed[owner.get("name", "")] = None
        name, element, own = material.get("name", ""), material.find("color"), None
        if element is not None:
            rgba = element.get("rgba", "")
            try:
                values = floats(rgba, 3 if len(rgba.split()) == 3 else 4)
                red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in [*values, 1.0][:4])
                own = red, green, blue, alpha
            except ValueError:
                values = []
            if own is None or list(own) != values:
                self._odd[rgba] = None
        if name and (own is not None or material.find("texture") is not None):
            if self._colours.setdefault(name, own) != own:
                self._twice[name] = None
        elif name and element is None and name not in self._colours:
            self._undefined[name] = None
        return self._colours.get(name) if name else own

    def _read(self, link: ET.Element, element: ET.Element) -> Geometry | None:
        geometry = element.find("geometry")
        if geometry is None or len(geometry) == 0:
            return None
        shape, material = geometry[0], element.find("material") if element.tag == "visual" else None
        try:
            origin, size, colour = read_origin(element), _size(shape), self._colour(material, link)
        except ValueError:
            what = f"its <{element.tag}> <{shape.tag}> has no usable size or place; it is not drawn"
            self._reading.note("bad-geometry", link, what, "give every size and origin as numbers")
            return None
        if shape.tag == "mesh":
            uri = shape.get("filename", "")
            path = resolve_uri(uri, self._reading.packages)
            if path is None:
                self._missing.append(uri)
            return Geometry("mesh", origin, size, path, colour)
        # A box may be flat, a cylinder a disc, a capsule a ball.
        seen = np.count_nonzero(size) >= 2 if shape.tag == "box" else size[0] != 0.0
        if min(size) < 0.0 or not seen:
            drawn = "it is drawn with positive sizes" if seen else "it is invisible"
            what = f"its <{shape.tag}> has the size {' '.join(f'{x:g}' for x in size)}; {drawn}"
            self._reading.note("bad-geometry", link, what, "give sizes above 0")
        return Geometry(shape.tag, origin, tuple(map(abs, size)), None, colour) if seen else None  # type: ignore[arg-type]


def _size(shape: ET.Element) -> tuple[float, ...]:
    """The numbers of a `<geometry>`'s shape, for a mesh its scale. ValueError for another shape or no numbers."""
    if shape.tag == "mesh":
        scale = shape.get("scale") or "1 1 1"
        return tuple(floats(scale, 1) * 3 if len(scale.split()) == 1 else floats(scale, 3))
    if shape.tag == "box":
        return tuple(floats(shape.get("size", ""), 3))
    names = {"cylinder": ("radius", "length"), "capsule": ("radius", "length"), "sphere": ("radius",)}
    if shape.tag not in names:
        raise ValueError(shape.tag)
    return tuple(floats(shape.get(name, ""), 1)[0] for name in names[shape.tag])


def read_origin(element: ET.Element) -> Array:
    """The `<origin>` of an element as a pose (4, 4), the identity without one. ValueError if it is malformed.

    Its rotation is `rpy`, or a quaternion `quat_xyzw` of any length, which URDF has from version 1.1 on.
    """
    g, origin = np.eye(4), element.find("origin")
    if origin is None:
        return g
    g[:3, 3] = floats(origin.get("xyz", "0 0 0"), 3)
    rpy, quaternion = floats(origin.get("rpy", "0 0 0"), 3), origin.get("quat_xyzw")
    if quaternion is not None and "rpy" in origin.attrib:
        raise ValueError("it has both rpy and quat_xyzw")
    if quaternion is not None:
        g[:3, :3] = from_xyzw(floats(quaternion, 4))
    elif any(rpy):  # most are zero, and a large file has thousands
        g[:3, :3] = from_rpy(rpy)
    return g


@dataclass(frozen=True)
class Body:
    """A link's mass [kg], its centre of mass (3,) [m] in the link's frame, and its inertia.

    The inertia (3, 3) [kg m²] is about the centre, in the link's axes.
    """

    mass: float
    centre: Array
    inertia: Array


INERTIA = ATTRIBUTES["inertia"]
INERTIAL_REMEDY = "write mass in kg and the six inertias in kg m² as plain numbers"


def bodies(description: Description) -> dict[str, Body]:
    """Every link with a mass or an inertia, from the repaired text."""
    robot = ET.fromstring(description.repaired)
    inertials = {link.get("name", ""): link.find("inertial") for link in robot.findall("link")}
    found = {}
    for name, inertial in inertials.items():
        if inertial is None:
            continue
        mass, inertia, g = inertial.find("mass"), inertial.find("inertia"), read_origin(inertial)
        xx, xy, xz, yy, yz, zz = (0.0 if inertia is None else float(inertia.get(key, "0")) for key in INERTIA)
        about = g[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ g[:3, :3].T
        body = Body(0.0 if mass is None else float(mass.get("value", "0")), g[:3, 3], about)
        if body.mass > 0 or body.inertia.any():
            found[name] = body
    return found


def drop_unusable_inertials(robot: ET.Element, reading: Reading) -> None:
    """Remove every unreadable `<inertial>`. Kinematics does not need it, gravity torques do."""
    for link in robot.findall("link"):
        first = link.find("inertial")
        link[:] = [child for child in link if child.tag != "inertial" or child is first]
        if first is None:
            continue
        inertia = first.find("inertia")
        lacking = [] if inertia is None else [name for name in INERTIA if name not in inertia.attrib]
        if problem := inertial_problem(first):
            link.remove(first)
            what = f"its <inertial> {problem}; the link counts as massless"
            reading.note("inertial-unusable", link, what, INERTIAL_REMEDY)
        elif lacking:
            what = f"its <inertia> has no {', '.join(lacking)}: read as 0, and other readers refuse the link"
            reading.note("inertial-unusable", link, what, INERTIAL_REMEDY)


def inertial_problem(inertial: ET.Element) -> str:
    """Why an `<inertial>` is unusable, or an empty text."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        return "lacks <mass> or <inertia>"
    try:
        (value,) = floats(mass.get("value", ""), 1)
        for name in INERTIA:
            floats(inertia.get(name, "0"), 1)
        read_origin(inertial)
    except ValueError as error:
        return f"is malformed ({error})"
    return f"has the negative mass {value:g}" if value < 0 else ""
