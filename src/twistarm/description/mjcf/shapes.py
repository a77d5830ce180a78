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
from .document import Attributes, Mjcf

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}
"""Numbers of each solid shape: half lengths, or a radius and half a length."""

OTHERS = ("plane", "hfield", "sdf")
"""Types of geoms that are not read."""

DENSITY = 1000.0
"""kg/m³ of a geom that gives neither mass nor density."""

HIDDEN = 3
"""The first group of geoms that MuJoCo's viewer does not show. Collision shapes usually have it."""


def several(text: str) -> list[float]:
    """All numbers of a text. ValueError for what is none."""
    return floats(text, len(text.split()))


def kind_of(given: Attributes) -> str:
    """The type of a geom."""
    return given.get("type", "mesh" if "mesh" in given else "sphere")


class Shapes:
    """The geoms of one MJCF, with its meshes and materials."""

    def __init__(self, mjcf: Mjcf) -> None:
        self._mjcf = mjcf
        meshes = [mjcf.attributes(mesh) for mesh in mjcf.each("asset", "mesh")]
        self._meshes = {mesh.get("name") or PurePath(mesh.get("file", "")).stem: mesh for mesh in meshes}
        materials = (mjcf.attributes(material) for material in mjcf.each("asset", "material"))
        self._colours = {given.get("name"): given.get("rgba", "1 1 1 1") for given in materials}

    def of(self, given: Attributes, frame: Array) -> tuple[list[ET.Element] | None, Body | None]:
        """The visual and the collision of a geom in a `frame` (4, 4) of the link, and its body.

        No elements for a shape that URDF lacks. No body for a mesh, or what MuJoCo fits to one. ValueError if a number
        is malformed.
        """
        kind, size, g = kind_of(given), several(given.get("size", "")), frame @ self._mjcf.pose(given)
        if kind == "mesh":
            return self._mesh(given, g), None
        if kind not in (*SIZES, *OTHERS):
            raise ValueError(f"type {kind[:60]!r} is none of {', '.join((*SIZES, 'mesh', *OTHERS))}")
        if kind in OTHERS or "mesh" in given:
            return None, None
        if "fromto" in given:
            a, b = np.array(floats(given["fromto"], 6)).reshape(2, 3)
            size = [*size[:1] * (SIZES[kind] - 1), float(np.linalg.norm(a - b)) / 2]
        if len(size) < SIZES[kind] or min(size) < 0.0:
            raise ValueError(
                f"a {kind} needs a size of {SIZES[kind]} numbers, none negative; got {given.get('size', '')[:60]!r}"
            )
        shape = {"radius": number_text(size[:1]), "length": number_text([2 * size[-1]])}
        if kind in ("box", "sphere"):
            shape = {"size": number_text(2 * x for x in size[:3])} if kind == "box" else {"radius": shape["radius"]}
        elements = None if kind == "ellipsoid" else self._elements(given, g, kind, shape)
        return elements, _body(kind, size[: SIZES[kind]], given, g)

    def _mesh(self, given: Attributes, g: Array) -> list[ET.Element] | None:
        mesh, settings = self._meshes.get(given.get("mesh", "")), self._mjcf.compiler
        if mesh is None:
            raise ValueError(f"its mesh {given.get('mesh', '')[:60]!r} is no asset")
        file, scale = mesh.get("file", ""), mesh.get("scale", "1 1 1")
        file = os.path.basename(file) if settings.get("strippath") == "true" else file
        path = os.path.join(settings.get("meshdir") or settings.get("assetdir", ""), file)
        reference = self._mjcf.pose({"pos": mesh.get("refpos", "0 0 0"), "quat": mesh.get("refquat", "1 0 0 0")})
        reference[:3, 3] *= floats(scale, 3)
        shape = {"filename": path, "scale": scale}
        return self._elements(given, g @ np.linalg.inv(reference), "mesh", shape) if file else None

    def _elements(self, given: Attributes, g: Array, kind: str, shape: dict[str, str]) -> list[ET.Element]:
        made = [ET.Element("visual")] if several(given.get("group", "0"))[:1] < [HIDDEN] else []
        if made:
            rgba = given.get("rgba") or self._colours.get(given.get("material"), "0.5 0.5 0.5 1")
            ET.SubElement(ET.SubElement(made[0], "material"), "color", rgba=rgba)
        if {given.get("contype", "1"), given.get("conaffinity", "1")} != {"0"}:
            made.append(ET.Element("collision"))
        for element in made:
            add_origin(element, g)
            ET.SubElement(ET.SubElement(element, "geometry"), kind, shape)
        return made


