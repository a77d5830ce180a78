"""URDF's versions. As in urdfdom, a new attribute counts from its version on. Older files give a finding."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from .document import Reading

KNOWN = ((1, 0), (1, 1), (1, 2))

ADDED = {
    "quat_xyzw": ("origin", (1, 1)),
    "acceleration": ("limit", (1, 2)),
    "deceleration": ("limit", (1, 2)),
    "jerk": ("limit", (1, 2)),
}
"""Attributes of later versions, with their element and version."""


def settle_version(robot: ET.Element, reading: Reading) -> None:
    """Remove attributes that the robot's version does not have, and the version itself if Pinocchio does not need it.

    An unknown version is read as the newest, which has all attributes.
    """
    written = robot.attrib.pop("version", "1.0")
    version = _known(written, reading)
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


def _known(written: str, reading: Reading) -> tuple[int, int]:
    found = re.fullmatch(r"([0-9]{1,3})\.([0-9]{1,3})", written)
    version = (int(found[1]), int(found[2])) if found else None
    if version in KNOWN:
        return version
    known = ", ".join("{}.{}".format(*one) for one in KNOWN)
    what = f"URDF version {written!r} is not known here; it is read as the newest, and other readers refuse it"
    reading.note("version-unknown", None, what, f"write one of {known}")
    return KNOWN[-1]
