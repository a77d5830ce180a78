"""URDF to the tree of links and joints, with repairs noted as findings and errors in one line."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import get_args

import numpy as np

from ..support.checks import frozen, require_mapping
from ..support.errors import DescriptionError, closest, listed
from ..support.files import as_paths
from ..support.messages import Text, package_folder
from .bounds import NO_LIMIT, limit_numbers, note_commanded, note_softened, rate, read_axis, read_bounds, softened
from .catalog import models_share
from .document import Reading, existing_file, floats, parse_xml, read_text
from .expansion.expand import expand_xacro, is_xacro
from .findings import Place, refusal
from .geometry import INERTIA, Geometries, drop_unusable_inertials, read_origin
from .packages import checked_names, package_index
from .planar import split_planar_joints
from .structure import check_structure, end_of, note_unread_words, root_links
from .tree import Description, Joint, JointType, Link, Mimic

WHOLE_TURN = 6.3  # A whole turn [rad], generously rounded.
Rates = dict[str, dict[str, float]]  # The numbers of each joint's `<limit>` as written, by joint name.

_MACRO = re.compile(r"<xacro:macro\s[^>]*?\bname\s*=\s*[\"']([^\"']+)")

_MJCF = re.compile(r"<mujoco[\s/>]")

_JOINT_TYPES: tuple[JointType, ...] = get_args(JointType)


@dataclass(frozen=True)
class ReadOptions:
    """What a description is read with, as in `load_arm`; checked.

    `mesh_dirs` are folders with packages that give only meshes.
    """

    package_dirs: Iterable[str | os.PathLike[str]] = ()
    xacro_args: Mapping[str, object] = field(default_factory=dict)
    ignore_packages: Iterable[str] = ()
    env_vars: Iterable[str] = ()
    mesh_dirs: Iterable[str | os.PathLike[str]] = ()

    def __post_init__(self) -> None:
        given = require_mapping({} if self.xacro_args is None else self.xacro_args, "xacro_args", "{'dof': 7}")
        object.__setattr__(self, "xacro_args", given)
        for name, check in (
            ("package_dirs", as_paths),
            ("ignore_packages", checked_names),
            ("env_vars", checked_names),
        ):
            object.__setattr__(self, name, check(getattr(self, name), name))

    def over(self, own: ReadOptions) -> ReadOptions:
        """These, then an arm.toml's `own`, which name no environment variables."""
        return replace(
            own,
            package_dirs=(*self.package_dirs, *own.package_dirs),
            xacro_args={**own.xacro_args, **self.xacro_args},
            ignore_packages=(*self.ignore_packages, *own.ignore_packages),
            env_vars=self.env_vars,
        )


PLAIN = ReadOptions()


def read_description(path: str | os.PathLike[str], options: ReadOptions = PLAIN) -> Description:
    """The description in a URDF, xacro or MJCF file.

    Raises DescriptionError (file, element, remedy) for text that cannot be a robot: not XML, two roots, a cycle, an
    undefined link, a duplicate name, a zero axis on a moving joint, a malformed number.
    """
    file = existing_file(path, "a URDF, xacro or MJCF file, an arm.toml or a catalogue name").resolve()
    packages = package_index(file, options.package_dirs, options.mesh_dirs)
    if is_xacro(file):
        given = options.xacro_args, options.ignore_packages, options.env_vars
        text, noted, _ = expand_xacro(file, packages, *given)
        macros = list(dict.fromkeys(_MACRO.findall(read_text(file))))
        if macros and "<link" not in text:
            what = f"it has no links: it defines macros ({listed(macros)}) and calls none that makes one"
            remedy = f"load the file that calls them, or call one: <xacro:{macros[0]} …/>"
            raise refusal("no-robot", Place(str(file)), what, remedy)
        reading = Reading(file, packages, show_lines=False)
    else:
        require_no_arguments(file, options, "plain URDF")
        noted, text, reading = (), read_text(file), Reading(file, packages)
    reading.findings += noted
    # A URDF may hold settings for MuJoCo in such an element too.
    if _MJCF.search(text) and (root := parse_xml(text, reading)).tag == "mujoco":
        from .mjcf.translation import translated  # most programs read none

        urdf, semantics, gravity = translated(root, reading)
        description = build_description(urdf, replace(reading, show_lines=False, lines={}))
        return replace(description, semantics=semantics, gravity=gravity)
    return build_description(text, reading)


