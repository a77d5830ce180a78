"""An MJCF as one tree: included files in place, compiler settings merged, default classes resolved."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from ...support.checks import Array
from ...support.errors import DescriptionError, closest
from ...theory import rotations
from ...theory.joints import plane_axes
from .. import structure
from ..document import MAX_NESTING, MAX_PARTS, Reading, floats, parse_xml
from ..expansion.confinement import Confinement, Refused
from ..findings import refusal

MAIN = "main"
"""The class of elements that name none."""

ACTUATORS = ("general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "pid")
"""One kind of element under several names. They share their defaults."""

EQUALITY = "equality"
"""The kind of all constraints. They share their defaults too."""

KINDS = ("joint", "site", "geom", "mesh", "material", EQUALITY, ACTUATORS[0])
"""Elements with defaults that are read."""

ORIENTATIONS = ("quat", "zaxis", "xyaxes", "euler", "axisangle")
"""Forms of an orientation. An element has one of them at most."""

KEYWORDS = {"angle": ("degree", "radian"), "coordinate": ("local",), "inertiafromgeom": ("auto", "true", "false")}
"""Settings of `<compiler>` that change what is read, and their values. MuJoCo takes no others."""

MOST_ATTRIBUTES = 100
"""Of the defaults of one kind. No element has as many, and each class inside takes them over."""

MOST = {"body": structure.MAX_PARTS["link"], "geom": structure.MAX_PARTS["visual"]}
MOST |= dict.fromkeys(("joint", "site", "key", "default"), structure.MAX_PARTS["joint"])
"""Most elements of a kind, as of a URDF."""

Attributes = dict[str, str]


@dataclass
class Mjcf:
    """An MJCF in one piece. `readings` know the files and lines of its elements, the main file first.

    `classes` has the defaults of each class by kind, with those that the class around it had when it began.
    """

    root: ET.Element
    readings: list[Reading]
    compiler: Attributes = field(default_factory=dict)
    classes: dict[str, dict[str, Attributes]] = field(default_factory=lambda: {MAIN: {}})

    def each(self, section: str, *tags: str) -> Iterator[ET.Element]:
        """The elements with one of these tags in all sections of a name."""
        return (element for part in self.root.findall(section) for element in part if element.tag in tags)

    def attributes(self, element: ET.Element, childclass: str = MAIN, kind: str = "") -> Attributes:
        """The element's attributes over the defaults of its class, or of the nearest `childclass` around it."""
        name = element.get("class") or childclass
        if name not in self.classes:
            remedy = f"correct the name{closest(name, self.classes)}"
            raise self.error(element, f"its default class {name!r} does not exist", remedy)
        return _over(self.classes[name].get(kind or _kind(element), {}), element.attrib)

    def reading_of(self, element: ET.Element) -> Reading:
        """The reading of the element's file."""
        return next((each for each in self.readings if element in each.lines), self.readings[0])

    def error(self, element: ET.Element, what: str, remedy: str = "correct it there") -> DescriptionError:
        """The error for an unusable element, with its file and line."""
        return refusal("mjcf-unusable", self.reading_of(element).place(element), what, remedy)

    @contextmanager
    def blaming(self, element: ET.Element) -> Iterator[None]:
        """Put the place of an element before the message about a malformed value in it."""
        try:
            yield
        except ValueError as error:
            raise self.error(element, str(error)) from error

    def angle(self, value: float) -> float:
        """An angle of the file in radians. The default is degrees."""
        return value if self.compiler.get("angle") == "radian" else float(np.radians(value))

    def pose(self, given: Attributes) -> Array:
        """The pose (4, 4) of `fromto`, or of `pos` and an orientation.

        `quat` counts if no other form is there, as in MuJoCo.
        """
        g = np.eye(4)
        g[:3, 3] = floats(given.get("pos", "0 0 0"), 3)
        if "fromto" in given:
            a, b = np.array(floats(given["fromto"], 6)).reshape(2, 3)
            g[:3, :3], g[:3, 3] = from_z(a - b), (a + b) / 2
        elif "zaxis" in given:
            g[:3, :3] = from_z(np.array(floats(given["zaxis"], 3)))
        elif "xyaxes" in given:
            x, y = np.array(floats(given["xyaxes"], 6)).reshape(2, 3)
            g[:3, :3] = plane_axes(np.cross(x, y), x)
        elif "euler" in given:
            letters = self.compiler.get("eulerseq", "xyz")
            if len(letters) != 3 or not set(letters) <= set("xyzXYZ"):
                raise ValueError(f"eulerseq {letters[:60]!r} is not three letters of xyzXYZ")
            for letter, angle in zip(letters, floats(given["euler"], 3), strict=True):
                turn = rotations.exp(np.eye(3)["xyz".index(letter.lower())], self.angle(angle))
                g[:3, :3] = g[:3, :3] @ turn if letter.islower() else turn @ g[:3, :3]
        elif "axisangle" in given:
            *axis, angle = floats(given["axisangle"], 4)
            g[:3, :3] = rotations.from_axis_angle(axis, self.angle(angle))
        elif "quat" in given:
            g[:3, :3] = rotations.from_quaternion_wxyz(floats(given["quat"], 4))
        return g