def _body(kind: str, size: list[float], given: Attributes, g: Array) -> Body:
    """The body of a solid shape."""
    a, b, c = size if len(size) == 3 else (size[0], size[0], size[-1])
    squares = np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    ball, rod = 4 / 3 * np.pi * a * b * c, 2 * np.pi * a * a * c
    volume, unit = ball, squares / 5
    if kind == "box":
        volume, unit = 8 * a * b * c, squares / 3
    elif kind in ("cylinder", "capsule"):
        ends = 4 / 3 * np.pi * a**3 if kind == "capsule" else 0.0
        volume, turned = ends + rod, ends * 0.4 * a * a + rod * a * a / 2
        across = ends * (0.4 * a * a + c * c + 0.75 * a * c) + rod * (a * a / 4 + c * c / 3)
        unit = np.array([across, across, turned]) / max(volume, 1e-300)
    mass = _mass(given["mass"]) if "mass" in given else _mass(given.get("density", str(DENSITY))) * volume
    return Body(mass, g[:3, 3], g[:3, :3] @ np.diag(mass * unit) @ g[:3, :3].T)


def _mass(text: str) -> float:
    """A mass or a density. ValueError if it is malformed or negative."""
    (number,) = floats(text, 1)
    if number < 0.0:
        raise ValueError(f"its mass or density is {number:g}; it must not be negative")
    return number


def explicit_body(given: Attributes, mjcf: Mjcf) -> Body:
    """The body of an `<inertial>` of MJCF. ValueError if a number is malformed."""
    g = mjcf.pose(given)
    xx, yy, zz, xy, xz, yz = floats(given.get("fullinertia") or given.get("diaginertia", "0 0 0") + " 0 0 0", 6)
    inertia = g[:3, :3] @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ g[:3, :3].T
    return Body(_mass(given.get("mass", "")), g[:3, 3], inertia)


def inertial_of(bodies: Iterable[Body], compiler: Attributes) -> list[ET.Element]:
    """The `<inertial>` of bodies that are fixed to each other, within the bounds of `<compiler>`; none without mass."""
    least, smallest = (_mass(compiler.get(word, "0")) for word in ("boundmass", "boundinertia"))
    every = [body for body in bodies if body.mass > 0] or [Body(least, np.zeros(3), np.zeros((3, 3)))]
    g, mass, inertia, element = np.eye(4), sum(body.mass for body in every), np.zeros((3, 3)), ET.Element("inertial")
    if mass == 0.0:
        return []
    g[:3, 3] = np.sum([body.mass * body.centre for body in every], axis=0) / mass
    for body in every:
        d = body.centre - g[:3, 3]
        inertia += body.inertia + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    moments, axes = np.linalg.eigh(inertia)
    if moments[0] < smallest:
        moments = np.maximum(moments, smallest)
        inertia = axes @ np.diag(moments) @ axes.T
    if compiler.get("balanceinertia") == "true" and 2 * moments[2] > moments.sum():  # no body has such moments
        inertia = np.eye(3) * moments.mean()
    add_origin(element, g)
    ET.SubElement(element, "mass", value=number_text([max(mass, least)]))
    words = number_text(inertia[np.triu_indices(3)]).split()
    ET.SubElement(element, "inertia", dict(zip(INERTIA, words, strict=True)))
    return [element]
