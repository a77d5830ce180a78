"""Findings for words that are not read, which would silently change the arm.

They are misspelt, doubled or empty, or belong to a later version of URDF. As in urdfdom, a new attribute counts from
its version on.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from difflib import get_close_matches

from ..support.errors import closest, listed
from .document import Reading

VERSIONS = ("1.0", "1.1", "1.2")

LATER = {"quat_xyzw": "1.1", "acceleration": "1.2", "deceleration": "1.2", "jerk": "1.2"}
"""Attributes of later versions, with their version."""

ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"),
    "mimic": ("joint", "multiplier", "offset"),
    "parent": ("link",),
    "child": ("link",),
}
"""Elements of a joint that the kinematics depends on, with their attributes."""

SIMILAR = 0.75
"""Similarity of a word and its misspelling: `orgin` is one, `physics` belongs to another tool."""


def note_unread_words(robot: ET.Element, reading: Reading) -> None:
    """Note words that no reader of URDF reads in a joint's origin, axis, limits and mimic.

    These are unknown attributes, elements with nearly a name of `ATTRIBUTES`, second elements of a kind (the first
    counts), an `<axis>` without numbers, which is then x, and attributes that the robot's version does not have. The
    latter are removed, and the version itself if Pinocchio does not need it. An unknown version is read as the newest.
    """
    written = robot.attrib.pop("version", "1.0")
    version = written if written in VERSIONS else VERSIONS[-1]
    if written not in VERSIONS:
        what = f"URDF version {written!r} is not known here; it is read as the newest, and other readers refuse it"
        reading.note("word-unread", None, what, f"write one of {', '.join(VERSIONS)}")
    for name, since in LATER.items():
        tag = "origin" if name == "quat_xyzw" else "limit"
        those = [element for element in robot.iter(tag) if name in element.attrib]
        if those and version < since:
            what = f"{name}= in {len(those)} <{tag}> is not read: URDF {written} does not have it"
            reading.note("word-unread", None, what, f'write <robot version="{since}"> if it is meant')
            for element in those:
                del element.attrib[name]
        elif those and tag == "origin":
            robot.set("version", since)
    for joint in robot.findall("joint"):
        tags = [element.tag for element in joint]
        for tag in dict.fromkeys(tags):
            if tag in ATTRIBUTES and tags.count(tag) > 1:
                what = f"it has {tags.count(tag)} <{tag}> elements; only the first is read"
                reading.note("word-unread", joint, what, "keep the one that is meant")
            elif tag not in ATTRIBUTES and get_close_matches(tag.casefold(), ATTRIBUTES, 1, SIMILAR):
                remedy = f"correct the name{closest(tag, ATTRIBUTES)}"
                reading.note("word-unread", joint, f"its <{tag}> means nothing and is not read", remedy)
        for element in joint:
            known = ATTRIBUTES.get(element.tag, ())
            for name in (name for name in element.attrib if known and name not in known and ":" not in name):
                what = f"{name}= in its <{element.tag}> means nothing and is not read"
                reading.note("word-unread", joint, what, f"its attributes are {listed(known)}{closest(name, known)}")
            if element.tag == "axis" and "xyz" not in element.attrib and joint.get("type") not in ("fixed", "floating"):
                reading.note("word-unread", joint, "its <axis> has no xyz=; taken as 1 0 0", 'write <axis xyz="…"/>')
