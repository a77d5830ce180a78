"""Names that an SRDF and a description do not share."""

from __future__ import annotations

from collections.abc import Iterator

from ...support.errors import listed
from ..findings import Finding, Place, finding
from ..tree import Description
from .srdf import Semantics


def note_names(semantics: Semantics, description: Description) -> tuple[Finding, ...]:
    """Note entries for missing links and joints, and an SRDF for another robot."""
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
