"""SRDF: groups, end effectors, named states, and pairs of links that need no collision check."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np

from ...support.errors import listed
from ..document import Reading, existing_file, parse_xml, read_text
from ..expansion.arguments import declared_arguments
from ..expansion.expand import expand_xacro, is_xacro
from ..findings import Finding, Place, finding, refusal
from ..packages import package_index
from ..tree import Description

MAX_BYTES = 1_000_000
"""A whole humanoid's SRDF has some 200 kB."""

MAX_GROUPS = 200
"""Most elements of a kind. A humanoid has some 30 groups. Each group is compared with all others."""

Pair = tuple[str, str]


@dataclass(frozen=True)
class Group:
    """A named set of joints: chains as (base_link, tip_link), joints, links (each with its parent joint), groups."""

    name: str
    chains: tuple[Pair, ...] = ()
    joints: tuple[str, ...] = ()
    links: tuple[str, ...] = ()
    subgroups: tuple[str, ...] = ()


@dataclass(frozen=True)
class EndEffector:
    """An end effector on `parent_link` with the joints of `group`. `parent_group` is the arm's group, if given."""

    name: str
    parent_link: str
    group: str
    parent_group: str = ""


@dataclass(frozen=True)
class GroupState:
    """A named configuration: {joint: value [rad or m]}, joints with several numbers left out."""

    name: str
    group: str
    values: Mapping[str, float]


@dataclass(frozen=True)
class Semantics:
    """An SRDF as read. Pairs of links are sorted. Virtual joints are kept by name only.

    `silent_links` by default collide with nothing except in the `checked_pairs`.
    """

    path: Path
    name: str
    groups: Mapping[str, Group] = field(default_factory=dict)
    end_effectors: tuple[EndEffector, ...] = ()
    states: tuple[GroupState, ...] = ()
    disabled: frozenset[Pair] = frozenset()
    silent_links: tuple[str, ...] = ()
    checked_pairs: frozenset[Pair] = frozenset()
    passive_joints: tuple[str, ...] = ()
    virtual_joints: tuple[str, ...] = ()

    def disabled_collisions(self, links: Iterable[str]) -> frozenset[Pair]:
        """The pairs of `links`, each sorted, that are not to be checked for collisions."""
        known = set(links)
        default = {_pair(a, b) for a in self.silent_links for b in known if a in known and a != b}
        named = (default - self.checked_pairs) | self.disabled
        return frozenset(pair for pair in named if known.issuperset(pair))


def read_srdf(
    path: str | os.PathLike[str],
    package_dirs: Iterable[str | os.PathLike[str]] = (),
    xacro_args: Mapping[str, object] = MappingProxyType({}),
    ignore_packages: Iterable[str] = (),
    env_vars: Iterable[str] = (),
) -> Semantics:
    """Read an SRDF, plain or xacro.

    A xacro file gets those `xacro_args` that it declares. `ignore_packages` and `env_vars` are as in
    `read_description`.

    Raises DescriptionError (file, line, element, remedy) for a file that is not an SRDF.
    """
    file = existing_file(path, "the path of an SRDF")
    index, text = package_index(file, package_dirs), read_text(file, MAX_BYTES)
    if not is_xacro(file):
        return _semantics(text, Reading(file, index))
    known = declared_arguments(file, parse_xml(text, Reading(file, index)))
    given = {name: value for name, value in xacro_args.items() if name in known}
    text = expand_xacro(file, index, given, ignore_packages, env_vars).text
    return _semantics(text, Reading(file, index, show_lines=False))


def note_names(semantics: Semantics, description: Description) -> tuple[Finding, ...]:
    """Findings for links and joints that the description does not have, and for a robot of another name."""
    noted = []
    place = Place(semantics.path.name)
    if semantics.name != description.name:
        what = f"it is for a robot {semantics.name!r}, the description is of {description.name!r}; it is used"
        noted.append(finding("srdf-other-robot", place, what, "give both one name, if they belong together"))
    joints = {part for joint in description.joints.values() for part in (joint.name, joint.part_of)}
    missing = [name for name in _joints(semantics) if name not in joints]
    missing += [name for name in _links(semantics) if name not in description.links]
    if missing:
        names = listed(dict.fromkeys(missing))
        what = f"{description.name} has no joint or link {names}; their entries are not used"
        noted.append(finding("srdf-unknown-name", place, what, "correct the names; is it of an older description?"))
    return tuple(noted)