def require_no_arguments(file: Path, options: ReadOptions, kind: str) -> None:
    """Raise DescriptionError for xacro arguments of a file that takes none."""
    if options.xacro_args:
        what = f"it is {kind} and takes no xacro arguments ({', '.join(options.xacro_args)})"
        raise refusal("xacro-arguments", Place(str(file)), what, "leave them out")


def build_description(text: str, reading: Reading) -> Description:
    """The tree of an expanded URDF text."""
    robot = parse_xml(text, reading)
    if robot.tag != "robot":
        what = f"its root element is <{robot.tag}>, not <robot> or <mujoco>"
        raise refusal("no-robot", reading.whole, what, "is it a robot's description?")
    if not robot.get("name"):  # which Pinocchio refuses
        robot.set("name", reading.path.stem)
        what = f"the <robot> has no name; called {reading.path.stem!r} after the file"
        reading.note("word-unread", None, what, 'write <robot name="…">')
    check_structure(robot, reading)
    note_unread_words(robot, reading)
    parts = split_planar_joints(robot, reading)
    geometries = Geometries(robot, reading)
    links = [
        Link(link.get("name", ""), geometries.of(link, "visual"), geometries.of(link, "collision"), reading.line(link))
        for link in robot.findall("link")
    ]
    geometries.note_odd()
    _note_copies(reading)
    rates: Rates = {}
    read = [_try_joint(element, reading, rates) for element in robot.findall("joint")]
    reading.require_usable()  # one error reports all unusable joints
    joints = {joint.name: joint for joint in read if joint is not None}
    joints |= {name: replace(joints[name], part_of=whole) for name, whole in parts.items()}
    note_softened(joints.values(), reading)
    note_commanded(robot, joints, reading)
    _note_missing_rates(joints.values(), rates, reading)
    drop_unusable_inertials(robot, reading)
    return Description(
        name=robot.get("name", ""),
        path=reading.path,
        root=root_links(robot)[0],
        links={link.name: link for link in links},
        joints=joints,
        text=text,
        repaired=_for_pinocchio(robot, joints),
        findings=tuple(reading.findings),
    )


def _note_copies(reading: Reading) -> None:
    """Note packages found only by a folder's name."""
    for package, folder in reading.packages.copies.items():
        if folder.parent == models_share():  # the wheel's own, which pip has put there
            continue
        what = f"no package.xml names package {package!r}; the folder {folder} is used because of its name"
        remedy = Text("put a package.xml of that name into it, or pass {folder}", folder=package_folder("another"))
        reading.note("package-without-manifest", None, what, remedy)


def _try_joint(element: ET.Element, reading: Reading, rates: Rates) -> Joint | None:
    try:
        return _read_joint(element, reading, rates)
    except DescriptionError as error:
        reading.findings += error.findings
        return None


def _read_joint(element: ET.Element, reading: Reading, rates: Rates) -> Joint:
    kind = element.get("type", "")
    if kind not in _JOINT_TYPES:
        remedy = f"URDF has {', '.join(_JOINT_TYPES)}{closest(kind, _JOINT_TYPES)}"
        raise reading.error(element, "joint-type-unknown", f"joint type {kind!r} is unknown", remedy)
    remedy = "give xyz and rpy as three numbers each, or quat_xyzw instead of rpy as four"
    with reading.numbers_of(element, "its <origin> is malformed: ", remedy):
        origin = read_origin(element)
    _note_degrees(element, reading)
    axis, axis_length = read_axis(element, kind, reading)
    numbers = limit_numbers(element, reading)
    written = read_bounds(element, kind, numbers, reading)
    lower, upper = softened(element, kind, written, reading)
    rates[element.get("name", "")] = numbers
    return Joint(
        name=element.get("name", ""),
        type=kind,
        parent=end_of(element, "parent"),
        child=end_of(element, "child"),
        origin=frozen(origin),
        axis=frozen(axis),
        lower=lower,
        upper=upper,
        hard=written,
        velocity=rate(numbers.get("velocity")),
        effort=rate(numbers.get("effort")),
        acceleration=min(rate(numbers.get("acceleration")), rate(numbers.get("deceleration"))),
        jerk=rate(numbers.get("jerk")),
        mimic=_read_mimic(element, reading),
        axis_length=axis_length,
        line=reading.line(element),
    )


