"""An MJCF as one tree: included files in place, compiler settings merged, default classes resolved."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...support.checks import Array
from ...support.errors import DescriptionError, closest
from ...theory import rotations
from ...theory.joints import plane_axes
from ..document import MAX_NESTING, MAX_PARTS, Reading, floats, parse_xml
from ..expansion.confinement import Confinement
from ..expansion.work import Refused
from ..findings import refusal

MAIN = "main"
"""The class of elements that name none."""

ACTUATORS = ("general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle")
"""One kind of element under several names. They share their defaults."""

_ORIENTATIONS = ("quat", "axisangle", "euler", "xyaxes", "zaxis")

Attributes = dict[str, str]


@dataclass
class Mjcf:
    """An MJCF in one piece. `readings` know the files and lines of its elements, the main file first.

    `classes` has the defaults of each class by tag, with those of the classes around it.
    """

    root: ET.Element
    readings: list[Reading]
    compiler: Attributes = field(default_factory=dict)
    classes: dict[str, dict[str, Attributes]] = field(default_factory=dict)

    def each(self, section: str, *tags: str) -> Iterator[ET.Element]:
        """The elements with one of these tags in all sections of a name."""
        for part in self.root.findall(section):
            yield from (element for element in part if element.tag in tags)

    def attributes(self, element: ET.Element, childclass: str = MAIN) -> Attributes:
        """The element's attributes over the defaults of its class, or of the nearest `childclass` around it."""
        name = element.get("class") or childclass
        if name not in self.classes:
            remedy = f"correct the name{closest(name, self.classes)}"
            raise self.error(element, f"its default class {name!r} does not exist", remedy)
        defaults = self.classes[name].get(_kind(element.tag), {})
        if any(word in element.attrib for word in (*_ORIENTATIONS, "fromto")):
            defaults = {key: value for key, value in defaults.items() if key not in (*_ORIENTATIONS, "fromto")}
        return {**defaults, **element.attrib}

    def error(self, element: ET.Element, what: str, remedy: str = "correct it there") -> DescriptionError:
        """The error for an unusable element, with its file and line."""
        return refusal("mjcf-unusable", self.reading_of(element).place(element), what, remedy)

    def reading_of(self, element: ET.Element) -> Reading:
        """The reading of the element's file."""
        return next((each for each in self.readings if element in each.lines), self.readings[0])

    def angle(self, value: float) -> float:
        """An angle of the file in radians. The default is degrees."""
        return value if self.compiler.get("angle") == "radian" else float(np.radians(value))

    def pose(self, given: Attributes) -> Array:
        """The pose (4, 4) of `pos` and an orientation in any of its forms. ValueError if one is malformed."""
        g = np.eye(4)
        g[:3, 3] = floats(given.get("pos", "0 0 0"), 3)
        form = next((word for word in reversed(_ORIENTATIONS) if word in given), None)
        if form is not None:
            g[:3, :3] = self._rotation(form, given[form])
        return g

    def _rotation(self, form: str, text: str) -> Array:
        if form == "quat":
            return rotations.from_quaternion_wxyz(floats(text, 4))
        if form == "axisangle":
            *axis, angle = floats(text, 4)
            return rotations.from_axis_angle(axis, self.angle(angle))
        if form == "zaxis":
            return from_z(np.array(floats(text, 3)))
        if form == "xyaxes":
            x, y = np.array(floats(text, 6)).reshape(2, 3)
            return plane_axes(np.cross(x, y), x)
        R = np.eye(3)
        for letter, angle in zip(self.compiler.get("eulerseq", "xyz"), floats(text, 3), strict=True):
            turn = rotations.exp(np.eye(3)["xyz".index(letter.lower())], self.angle(angle))
            R = R @ turn if letter.islower() else turn @ R
        return R


