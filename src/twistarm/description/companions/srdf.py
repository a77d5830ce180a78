"""SRDF: groups, end effectors, named states, pairs of links that need no collision check; and the arm's group.

Files beside a description are looked for in the places of MoveIt and ROS packages.
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ...support.checks import number_in
from ...support.errors import DescriptionError, InputError, listed
from ...support.files import is_file
from ...support.messages import Argument, Text
from ..document import Reading, existing_file, parse_xml, read_text
from ..expansion.expand import arguments_in, expand_xacro, is_xacro
from ..findings import Finding, Place, finding, refusal
from ..packages import package_index
from ..tree import Description, EndEffector, Group, GroupState, Joint, Pair, Semantics, sorted_pair
from ..urdf import PLAIN, ReadOptions

MAX_BYTES = 1_000_000  # A whole humanoid's SRDF has some 200 kB.
FOLDERS = ("config", "srdf")  # Folders of packages with such files, in the description's folder or one above.
# The MoveIt package of the same workspace: one or two folders above the description's.
MOVEIT = "*_moveit_config"


def files_beside(file: Path, pattern: str) -> tuple[Path, ...]:
    """Files that match `pattern` (`*.srdf`) in the description's folder and its package's folders for them.

    Links are left out, because their files lie elsewhere.
    """
    here = file.resolve().parent
    packages = (
        package for workspace in (here.parent, here.parent.parent) for package in sorted(workspace.glob(MOVEIT))
    )
    folders = [here, *(folder / name for folder in (here, here.parent, *packages) for name in FOLDERS)]
    found = (path for folder in folders for path in sorted(folder.glob(pattern)))
    return tuple(path for path in dict.fromkeys(found) if is_file(path) and path.resolve() == path)


def srdf_beside(description: Description) -> tuple[Semantics | None, tuple[Finding, ...]]:
    """The one SRDF beside the description for a robot of its name, and findings.

    None of several is used. SRDFs in xacro are programs, so they are not read unasked.
    """
    matching: list[Semantics] = []
    noted: list[Finding] = []
    for path in files_beside(description.path, "*.srdf") if description.path else ():
        try:
            semantics = read_srdf(path)
        except DescriptionError as error:
            remedy = Text("correct it, or name another as {srdf}", srdf=Argument("srdf"))
            noted.append(finding("companion-doubtful", Place(path.name), error.message, remedy))
            continue
        if semantics.name == description.name:
            matching.append(semantics)
    if len(matching) > 1:
        files = listed(path_from(description, semantics.path) for semantics in matching)
        what = f"several SRDFs are for a robot {description.name!r}: {files}; none is used"
        remedy = Text("name one as {srdf}", srdf=Argument("srdf"))
        noted.append(finding("companion-not-used", description.place(), what, remedy))
    return (matching[0] if len(matching) == 1 else None), tuple(noted)


def path_from(description: Description, file: Path) -> str:
    """The way from the description's folder to a file: `../config/arm.srdf`."""
    return os.path.relpath(file.resolve(), description.path.parent) if description.path else str(file)


def read_srdf(path: str | os.PathLike[str], options: ReadOptions = PLAIN) -> Semantics:
    """Read an SRDF, plain or xacro.

    A xacro file gets those `xacro_args` that it declares. A state with a value that is no number is left out, with a
    finding.

    Raises DescriptionError (file, line, element, remedy) for a file that is not an SRDF.
    """
    file = existing_file(path, "the path of an SRDF")
    index, text = package_index(file, options.package_dirs), read_text(file, MAX_BYTES)
    if not is_xacro(file):
        return _semantics(text, Reading(file, index))
    known = arguments_in(parse_xml(text, Reading(file, index)))
    given = {name: value for name, value in options.xacro_args.items() if name in known}
    text = expand_xacro(file, index, given, options.ignore_packages, options.env_vars).text
    return _semantics(text, Reading(file, index, show_lines=False))