def _note_degrees(element: ET.Element, reading: Reading) -> None:
    """Note an origin with an angle beyond a whole turn, which is probably in degrees."""
    origin = element.find("origin")
    angles = [] if origin is None else floats(origin.get("rpy", "0 0 0"), 3)
    if any(abs(angle) > WHOLE_TURN for angle in angles):
        radians = " ".join(f"{np.radians(angle):.6g}" for angle in angles)
        typed = " ".join(f"{angle:g}" for angle in angles)
        what = f'its rpy="{typed}" rad goes beyond a whole turn; it looks like degrees'
        reading.note("unit-doubtful", element, what, f'if so, write rpy="{radians}"')


def _read_mimic(element: ET.Element, reading: Reading) -> Mimic | None:
    mimic = element.find("mimic")
    if mimic is None or element.get("type") == "fixed":
        return None
    with reading.numbers_of(element, "its <mimic> is malformed: ", "give multiplier and offset as one number each"):
        (multiplier,), (offset,) = floats(mimic.get("multiplier", "1"), 1), floats(mimic.get("offset", "0"), 1)
    return Mimic(mimic.get("joint", ""), multiplier, offset)


def _note_missing_rates(joints: Iterable[Joint], given: Rates, reading: Reading) -> None:
    """Add a finding for each kind of rate, with the joints that do not give it and the value there."""
    moving = [joint.name for joint in joints if joint.scalar and joint.mimic is None]
    for kind in ("velocity", "effort"):
        absent = {name: given[name].get(kind, 0.0) for name in moving if given[name].get(kind, 0.0) <= 0}
        if absent:
            worst = min(absent.values())
            what = f"{kind} limit {f'{worst:g}' if worst else 'absent or 0'} on {', '.join(absent)}: counts as missing"
            remedy = f"give {kind} in arm.toml, or in a URDF" + (", before planning" if kind == "velocity" else "")
            reading.note("rate-not-given", None, what, remedy)


def _for_pinocchio(robot: ET.Element, joints: Mapping[str, Joint]) -> str:
    """The kinematics and the inertias alone, as Pinocchio reads them with the same meaning.

    Origins and inertias are copied as they are written, with plain space between numbers and 0 for missing inertias.
    A continuous joint becomes revolute with very wide limits, so that q is one number per joint. Floating joints
    outside the chain become fixed. Limits are complete and finite, axes are unit vectors.
    """
    made = ET.Element("robot", {name: robot.get(name, "") for name in ("name", "version") if name in robot.attrib})

    def copy_of(part: ET.Element | None, tag: str, into: ET.Element, **absent: str) -> None:
        element = None if part is None else part.find(tag)
        if element is not None:
            given = {name: " ".join(element.attrib[name].split()) for name in _COPIED[tag] if name in element.attrib}
            ET.SubElement(into, tag, absent | given)

    for link in robot.findall("link"):
        body, inertial = ET.SubElement(made, "link", name=link.get("name", "")), link.find("inertial")
        if inertial is not None:
            part = ET.SubElement(body, "inertial")
            copy_of(inertial, "origin", part)
            copy_of(inertial, "mass", part)
            copy_of(inertial, "inertia", part, **dict.fromkeys(INERTIA, "0"))
    for element in robot.findall("joint"):
        joint = joints[element.get("name", "")]
        kind = {"continuous": "revolute", "floating": "fixed"}.get(joint.type, joint.type)
        part = ET.SubElement(made, "joint", name=joint.name, type=kind)
        copy_of(element, "origin", part)
        ET.SubElement(part, "parent", link=joint.parent)
        ET.SubElement(part, "child", link=joint.child)
        if kind != "fixed":
            ET.SubElement(part, "axis", xyz=" ".join(repr(float(x)) for x in joint.axis))
            lower, upper = (repr(float(bound)) for bound in np.clip(joint.hard, -NO_LIMIT, NO_LIMIT))
            ET.SubElement(part, "limit", lower=lower, upper=upper, velocity=repr(NO_LIMIT), effort=repr(NO_LIMIT))
    return ET.tostring(made, encoding="unicode")


# Elements with attributes for Pinocchio.
_COPIED = {"origin": ("xyz", "rpy", "quat_xyzw"), "mass": ("value",), "inertia": INERTIA}
