"""Checks of a URDF's elements: a tree with one root, each link defined and reached once, and words that are not read.

As in urdfdom, an attribute of a later version of URDF counts from that version on.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from difflib import get_close_matches

from ..support.errors import closest, listed
from .document import Reading
from .findings import refusal

MAX_LINKS_DEEP = 1000  # Longest chain of links. Pinocchio's parser overflows its stack at some 4,000.
# The largest robots have some 150 links and 300 shapes, a whole cell a few thousand. Pinocchio compares each name
# with all before, and Ctrl-C waits for it. It takes a fifth of a second for 4,000 names, and five seconds for
# 20,000.
MAX_PARTS = {"link": 4_000, "joint": 4_000, "visual": 10_000, "collision": 10_000}
MAX_NAME = 500  # Characters of a link's or joint's name.
MOST_HINTS = 10  # Most mistakes with a closest name. Each search goes through all names.

VERSIONS = ("1.0", "1.1", "1.2")

# Attributes of later versions, with their version.
LATER = {"quat_xyzw": "1.1", "acceleration": "1.2", "deceleration": "1.2", "jerk": "1.2"}

ATTRIBUTES = {
    "origin": ("xyz", "rpy", "quat_xyzw"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "velocity", "effort", "acceleration", "deceleration", "jerk"),
    "mimic": ("joint", "multiplier", "offset"),
    "parent": ("link",),
    "child": ("link",),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
}
"""Elements that kinematics, masses and shapes depend on, with their attributes."""

CONTENTS = {
    "joint": ("origin", "axis", "limit", "mimic", "parent", "child"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
}
"""Elements with the elements in them that are read. All but shapes may occur once."""

SIMILAR = 0.75  # Similarity of a word and its misspelling: `orgin` is one, `physics` belongs to another tool.


def check_structure(robot: ET.Element, reading: Reading) -> None:
    """Raise DescriptionError unless the description is a tree of named links and joints."""
    links, joints = robot.findall("link"), robot.findall("joint")
    counts = Counter(element.tag for element in (*robot, *(shape for link in links for shape in link)))
    for tag, most in MAX_PARTS.items():
        if counts[tag] > most:
            what = f"it has {counts[tag]:,} elements <{tag}>; at most {most:,} are read"
            raise refusal("too-large", reading.whole, what, "is it a whole scene? leave out all but the robot")
    if not links:
        raise refusal("no-robot", reading.whole, "it has no links", "is it a robot description?")
    for elements in (links, joints):
        _check_names(elements, reading)
    names = {link.get("name", "") for link in links}
    movers: dict[str, ET.Element] = {}
    for joint in joints:
        for end in ("parent", "child"):
            _check_end(joint, end, names, reading)
    reading.require_usable()
    for joint in joints:
        child = end_of(joint, "child")
        if child in movers:
            what = f"link {child!r} has two parents: joint {movers[child].get('name')!r} moves it too"
            reading.note("not-a-tree", joint, what, "remove one joint")
        movers[child] = joint
    reading.require_usable()
    _check_connected(robot, reading)


def _check_names(elements: list[ET.Element], reading: Reading) -> None:
    for element in elements:
        name = element.get("name", "")
        if not name:
            reading.note("name-unusable", element, "it has no name", "every link and joint needs one")
        elif len(name) > MAX_NAME:
            what = f"its name has {len(name):,} characters; at most {MAX_NAME} are read"
            reading.note("name-unusable", element, what, "shorten it")
    counts = Counter(element.get("name", "") for element in elements)
    for name, element in {element.get("name", ""): element for element in elements}.items():
        if name and counts[name] > 1:
            what = f"the name is used by {counts[name]} {element.tag}s"
            reading.note("name-unusable", element, what, "rename one")


def _check_end(joint: ET.Element, end: str, names: set[str], reading: Reading) -> None:
    element = joint.find(end)
    link = None if element is None else element.get("link")
    if not link:
        reading.note("not-a-tree", joint, f"it has no <{end} link=…>", f"name its {end} link")
    elif link not in names:
        hint = closest(link, names) if len(reading.findings) < MOST_HINTS else ""
        remedy = f"define it, or correct the name{hint}"
        reading.note("not-a-tree", joint, f"its {end} link {link!r} is not defined", remedy)


def end_of(joint: ET.Element, end: str) -> str:
    """The link at the "parent" or "child" end of a joint that `check_structure` has seen."""
    return joint.find(end).get("link", "")  # type: ignore[union-attr]


def root_links(robot: ET.Element) -> list[str]:
    """The links without a parent."""
    children = {end_of(joint, "child") for joint in robot.findall("joint")}
    return [name for link in robot.findall("link") if (name := link.get("name", "")) not in children]


def _check_connected(robot: ET.Element, reading: Reading) -> None:
    """Check for one root, no cycle, and a depth that Pinocchio can read."""
    level = root_links(robot)
    if len(level) > 1:
        what = f"{len(level)} root links: {listed(level)}"
        raise refusal("not-a-tree", reading.whole, what, "a robot has one: join them with fixed joints")
    children: dict[str, list[str]] = {}
    for joint in robot.findall("joint"):
        children.setdefault(end_of(joint, "parent"), []).append(end_of(joint, "child"))
    reached: set[str] = set()
    depth = 0
    while level:
        depth += 1
        if depth > MAX_LINKS_DEEP:
            what = f"a chain of more than {MAX_LINKS_DEEP} links"
            raise refusal("too-large", reading.whole, what, "is it generated?")
        reached.update(level)
        level = [child for link in level for child in children.get(link, [])]
    cyclic = [name for link in robot.findall("link") if (name := link.get("name", "")) not in reached]
    if cyclic:
        what = f"the joints of {listed(cyclic)} form a cycle"
        raise refusal("not-a-tree", reading.whole, what, "a URDF is a tree: remove one of its joints")


def note_unread_words(robot: ET.Element, reading: Reading) -> None:
    """Note words that no reader of URDF reads in joints, and in masses and shapes of links.

    These are unknown attributes, elements with nearly a name of `CONTENTS`, second elements of a kind (the first
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
    for part in (*robot.findall("joint"), *robot.findall("link")):
        _note_words_in(part, part, reading)


def _note_words_in(part: ET.Element, element: ET.Element, reading: Reading) -> None:
    """Note the words in an `element` of a joint or link, the `part`."""
    known, tags = CONTENTS[element.tag], [child.tag for child in element]
    it = "it" if element is part else f"its <{element.tag}>"
    for tag in dict.fromkeys(tags):
        if tag in known and tags.count(tag) > 1 and tag not in ("visual", "collision"):
            what = f"{it} has {tags.count(tag)} <{tag}> elements; only the first is read"
            reading.note("word-unread", part, what, "keep the one that is meant")
        elif tag not in known and get_close_matches(tag.casefold(), known, 1, SIMILAR):
            remedy = f"correct the name{closest(tag, known)}"
            reading.note("word-unread", part, f"its <{tag}> means nothing and is not read", remedy)
    for child in element:
        allowed = ATTRIBUTES.get(child.tag, ())
        for name in (name for name in child.attrib if allowed and name not in allowed and ":" not in name):
            what = f"{name}= in its <{child.tag}> means nothing and is not read"
            reading.note("word-unread", part, what, f"its attributes are {listed(allowed)}{closest(name, allowed)}")
        if child.tag == "axis" and "xyz" not in child.attrib and part.get("type") not in ("fixed", "floating"):
            reading.note("word-unread", part, "its <axis> has no xyz=, which counts as 1 0 0", 'write <axis xyz="…"/>')
        if element is part and child.tag in CONTENTS:
            _note_words_in(part, child, reading)