def note_names(semantics: Semantics, description: Description) -> tuple[Finding, ...]:
    """Findings for links and joints that the description does not have, and for a robot of another name."""
    noted = list(semantics.findings)
    place = Place(semantics.path.name)
    if semantics.name != description.name:
        what = f"it is for a robot {semantics.name!r}, the description is of {description.name!r}; it is used"
        noted.append(finding("companion-doubtful", place, what, "if they belong together, give both the same name"))
    groups = semantics.groups.values()
    joints = [*semantics.passive_joints, *(name for group in groups for name in group.joints)]
    joints += [name for state in semantics.states for name in state.values]
    links = [name for group in groups for name in (*group.links, *(end for chain in group.chains for end in chain))]
    links += [*(effector.parent_link for effector in semantics.end_effectors), *semantics.silent_links]
    links += [link for _, link in semantics.virtual_joints.values() if link]
    links += [link for both in sorted({*semantics.disabled, *semantics.checked_pairs}) for link in both]
    known = {part for joint in description.joints.values() for part in (joint.name, joint.part_of)}
    missing = [name for name in joints if name not in known and name not in semantics.virtual_joints]
    missing += [name for name in links if name not in description.links]
    if missing:
        names = listed(dict.fromkeys(missing))
        what = f"{description.name} has no joint or link {names}; their entries are not used"
        noted.append(finding("companion-doubtful", place, what, "correct the names; is it of an older description?"))
    return tuple(noted)


def _semantics(text: str, reading: Reading) -> Semantics:
    robot = parse_xml(text, reading)
    if robot.tag != "robot" or robot.find("link") is not None:
        what = "it holds links, as a URDF does" if robot.tag == "robot" else f"its root element is <{robot.tag}>"
        raise refusal("companion-unusable", reading.whole, what, "is it an SRDF file?")

    def names(parent: ET.Element, tag: str, attribute: str = "name") -> tuple[str, ...]:
        return tuple(_attribute(element, attribute, reading) for element in parent.findall(tag))

    def pairs(parent: ET.Element, tag: str, first: str, second: str) -> tuple[Pair, ...]:
        return tuple(zip(names(parent, tag, first), names(parent, tag, second), strict=True))

    groups: dict[str, Group] = {}
    for element in robot.findall("group"):
        name = _attribute(element, "name", reading)
        if name in groups:
            raise reading.error(element, "companion-unusable", "another group has this name", "rename one")
        chains = pairs(element, "chain", "base_link", "tip_link")
        groups[name] = Group(name, chains, *(names(element, tag) for tag in ("joint", "link", "group")))
    effectors = []
    for element in robot.findall("end_effector"):
        own = {key: _attribute(element, key, reading) for key in ("name", "parent_link", "group")}
        effectors.append(EndEffector(**own, parent_group=element.get("parent_group", "")))
    states = [_state(element, reading) for element in robot.findall("group_state")]
    disabled = pairs(robot, "disable_collisions", "link1", "link2")
    reasons = [element.get("reason", "") for element in robot.findall("disable_collisions")]
    fixed = [(one.get("parent_frame", ""), one.get("child_link", "")) for one in robot.findall("virtual_joint")]
    return Semantics(
        path=reading.path,
        name=_attribute(robot, "name", reading),
        groups=groups,
        end_effectors=tuple(effectors),
        states=tuple(state for state in states if state is not None),
        disabled={sorted_pair(*both): why for both, why in zip(disabled, reasons, strict=True)},
        silent_links=names(robot, "disable_default_collisions", "link"),
        checked_pairs=frozenset(sorted_pair(*both) for both in pairs(robot, "enable_collisions", "link1", "link2")),
        passive_joints=names(robot, "passive_joint"),
        virtual_joints=dict(zip(names(robot, "virtual_joint"), fixed, strict=True)),
        findings=tuple(reading.findings),
    )


