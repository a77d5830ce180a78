"""Geoms of MJCF as shapes of URDF, and the masses that MuJoCo computes from them."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import PurePath

import numpy as np

from ...support.checks import Array
from ..document import floats
from ..inertial import INERTIA, Body
from ..writing import add_origin, number_text
from .document import Attributes, Mjcf, from_z

DENSITY = "1000"
"""kg/m³ of a geom that gives neither mass nor density."""

HIDDEN = 3
"""The first group of geoms that MuJoCo's viewer does not show. Collision shapes usually have it."""


def several(text: str) -> list[float]:
    """All numbers of a text. ValueError for what is none."""
    return floats(text, len(text.split()))


class Shapes:
    """The geoms of one MJCF, with its meshes and materials."""

    def __init__(self, mjcf: Mjcf) -> None:
        self._mjcf = mjcf
        meshes = [mjcf.attributes(mesh) for mesh in mjcf.each("asset", "mesh")]
        self._meshes = {mesh.get("name") or PurePath(mesh.get("file", "")).stem: mesh for mesh in meshes}
        materials = (mjcf.attributes(material) for material in mjcf.each("asset", "material"))
        self._colours = {given.get("name"): given.get("rgba", "1 1 1 1") for given in materials}

    def of(self, given: Attributes, frame: Array) -> tuple[list[ET.Element], Body | None]:
        """The visual and the collision of a geom in a `frame` (4, 4) of the link, and its body.

        Without elements URDF has no such shape. The body is None for a mesh. ValueError if a number is malformed.
        """
        kind = given.get("type", "mesh" if "mesh" in given else "sphere")
        size, g = several(given.get("size", "")), frame @ self._mjcf.pose(given)
        if "fromto" in given:
            a, b = np.array(floats(given["fromto"], 6)).reshape(2, 3)
            half = float(np.linalg.norm(a - b) / 2)
            g = frame.copy()
            g[:3, :3] = frame[:3, :3] @ from_z(a - b)
            g[:3, 3] += frame[:3, :3] @ (a + b) / 2
            size = [*size[:1] * (1 if kind in ("capsule", "cylinder") else 2), half]
        need = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}.get(kind, 0)
        if kind == "mesh":
            return self._mesh(given, g), None
        if not need or "mesh" in given:  # a plane, a height field, or a shape that MuJoCo fits to a mesh
            return [], None
        if len(size) < need:
            raise ValueError(f"a {kind} needs a size of {need} numbers; got {given.get('size', '')[:60]!r}")
        if kind == "ellipsoid":
            return [], _body(kind, size, given, g)
        shape = {
            "sphere": {"radius": number_text(size[:1])},
            "box": {"size": number_text(2 * x for x in size[:3])},
        }.get(kind) or {"radius": number_text(size[:1]), "length": number_text([2 * size[1]])}
        return self._elements(given, g, kind, shape), _body(kind, size, given, g)

    def _mesh(self, given: Attributes, g: Array) -> list[ET.Element]:
        mesh, settings = self._meshes.get(given.get("mesh", "")), self._mjcf.compiler
        if mesh is None:
            raise ValueError(f"its mesh {given.get('mesh', '')[:60]!r} is no asset")
        file, scale = mesh.get("file", ""), mesh.get("scale", "1 1 1")
        if not file:
            return []
        file = os.path.basename(file) if settings.get("strippath") == "true" else file
        path = os.path.join(settings.get("meshdir") or settings.get("assetdir", ""), file)
        reference = self._mjcf.pose({"pos": mesh.get("refpos", "0 0 0"), "quat": mesh.get("refquat", "1 0 0 0")})
        reference[:3, 3] *= floats(scale, 3)
        return self._elements(given, g @ np.linalg.inv(reference), "mesh", {"filename": path, "scale": scale})

    def _elements(self, given: Attributes, g: Array, kind: str, shape: dict[str, str]) -> list[ET.Element]:
        tags = ["visual"] if several(given.get("group", "0"))[:1] < [HIDDEN] else []
        tags += ["collision"] if {given.get("contype", "1"), given.get("conaffinity", "1")} != {"0"} else []
        made = [ET.Element(tag) for tag in tags]
        for element in made:
            add_origin(element, g)
            ET.SubElement(ET.SubElement(element, "geometry"), kind, shape)
            if element.tag == "visual":
                rgba = given.get("rgba") or self._colours.get(given.get("material"), "0.5 0.5 0.5 1")
                ET.SubElement(ET.SubElement(element, "material"), "color", rgba=rgba)
        return made


def _body(kind: str, size: list[float], given: Attributes, g: Array) -> Body:
    """The body of a solid shape. `size` holds half lengths, or the radius and half the length."""
    a, b, c = (size * 3)[:3] if kind == "sphere" else [size[0], *size][:3] if len(size) == 2 else size[:3]
    squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    volume, unit = {
        "box": (8 * a * b * c, squares / 3),
        "cylinder": (2 * np.pi * a * a * c, np.array([a * a / 4 + c * c / 3] * 2 + [a * a / 2])),
    }.get(kind, (4 / 3 * np.pi * a * b * c, squares / 5))
    if kind == "capsule":
        ball, rod = 4 / 3 * np.pi * a**3, 2 * np.pi * a * a * c
        volume, across = ball + rod, ball * (0.4 * a * a + c * c + 0.75 * a * c) + rod * (a * a / 4 + c * c / 3)
        unit = np.array([across, across, ball * 0.4 * a * a + rod * a * a / 2]) / max(volume, 1e-300)
    (mass,) = floats(given.get("mass") or number_text([floats(given.get("density", DENSITY), 1)[0] * volume]), 1)
    return Body(mass, g[:3, 3], g[:3, :3] @ np.diag(mass * unit) @ g[:3, :3].T)


def explicit_body(given: Attributes, mjcf: Mjcf) -> Body:
    """The body of an `<inertial>` of MJCF. ValueError if a number is malformed."""
    g = mjcf.pose(given)
    words = given.get("fullinertia") or given.get("diaginertia", "0 0 0") + " 0 0 0"
    xx, yy, zz, xy, xz, yz = floats(words, 6)
    inertia = g[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ g[:3, :3].T
    return Body(floats(given.get("mass", ""), 1)[0], g[:3, 3], inertia)


def inertial_of(bodies: Iterable[Body]) -> list[ET.Element]:
    """The `<inertial>` of bodies that are fixed to each other; none without mass."""
    every = [body for body in bodies if body.mass > 0]
    if not every:
        return []
    g, mass, inertia = np.eye(4), sum(body.mass for body in every), np.zeros((3, 3))
    g[:3, 3] = np.sum([body.mass * body.centre for body in every], axis=0) / mass
    for body in every:
        d = body.centre - g[:3, 3]
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    element = ET.Element("inertial")
    add_origin(element, g)
    ET.SubElement(element, "mass", value=number_text([mass]))
    words = number_text(inertia[np.triu_indices(3)]).split()
    ET.SubElement(element, "inertia", dict(zip(INERTIA, words, strict=True)))
    return [element]