def _semantics(text: str, reading: Reading) -> Semantics:
    robot = parse_xml(text, reading)
    if robot.tag != "robot" or robot.find("link") is not None:
        what = "it holds links, as a URDF does" if robot.tag == "robot" else f"its root element is <{robot.tag}>"
        raise refusal("srdf-unusable", reading.whole, what, "is it an SRDF file?")
    for tag in ("group", "group_state", "end_effector", "disable_default_collisions"):
        if len(robot.findall(tag)) > MAX_GROUPS:
            what = f"it has {len(robot.findall(tag))} elements <{tag}>; allowed are {MAX_GROUPS}"
            raise refusal("srdf-unusable", reading.whole, what, "is it an SRDF file?")
    ends = ("link1", "link2")
    return Semantics(
        path=reading.path,
        name=_named(robot, "name", reading),
        groups=_groups(robot, reading),
        end_effectors=tuple(
            EndEffector(
                name=_named(element, "name", reading),
                parent_link=_named(element, "parent_link", reading),
                group=_named(element, "group", reading),
                parent_group=element.get("parent_group", ""),
            )
            for element in robot.findall("end_effector")
        ),
        states=tuple(_state(state, reading) for state in robot.findall("group_state")),
        disabled=frozenset(_pair(*_names(e, ends, reading)) for e in robot.findall("disable_collisions")),
        silent_links=tuple(_named(e, "link", reading) for e in robot.findall("disable_default_collisions")),
        checked_pairs=frozenset(_pair(*_names(e, ends, reading)) for e in robot.findall("enable_collisions")),
        passive_joints=_names_of(robot, "passive_joint", reading),
        virtual_joints=_names_of(robot, "virtual_joint", reading),
    )


def _groups(robot: ET.Element, reading: Reading) -> dict[str, Group]:
    groups: dict[str, Group] = {}
    for element in robot.findall("group"):
        name = _named(element, "name", reading)
        if name in groups:
            raise reading.error(element, "srdf-unusable", "a group of this name stands above", "rename one of them")
        chains = [_names(chain, ("base_link", "tip_link"), reading) for chain in element.findall("chain")]
        groups[name] = Group(
            name=name,
            chains=tuple((base, tip) for base, tip in chains),
            joints=_names_of(element, "joint", reading),
            links=_names_of(element, "link", reading),
            subgroups=_names_of(element, "group", reading),
        )
    return groups


def _state(element: ET.Element, reading: Reading) -> GroupState:
    values: dict[str, float] = {}
    for joint in element.findall("joint"):
        name, text = _names(joint, ("name", "value"), reading)
        try:
            numbers = np.array([float(word) for word in text.split()])
        except ValueError:
            numbers = np.array([np.nan])
        if not np.isfinite(numbers).all() or not numbers.size:
            what = f"in group_state {element.get('name')!r} its value is {text[:60]!r}"
            raise reading.error(joint, "srdf-unusable", what, "give a number [rad or m]")
        if numbers.size == 1:
            values[name] = float(numbers[0])
    return GroupState(_named(element, "name", reading), element.get("group", ""), values)


def _names_of(parent: ET.Element, tag: str, reading: Reading) -> tuple[str, ...]:
    return tuple(_named(element, "name", reading) for element in parent.findall(tag))


def _names(element: ET.Element, attributes: Iterable[str], reading: Reading) -> tuple[str, ...]:
    return tuple(_named(element, attribute, reading) for attribute in attributes)


def _named(element: ET.Element, attribute: str, reading: Reading) -> str:
    value = element.get(attribute, "").strip()
    if not value:
        raise reading.error(element, "srdf-unusable", f"it has no {attribute}=", f"add {attribute}=")
    return value


def _pair(a: str, b: str) -> Pair:
    return (a, b) if a <= b else (b, a)


def _joints(semantics: Semantics) -> Iterator[str]:
    virtual = set(semantics.virtual_joints)
    for names in (semantics.passive_joints, *(group.joints for group in semantics.groups.values())):
        yield from (name for name in names if name not in virtual)
    for state in semantics.states:
        yield from (name for name in state.values if name not in virtual)


def _links(semantics: Semantics) -> Iterator[str]:
    for group in semantics.groups.values():
        yield from group.links
        yield from (end for chain in group.chains for end in chain)
    yield from (effector.parent_link for effector in semantics.end_effectors)
    yield from semantics.silent_links
    for pair in sorted(semantics.disabled | semantics.checked_pairs):
        yield from pair