def _state(element: ET.Element, reading: Reading) -> GroupState | None:
    """A named state; None, with a finding, where a value is no number. Joints with several numbers are left out."""
    name, values = _attribute(element, "name", reading), dict[str, float]()
    for joint in element.findall("joint"):
        moved, written = (_attribute(joint, attribute, reading) for attribute in ("name", "value"))
        try:
            numbers = [number_in(word, f"value of joint {moved!r}", unit="rad or m") for word in written.split()]
        except InputError as error:
            reading.note("companion-doubtful", element, f"{error}; it is left out", "correct it if the arm needs it")
            return None
        if len(numbers) == 1:
            values[moved] = numbers[0]
    return GroupState(name, element.get("group", ""), values)


def _attribute(element: ET.Element, name: str, reading: Reading) -> str:
    value = element.get(name, "").strip()
    if not value:
        raise reading.error(element, "companion-unusable", f"it has no {name}=", f"add {name}=")
    return value


@dataclass(frozen=True)
class ArmGroup:
    """A group with moving `joints` on one path to `tip`; `base` is given if the group is a chain."""

    name: str
    base: str | None
    tip: str
    joints: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.name!r} ({f'{self.base} to ' if self.base else ''}{self.tip})"


def arm_groups(semantics: Semantics, description: Description) -> tuple[ArmGroup, ...]:
    """The groups that could be the arm. A single one is the arm.

    Groups win over those made of other groups, then groups with an end effector over others. Of groups that share
    joints the one with most joints wins, of equal ones a chain over a list.
    """
    members = _members(semantics, description)
    paths = [_path(group, members[name], description) for name, group in semantics.groups.items()]
    groups = [group for group in paths if group is not None]
    groups = [group for group in groups if not semantics.groups[group.name].subgroups] or groups
    hands = [(effector, members.get(effector.group, ())) for effector in semantics.end_effectors]
    groups = [group for group in groups if any(_hangs_on(*hand, group, description) for hand in hands)] or groups
    different = {(group.base, group.tip): group for group in groups}.values()
    return tuple(group for group in different if not any(_part_of(group, other) for other in different))


def _part_of(group: ArmGroup, other: ArmGroup) -> bool:
    """Whether they share joints, and the other has more, or as many and is a chain."""
    less = (len(group.joints), group.base is not None) < (len(other.joints), other.base is not None)
    return less and not set(group.joints).isdisjoint(other.joints)


def _members(semantics: Semantics, description: Description) -> dict[str, list[Joint]]:
    """The joints of each group and its subgroups, parents before children. Unknown names are left out."""
    order, own = description.outward_joints(), dict[str, set[str]]()
    for name, group in semantics.groups.items():
        links, joints = set(group.links), set(group.joints)
        for base, tip in group.chains:
            path = description.inward(tip)
            links.update(path[: path.index(base)] if base in path else ())
        own[name] = {j.name for j in order if j.child in links or j.name in joints or j.part_of in joints}
    members = {}
    for name in semantics.groups:
        found = [name]
        for subgroup in found:  # which grows by the subgroups
            found += [sub for sub in semantics.groups[subgroup].subgroups if sub in own and sub not in found]
        names = set().union(*(own[subgroup] for subgroup in found))
        members[name] = [joint for joint in order if joint.name in names]
    return members


def _path(group: Group, members: Sequence[Joint], description: Description) -> ArmGroup | None:
    """The group as a path of joints. None if its joints branch, or if none moves."""
    moving = tuple(joint.name for joint in members if joint.moving)
    if not moving or not {joint.child for joint in members}.issubset(description.inward(members[-1].child)):
        return None
    alone = len(group.chains) == 1 and not (group.joints or group.links or group.subgroups)
    return ArmGroup(group.name, group.chains[0][0] if alone else None, members[-1].child, moving)


def _hangs_on(effector: EndEffector, hand: Sequence[Joint], group: ArmGroup, description: Description) -> bool:
    """Whether the end effector's parent link is one that the group moves, and its own joints are not in the group."""
    if effector.parent_group:
        return effector.parent_group == group.name
    if not {joint.name for joint in hand}.isdisjoint(group.joints):
        return False
    first = description.joints[group.joints[0]].child
    return first in description.inward(effector.parent_link) and effector.parent_link in description.inward(group.tip)
