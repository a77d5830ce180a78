"""The arm's group of an SRDF, with its base and tip."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
    members = _members(semantics, description)
    paths = (_path(group, members[name], description) for name, group in semantics.groups.items())
    groups = list({(group.base, group.tip): group for group in paths if group is not None}.values())
    effectors = semantics.end_effectors
    gripping = {name for effector in effectors for name in _gripping(effector, members, description)}
    preferences: tuple[Callable[[ArmGroup], bool], ...] = (
        lambda group: not gripping.intersection(group.joints),
        lambda group: group.base is not None,
        lambda group: any(_hangs_on(effector, group, description) for effector in effectors),
    )
    for better in preferences:
        groups = [group for group in groups if better(group)] or groups
    return tuple(groups)


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
        for each in found:  # which grows by the subgroups
            found += [sub for sub in semantics.groups[each].subgroups if sub in own and sub not in found]
        names = set().union(*(own[each] for each in found))
        members[name] = [joint for joint in order if joint.name in names]
    return members


def _path(group: Group, members: Sequence[Joint], description: Description) -> ArmGroup | None:
    """The group as a path of joints. None if its moving joints branch, or if it has none."""
    moving = [joint for joint in members if joint.moving]
    # Fixed joints beyond the last moving one lead on to the tip only where they do not branch.
    for joints in (members, moving) if moving else ():
        tip = joints[-1].child
        if {joint.child for joint in joints}.issubset(description.inward(tip)):
            alone = len(group.chains) == 1 and not (group.joints or group.links or group.subgroups)
            base = group.chains[0][0] if alone else None
            return ArmGroup(group.name, base, tip, tuple(joint.name for joint in moving))
    return None


def _gripping(effector: EndEffector, members: Mapping[str, Sequence[Joint]], description: Description) -> list[str]:
    """The moving joints of an end effector's group, if they lie beyond its parent link."""
    joints = [joint for joint in members.get(effector.group, ()) if joint.moving]
    beyond = all(effector.parent_link in description.inward(joint.parent) for joint in joints)
    return [joint.name for joint in joints] if beyond else []


def _hangs_on(effector: EndEffector, group: ArmGroup, description: Description) -> bool:
    """Whether the end effector's parent link is one that the group moves."""
    if effector.parent_group:
        return effector.parent_group == group.name
    first = description.joints[group.joints[0]].child
    return first in description.inward(effector.parent_link) and effector.parent_link in description.inward(group.tip)
