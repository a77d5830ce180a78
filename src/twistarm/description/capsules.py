"""Capsules in the words of URDF 1.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
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
            source.insert(link, "".join(ET.tostring(each, "unicode") for part in capsules for each in _parts(part)))
    return source.edited()


def _parts(capsule: ET.Element) -> Iterator[ET.Element]:
    """The cylinder and the spheres at its ends; one sphere if the capsule has no length."""
    sizes = dict(capsule.findall("geometry/capsule")[0].attrib)
    length = floats(sizes["length"], 1)[0]
    ball = {"radius": sizes["radius"]}
    for shape, size, z in (("cylinder", sizes, 0.0), ("sphere", ball, length / 2), ("sphere", ball, -length / 2)):
        if length or (shape == "sphere" and not np.signbit(z)):
            part, along = deepcopy(capsule), np.eye(4)
            part.tail, along[2, 3] = None, z
            g = read_origin(part) @ along
            part[:] = [each for each in part if each.tag not in ("origin", "geometry")]
            part.attrib.pop("name", None)  # names of shapes are unique
            add_origin(part, g)
            ET.SubElement(ET.SubElement(part, "geometry"), shape, size)
            yield part
