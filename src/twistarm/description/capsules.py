"""Capsules in the words of URDF 1.0."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from copy import deepcopy

import numpy as np

from .document import floats
from .geometry import read_origin
from .writing import add_origin


def replace_capsules(robot: ET.Element) -> None:
    """Put a cylinder and two spheres in place of each capsule, which most readers of URDF refuse.

    ROS reads capsules from urdfdom 5.1 on, and only in a file of version 1.1 or more.
    """
    for link in robot.iter("link"):
        link[:] = [
            part for shape in link for part in ([shape] if shape.find("geometry/capsule") is None else _parts(shape))
        ]


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