def read_mjcf(root: ET.Element, reading: Reading) -> Mjcf:
    """The whole MJCF of a main file's root element.

    Included files must lie where xacro's may (`Confinement`), and count once. Raises DescriptionError otherwise.
    """
    mjcf = Mjcf(root, [reading])
    confinement = Confinement(reading.path, reading.packages)
    seen: set[Path] = set()

    def place_includes(parent: ET.Element, deep: int) -> None:
        if deep > MAX_NESTING:
            raise mjcf.error(parent, f"elements are nested more than {MAX_NESTING} deep")
        merged: list[ET.Element] = []
        waiting = list(reversed(parent))
        while waiting:
            element = waiting.pop()
            if element.tag == "include":
                waiting += reversed(_included(element, mjcf, confinement, seen))
            else:
                merged.append(element)
        parent[:] = merged
        for element in merged:
            place_includes(element, deep + 1)

    place_includes(root, 1)
    for compiler in root.findall("compiler"):
        mjcf.compiler.update(compiler.attrib)
    if not set(mjcf.compiler.get("eulerseq", "xyz")) <= set("xyzXYZ"):
        raise refusal("mjcf-unusable", reading.whole, "its eulerseq has other letters than xyzXYZ", "correct it there")
    mjcf.classes[MAIN] = {}
    for default in root.findall("default"):
        mjcf.classes.setdefault(default.get("class", MAIN), mjcf.classes[MAIN])
        _read_defaults(default, MAIN, mjcf)
    return mjcf


def _included(element: ET.Element, mjcf: Mjcf, confinement: Confinement, seen: set[Path]) -> list[ET.Element]:
    """The elements of an included file, which is looked for beside the main file, then beside the including one."""
    name = element.get("file", "").strip()
    folders = dict.fromkeys(each.path.parent for each in (mjcf.readings[0], mjcf.reading_of(element)))
    refused: Refused | OSError | None = None
    for folder in folders:
        try:
            path, text = confinement.read(str(folder / name))
            break
        except (Refused, OSError) as error:
            refused = refused or error
    else:
        place = mjcf.reading_of(element).place(element)
        if isinstance(refused, Refused):
            raise refusal(refused.code, place, refused.what, refused.remedy) from refused
        why = str(getattr(refused, "strerror", refused))
        raise refusal("mjcf-unusable", place, f"its file {name[:200]!r} cannot be read: {why}", "correct the path")
    if path in seen or path == mjcf.readings[0].path:
        raise mjcf.error(element, f"its file {name[:200]!r} is included already", "include each file once")
    seen.add(path)
    part = Reading(path, mjcf.readings[0].packages)
    elements = list(parse_xml(text, part))
    mjcf.readings.append(part)
    if sum(len(each.lines) for each in mjcf.readings) > MAX_PARTS:
        what = f"with its included files it has more than {MAX_PARTS:,} elements"
        raise refusal("file-too-large", mjcf.readings[0].whole, what, "leave out what the arm does not need")
    return elements


def _read_defaults(default: ET.Element, name: str, mjcf: Mjcf) -> None:
    """Read the defaults of a class before those of the classes inside, which start from them."""
    for element in default:
        if element.tag != "default":
            mjcf.classes[name].setdefault(_kind(element.tag), {}).update(element.attrib)
    for inner in default.findall("default"):
        called = inner.get("class", "")
        if not called or called in mjcf.classes:
            why = f"the name {called!r} is taken" if called else "it has no name"
            raise mjcf.error(inner, f"a default class inside another: {why}", "give each class a name of its own")
        mjcf.classes[called] = {kind: dict(given) for kind, given in mjcf.classes[name].items()}
        _read_defaults(inner, called, mjcf)


def _kind(tag: str) -> str:
    return ACTUATORS[0] if tag in ACTUATORS else tag


def from_z(direction: Array) -> Array:
    """The rotation (3, 3) of least angle from z to a direction (3,). ValueError for a zero one."""
    length = float(np.linalg.norm(direction))
    if length < 1e-10:
        raise ValueError("an axis or a length is zero")
    axis = np.cross([0.0, 0.0, 1.0], direction / length)
    angle = np.arctan2(np.linalg.norm(axis), direction[2] / length)
    return rotations.from_axis_angle(axis if axis.any() else [1.0, 0.0, 0.0], angle)
