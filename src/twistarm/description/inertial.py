"""Masses and inertias: those that are no numbers are noted and dropped before Pinocchio drops them in silence."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from .document import Reading
from .geometry import read_origin
from .numerals import floats

INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def drop_unusable_inertials(robot: ET.Element, reading: Reading) -> None:
    """Remove every `<inertial>` that cannot be read; kinematics does not need it, gravity torques do."""
    for link in robot.findall("link"):
        first = link.find("inertial")
        link[:] = [child for child in link if child.tag != "inertial" or child is first]
        for inertial in link.findall("inertial"):
            problem = inertial_problem(inertial)
            if problem:
                link.remove(inertial)
                reading.note(
                    "inertial-unusable",
                    link,
                    f"its <inertial> {problem}; the link counts as massless",
                    "write mass in kg and the six inertias in kg m² as plain numbers",
                    repaired=True,
                )
            else:
                _write_plainly(inertial)


def inertial_problem(inertial: ET.Element) -> str:
    """Why an `<inertial>` cannot be used; empty if it can."""
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


def _write_plainly(inertial: ET.Element) -> None:
    """For Pinocchio, which takes " 1 " for no mass, and all of an inertia for zero if one of the six is missing."""
    for element in (*inertial.findall("mass"), *inertial.findall("inertia")):
        for name in ("value",) if element.tag == "mass" else INERTIA:
            element.set(name, element.get(name, "0").strip())