def read_mjcf(root: ET.Element, reading: Reading) -> Mjcf:
    """The whole MJCF of a main file's root element.

    Included files must lie where xacro's may (`Confinement`), and count once. Raises DescriptionError otherwise.
    """
    mjcf = Mjcf(root, [reading])
    _place_includes(root, mjcf, Confinement(reading.path, reading.packages))
    counts = Counter(element.tag for element in root.iter())
    for tag, most in MOST.items():
        if counts[tag] > most:
            what = f"it has {counts[tag]:,} elements <{tag}>; at most {most:,} are read"
            raise refusal("too-many-parts", reading.whole, what, "is it a whole scene? leave out all but the robot")
    for compiler in root.findall("compiler"):
        mjcf.compiler.update(compiler.attrib)
        for word, allowed in KEYWORDS.items():
            if compiler.get(word, allowed[0]) not in allowed:
                raise mjcf.error(compiler, f"{word} {compiler.get(word, '')[:60]!r} is none of {', '.join(allowed)}")
    for default in root.findall("default"):
        mjcf.classes.setdefault(default.get("class", MAIN), mjcf.classes[MAIN])
        _read_defaults(default, MAIN, mjcf)
    return mjcf


def _place_includes(parent: ET.Element, mjcf: Mjcf, confinement: Confinement, deep: int = 1) -> None:
    if deep > MAX_NESTING:
        raise mjcf.error(parent, f"elements are nested more than {MAX_NESTING} deep")
    waiting, parent[:] = list(reversed(parent)), []
    while waiting:
        element = waiting.pop()
        if element.tag == "include":
            waiting += reversed(_included(element, mjcf, confinement))
        else:
            parent.append(element)
            _place_includes(element, mjcf, confinement, deep + 1)


def _included(element: ET.Element, mjcf: Mjcf, confinement: Confinement) -> ET.Element:
    """The root of an included file, which is looked for beside the main file, then beside the including one."""
    name, at = element.get("file", "").strip()[:200], mjcf.reading_of(element)
    beside, main = at.path.parent / name, mjcf.readings[0].path.parent / name
    try:
        path, text = confinement.read(str(main if main.is_file() else beside))
    except Refused as refused:
        raise refusal(refused.code, at.place(element), refused.what, refused.remedy) from refused
    except OSError as error:
        raise mjcf.error(element, f"its file {name!r} cannot be read: {error.strerror}", "correct the path") from error
    if any(path == each.path for each in mjcf.readings):
        raise mjcf.error(element, f"its file {name!r} is included already", "include each file once")
    mjcf.readings.append(Reading(path, at.packages))
    root = parse_xml(text, mjcf.readings[-1])
    if sum(len(each.lines) for each in mjcf.readings) > MAX_PARTS:
        what = f"with its included files it has more than {MAX_PARTS:,} elements"
        raise refusal("file-too-large", mjcf.readings[0].whole, what, "leave out what the arm does not need")
    return root


def _read_defaults(default: ET.Element, name: str, mjcf: Mjcf) -> None:
    """Read the defaults of a class before those of the classes inside, which start from them."""
    kinds = mjcf.classes[name]
    for element in default:
        if _kind(element) in KINDS:
            kinds[_kind(element)] = _over(kinds.get(_kind(element), {}), element.attrib)
            if len(kinds[_kind(element)]) > MOST_ATTRIBUTES:
                raise mjcf.error(element, f"it has more than {MOST_ATTRIBUTES} attributes")
    for inner in default.findall("default"):
        called = inner.get("class", "")
        if not called or called in mjcf.classes:
            raise mjcf.error(inner, f"the name {called!r} of a class is empty or taken", "give each class its own name")
        mjcf.classes[called] = dict(kinds)
        _read_defaults(inner, called, mjcf)


def _over(defaults: Attributes, given: Attributes) -> Attributes:
    """Attributes over defaults. A form of orientation replaces another, and a size fills up with the default's."""
    if not given.keys().isdisjoint(ORIENTATIONS):
        defaults = {word: value for word, value in defaults.items() if word not in ORIENTATIONS}
    both = {**defaults, **given}
    if "size" in given:
        words = given["size"].split()
        both["size"] = " ".join([*words, *defaults.get("size", "").split()[len(words) :]])
    return both


def _kind(element: ET.Element) -> str:
    return ACTUATORS[0] if element.tag in ACTUATORS else element.tag


def from_z(direction: Array) -> Array:
    """The rotation (3, 3) of least angle from z to a direction (3,). ValueError for a zero one."""
    if np.linalg.norm(direction) < 1e-10:
        raise ValueError("an axis or a length is zero")
    axis = np.cross([0.0, 0.0, 1.0], direction)
    angle = np.arctan2(np.linalg.norm(axis), direction[2])
    return rotations.from_axis_angle(axis if axis.any() else [1.0, 0.0, 0.0], angle)
