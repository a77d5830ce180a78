"""Findings for words that are not read, which would silently change the arm.

They are misspelt, doubled or empty, or belong to a later version of URDF. As in urdfdom, a new attribute counts from
its version on.
"""

from __future__ import annotations

import functools
import re
import xml.etree.ElementTree as ET
from collections import Counter
from difflib import get_close_matches

from ..support.errors import closest, listed
from .document import Reading

ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"),
    "mimic": ("joint", "multiplier", "offset"),
    "parent": ("link",),
    "child": ("link",),
}
"""Elements of a joint that the kinematics depends on, with their attributes."""

KNOWN = ((1, 0), (1, 1), (1, 2))

ADDED = {
    "quat_xyzw": ("origin", (1, 1)),
    "acceleration": ("limit", (1, 2)),
    "deceleration": ("limit", (1, 2)),
    "jerk": ("limit", (1, 2)),
}
"""Attributes of later versions, with their element and version."""

SIMILAR = 0.75
"""Similarity of a word and its misspelling: `orgin` is one, `physics` belongs to another tool."""


LONGEST, MOST_ATTRIBUTES = 40, 10
"""Most letters of a word to compare, and attributes of an element in findings."""


def note_unread_words(robot: ET.Element, reading: Reading) -> None:
    """Note words that no reader of URDF reads in a joint's origin, axis, limits and mimic.

    These are unknown attributes, elements with nearly a name of `ATTRIBUTES`, second elements of a kind (the first
    counts), and an `<axis>` without numbers, which is then x.
    """
    for joint in robot.findall("joint"):
        _note_slips(joint, reading)
        _note_doubles(joint, reading)
        for element in joint:
            _note_attributes(joint, element, reading)


def _note_slips(joint: ET.Element, reading: Reading) -> None:
    for tag in (element.tag for element in joint if element.tag not in ATTRIBUTES):
        if _is_slip(tag):
            remedy = f"correct the name{closest(tag, ATTRIBUTES)}"
            reading.note("word-unread", joint, f"its <{tag}> means nothing and is not read", remedy)


@functools.lru_cache(1_000)
def _is_slip(word: str) -> bool:
    return len(word) <= LONGEST and bool(get_close_matches(word.casefold(), ATTRIBUTES, 1, SIMILAR))


def _note_doubles(joint: ET.Element, reading: Reading) -> None:
    for tag, count in Counter(element.tag for element in joint if element.tag in ATTRIBUTES).items():
        if count > 1:
            what = f"it has {count} <{tag}> elements; only the first is read"
            reading.note("word-unread", joint, what, "keep the one that is meant")


def _note_attributes(joint: ET.Element, element: ET.Element, reading: Reading) -> None:
    known = ATTRIBUTES.get(element.tag, ())
    unread = [name for name in element.attrib if known and name not in known and ":" not in name]
    for name in unread[:MOST_ATTRIBUTES]:
        remedy = f"its attributes are {listed(known)}{closest(name, known)}"
        more = f" (nor {len(unread) - MOST_ATTRIBUTES} others)" if len(unread) > MOST_ATTRIBUTES else ""
        what = f"{name}= in its <{element.tag}> means nothing and is not read{more}"
        reading.note("word-unread", joint, what, remedy)
    if element.tag == "axis" and "xyz" not in element.attrib and joint.get("type") not in ("fixed", "floating"):
        reading.note("word-unread", joint, "its <axis> has no xyz=; taken as 1 0 0", 'write <axis xyz="…"/>')


def settle_version(robot: ET.Element, reading: Reading) -> None:
    """Remove attributes that the robot's version does not have, and the version itself if Pinocchio does not need it.

    An unknown version is read as the newest, which has all attributes.
    """
    written = robot.attrib.pop("version", "1.0")
    version = _version(written, reading)
    for name, (tag, since) in ADDED.items():
        those = [element for element in robot.iter(tag) if name in element.attrib]
        least = "{}.{}".format(*since)
        if those and version < since:
            what = f"{name}= in {len(those)} <{tag}> is not read: URDF {written} does not have it"
            reading.note("word-unread", None, what, f'write <robot version="{least}"> if it is meant')
            for element in those:
                del element.attrib[name]
        elif those and tag == "origin":
            robot.set("version", least)


def _version(written: str, reading: Reading) -> tuple[int, int]:
    found = re.fullmatch(r"([0-9]{1,3})\.([0-9]{1,3})", written)
    version = (int(found[1]), int(found[2])) if found else None
    if version in KNOWN:
        return version
    known = ", ".join("{}.{}".format(*one) for one in KNOWN)
    what = f"URDF version {written!r} is not known here; it is read as the newest, and other readers refuse it"
    reading.note("word-unread", None, what, f"write one of {known}")
    return KNOWN[-1]
