"""Capsules in the words of URDF 1.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from copy import deepcopy

import numpy as np

from .document import floats
from .geometry import read_origin
from .source_text import SourceText
from .writing import add_origin


def without_capsules(text: str) -> str:
    """A URDF with a cylinder and two spheres for each capsule, which most readers of URDF refuse.

    ROS reads capsules from urdfdom 5.1 on, and only in a file of version 1.1 or more.
    """
    if "<capsule" not in text:
        return text
    source = SourceText(text)
    for link in source.robot.iter("link"):
        capsules = [part for part in link if part.find("geometry/capsule") is not None]
        for part in capsules:
            source.remove(part)
        if capsules:
            parts = [each for part in capsules for each in _parts(part)]
            source.insert(link, "".join(ET.tostring(each, encoding="unicode") for each in parts))
    return source.edited()


def _parts(capsule: ET.Element) -> list[ET.Element]:
    """The cylinder and the spheres at its ends; one sphere if the capsule has no length."""
    given = capsule.find("geometry/capsule")
    assert given is not None
    sizes = dict(given.attrib)
    length = floats(sizes.pop("length", ""), 1)[0]
    made = [_part(capsule, "cylinder", dict(given.attrib), 0.0)] if length else []
    return made + [_part(capsule, "sphere", sizes, z) for z in sorted({length / 2, -length / 2})]


def _part(capsule: ET.Element, shape: str, sizes: dict[str, str], z: float) -> ET.Element:
    """A copy of the visual or collision with another shape, z [m] along the capsule's axis, and without the name."""
    part, along = deepcopy(capsule), np.eye(4)
    along[2, 3], part.tail = z, None
    g = read_origin(part) @ along
    for old in part.findall("origin") + part.findall("geometry"):
        part.remove(old)
    part.attrib.pop("name", None)  # names of shapes are unique
    add_origin(part, g)
    ET.SubElement(ET.SubElement(part, "geometry"), shape, sizes)
    return part
