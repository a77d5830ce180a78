"""Planar joints as three joints: two slides in the plane, then a turn about its normal.

URDF gives only the normal of a planar joint. The slides go along the first two columns of `joints.plane_axes(normal)`.
The split comes before links and joints are read, so all later steps see three joints of one degree of freedom.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ET

from ..support.checks import Array
from ..support.errors import DescriptionError
from ..theory.joints import plane_axes
from .bounds import read_axis
from .document import Reading
from .structure import end_of

SUFFIXES = ("_x", "_y", "_rz")  # Endings of the coordinates' names, in the order of `joints.planar`.


def coordinate_names(joint: str) -> tuple[str, str, str]:
    """The names of the three joints that a planar joint becomes."""
    x, y, rz = (joint + suffix for suffix in SUFFIXES)
    return x, y, rz


def split_planar_joints(robot: ET.Element, reading: Reading) -> dict[str, str]:
    """Replace every planar joint by three, and return the joint that each is part of, {"p_x": "p", …}.

    Raises DescriptionError if a coordinate's name is used, or if a planar joint mimics or is mimicked. A joint with an
    unusable axis stays, and is refused later with the other joints.
    """
    planar = [joint for joint in robot.findall("joint") if joint.get("type") == "planar"]
    _refuse_mimics(robot, {joint.get("name", "") for joint in planar}, reading)
    joints, links = ({element.get("name", "") for element in robot.findall(tag)} for tag in ("joint", "link"))
    whole: dict[str, str] = {}
    made: dict[ET.Element, list[ET.Element]] = {}
    for joint in planar:
        try:
            normal, _ = read_axis(joint, "planar", reading)
        except DescriptionError:
            continue
        names = coordinate_names(joint.get("name", ""))
        if given := [name for limit in joint.findall("limit") for name in limit.attrib]:
            what = f"its <limit> gives {', '.join(given)}, one number for slides and turn alike; it counts as unbounded"
            reading.note("limits-adjusted", joint, what, f"give limits of {', '.join(names)} in arm.toml")
        if clash := joints.intersection(names):
            what = f"its coordinates are named {', '.join(names)}, and there is a joint {min(clash)!r} already"
            raise reading.error(joint, "name-unusable", what, "rename one")
        joints.discard(joint.get("name", ""))
        joints.update(names)
        between = [free_name(f"{name}_link", links) for name in names[:2]]
        made[joint] = _parts(joint, names, between, plane_axes(normal))
        new_links = [ET.Element("link", name=name) for name in between]
        whole |= dict.fromkeys(names, joint.get("name", ""))
        if joint in reading.lines:  # findings about the parts show the line of the joint
            reading.lines |= dict.fromkeys([*made[joint], *new_links], reading.lines[joint])
        robot.extend(new_links)
    robot[:] = [part for element in robot for part in made.get(element, [element])]
    return whole


def _parts(joint: ET.Element, names: tuple[str, str, str], between: list[str], axes: Array) -> list[ET.Element]:
    """The three joints, through the two links `between`."""
    parts = []
    parents, children = [end_of(joint, "parent"), *between], [*between, end_of(joint, "child")]
    given = zip(names, ("prismatic", "prismatic", "continuous"), parents, children, axes.T, strict=True)
    for i, (name, kind, parent, child, axis) in enumerate(given):
        part = ET.Element("joint", name=name, type=kind)
        ET.SubElement(part, "parent", link=parent)
        ET.SubElement(part, "child", link=child)
        part.extend(copy.deepcopy(joint.findall("origin")) if i == 0 else [])
        ET.SubElement(part, "axis", xyz=" ".join(repr(float(number)) for number in axis))
        # The plane has no edge. Infinite limits keep the reader from noting missing ones.
        ET.SubElement(part, "limit", lower="-inf", upper="inf", velocity="inf", effort="inf")
        parts.append(part)
    return parts


def free_name(name: str, used: set[str]) -> str:
    """The name, with an underscore, a number or more underscores added if it is used already. It goes into `used`."""
    for more in ("_", str(len(used))):
        name += more if name in used else ""
    while name in used:
        name += "_"
    used.add(name)
    return name


def _refuse_mimics(robot: ET.Element, planar: set[str], reading: Reading) -> None:
    mimics = [(joint, mimic) for joint in robot.findall("joint") if (mimic := joint.find("mimic")) is not None]
    for joint, mimic in mimics:
        master = mimic.get("joint", "")
        if joint.get("type") == "planar":
            what = f"it is planar and mimics {master!r}: its motion is not one number"
            raise reading.error(joint, "mimic-unusable", what, "remove its <mimic>")
        if master in planar and joint.get("type") not in ("fixed", "floating"):
            what = f"it mimics {master!r}, which is planar: its motion is not one number"
            remedy = f"let it mimic another joint, or one of {', '.join(coordinate_names(master))}"
            raise reading.error(joint, "mimic-unusable", what, remedy)
