"""Elements of URDF, with numbers that read back as the same bits; capsules by shapes that every reader knows."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy

import numpy as np

from ..support.checks import Array
from ..theory.rotations import to_rpy
from .bounds import NO_LIMIT
from .document import floats
from .geometry import read_origin


def number_text(numbers: Iterable[float]) -> str:
    """Digits that read back as the same numbers. Adding 0 drops the sign of a zero."""
    return " ".join(repr(float(number) + 0.0) for number in numbers)


def add_origin(element: ET.Element, g: Array) -> None:
    """Add the `<origin>` of a pose (4, 4)."""
    rpy = np.zeros(3) if np.array_equal(g[:3, :3], np.eye(3)) else to_rpy(g[:3, :3])
    ET.SubElement(element, "origin", xyz=number_text(g[:3, 3]), rpy=number_text(rpy))


def add_joint(
    robot: ET.Element,
    name: str,
    kind: str,
    ends: tuple[str, str],
    origin: Array,
    axis: Iterable[float] = (),
    limit: Mapping[str, float] | None = None,
) -> ET.Element:
    """Add a joint from the first of the links `ends` to a new link, the second. Return the joint's element.

    Readers of URDF refuse infinity; `NO_LIMIT` replaces it.
    """
    ET.SubElement(robot, "link", name=ends[1])
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=ends[0])
    ET.SubElement(joint, "child", link=ends[1])
    add_origin(joint, origin)
    if kind != "fixed":
        ET.SubElement(joint, "axis", xyz=number_text(axis))
    if limit:
        numbers = {key: repr(float(np.clip(value, -NO_LIMIT, NO_LIMIT))) for key, value in limit.items()}
        ET.SubElement(joint, "limit", numbers)
    return joint


def add_mimic(joint: ET.Element, master: str, multiplier: float, offset: float = 0.0) -> None:
    """Let a joint follow another: value = multiplier · (value of `master`) + offset."""
    ET.SubElement(joint, "mimic", joint=master, multiplier=repr(float(multiplier)), offset=repr(float(offset)))


def replace_capsules(robot: ET.Element) -> None:
    """Put a cylinder and two spheres in place of each capsule, which most readers of URDF refuse.

    ROS reads capsules from urdfdom 5.1 on, and only in a file of version 1.1 or more.
    """
    for link in robot.iter("link"):
        link[:] = [
            part for shape in link for part in ([shape] if shape.find("geometry/capsule") is None else _parts(shape))
        ]


def _parts(capsule: ET.Element) -> Iterator[ET.Element]:
    """The cylinder and the spheres at its ends."""
    sizes = dict(capsule.findall("geometry/capsule")[0].attrib)
    length = floats(sizes["length"], 1)[0]
    ball = {"radius": sizes["radius"]}
    for shape, size, z in (("cylinder", sizes, 0.0), ("sphere", ball, length / 2), ("sphere", ball, -length / 2)):
        part, along = deepcopy(capsule), np.eye(4)
        part.tail, along[2, 3] = None, z
        g = read_origin(part) @ along
        part[:] = [child for child in part if child.tag not in ("origin", "geometry")]
        part.attrib.pop("name", None)  # names of shapes are unique
        add_origin(part, g)
        ET.SubElement(ET.SubElement(part, "geometry"), shape, size)
        yield part
