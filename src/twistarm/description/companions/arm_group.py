"""The arm's group of an SRDF, with its base and tip."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..semantics import EndEffector, Group, Semantics
from ..tree import Description, Joint


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

    Groups with a gripper's joints count only if there is no other. Chains win over lists of joints, then groups with an
    end effector over others.
    """
    tree = _Tree(description)
    own = {name: _own_joints(group, description, tree) for name, group in semantics.groups.items()}
    members = {name: _members(group, semantics, own, tree) for name, group in semantics.groups.items()}
    paths = (_path(group, members[name], tree) for name, group in semantics.groups.items())
    groups = list({(group.base, group.tip): group for group in paths if group is not None}.values())
    gripping = {name for effector in semantics.end_effectors for name in _gripping(effector, members, tree)}
    groups = _preferred(groups, lambda group: not gripping.intersection(group.joints))
    groups = _preferred(groups, lambda group: group.base is not None)
    groups = _preferred(groups, lambda group: any(_hangs_on(e, group, tree) for e in semantics.end_effectors))
    return tuple(groups)


class _Tree:
    """The joints by name, parents before children, and the links above each link."""

    def __init__(self, description: Description) -> None:
        self.joints = {joint.name: joint for joint in description.outward_joints()}
        self.joint_to = {joint.child: joint for joint in self.joints.values()}

    def inward(self, link: str) -> Iterator[str]:
        """The link and those above it, up to the root."""
        yield link
        while link in self.joint_to:
            link = self.joint_to[link].parent
            yield link

    def chain(self, base: str, tip: str) -> list[str]:
        """The joints from `base` to `tip`. Empty if a link is unknown, or `base` is not above `tip`."""
        path = list(self.inward(tip))
        return [self.joint_to[link].name for link in path[: path.index(base)]] if base in path else []


def _preferred(groups: list[ArmGroup], better: Callable[[ArmGroup], bool]) -> list[ArmGroup]:
    return [group for group in groups if better(group)] or groups


def _path(group: Group, members: list[Joint], tree: _Tree) -> ArmGroup | None:
    """The group as a path of joints. None if its moving joints branch, or if it has none."""
    moving = [joint for joint in members if joint.moving]
    # Fixed joints beyond the last moving one lead on to the tip only where they do not branch.
    for joints in (members, moving) if moving else ():
        tip = joints[-1].child
        if {joint.child for joint in joints}.issubset(tree.inward(tip)):
            alone = len(group.chains) == 1 and not (group.joints or group.links or group.subgroups)
            base = group.chains[0][0] if alone else None
            return ArmGroup(group.name, base, tip, tuple(joint.name for joint in moving))
    return None


def _own_joints(group: Group, description: Description, tree: _Tree) -> set[str]:
    """The joints that a group names without its subgroups. Unknown names are left out."""
    names = {name for base, tip in group.chains for name in tree.chain(base, tip)}
    names.update(tree.joint_to[link].name for link in group.links if link in tree.joint_to)
    listed = set(group.joints)
    names.update(j.name for j in description.joints.values() if j.name in listed or j.part_of in listed)
    return names


def _members(group: Group, semantics: Semantics, own: dict[str, set[str]], tree: _Tree) -> list[Joint]:
    """The joints of a group and its subgroups, parents before children."""
    found, waiting = {group.name}, [group.name]
    while waiting:
        for name in semantics.groups[waiting.pop()].subgroups:
            if name in semantics.groups and name not in found:
                found.add(name)
                waiting.append(name)
    names = set().union(*(own[name] for name in found))
    return [joint for joint in tree.joints.values() if joint.name in names]


def _gripping(effector: EndEffector, members: dict[str, list[Joint]], tree: _Tree) -> tuple[str, ...]:
    """The moving joints of an end effector's group, if they lie beyond its parent link."""
    joints = [joint for joint in members.get(effector.group, ()) if joint.moving]
    beyond = all(effector.parent_link in tree.inward(joint.parent) for joint in joints)
    return tuple(joint.name for joint in joints) if beyond else ()


def _hangs_on(effector: EndEffector, group: ArmGroup, tree: _Tree) -> bool:
    """Whether the end effector's parent link is one that the group moves."""
    if effector.parent_group:
        return effector.parent_group == group.name
    first = tree.joints[group.joints[0]].child
    return first in tree.inward(effector.parent_link) and effector.parent_link in tree.inward(group.tip)
