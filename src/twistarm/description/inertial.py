"""Masses and inertias. Malformed ones are noted and dropped, which Pinocchio would do silently."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import numpy as np

from ..support.checks import Array
from .document import Reading, floats
from .geometry import read_origin
from .tree import Description


@dataclass(frozen=True)
class Body:
    """A link's mass [kg], its centre of mass (3,) [m] in the link's frame, and its inertia.

    The inertia (3, 3) [kg m²] is about the centre, in the link's axes.
    """

    mass: float
    centre: Array
    inertia: Array


INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def bodies(description: Description) -> dict[str, Body]:
    """Every link with a mass or an inertia, from the repaired text."""
    robot = ET.fromstring(description.repaired)
    inertials = {link.get("name", ""): link.find("inertial") for link in robot.findall("link")}
    found = {}
    for name, inertial in inertials.items():
        if inertial is None:
            continue
        mass, inertia, g = inertial.find("mass"), inertial.find("inertia"), read_origin(inertial)
        xx, xy, xz, yy, yz, zz = (0.0 if inertia is None else float(inertia.get(each, "0")) for each in INERTIA)
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
        if first is not None and (problem := inertial_problem(first)):
            link.remove(first)
            what = f"its <inertial> {problem}; the link counts as massless"
            remedy = "write mass in kg and the six inertias in kg m² as plain numbers"
            reading.note("inertial-unusable", link, what, remedy)


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
