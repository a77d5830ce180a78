"""Checks that a description is a tree: one root, each link defined once and reached once."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter

from ..support.errors import closest, listed
from .document import Reading
from .findings import refusal

MAX_LINKS_DEEP = 1000
"""Longest chain of links. Pinocchio's parser overflows its stack at some 4,000."""


MAX_PARTS = {"link": 4_000, "joint": 4_000, "visual": 10_000, "collision": 10_000}
"""The largest robots have some 150 links and 300 shapes, a whole cell a few thousand. Pinocchio compares each name with
all before, and Ctrl-C waits for it. It takes a fifth of a second for 4,000 names, and five seconds for 20,000."""

MAX_NAME = 500
"""Characters of a link's or joint's name."""

MOST_HINTS = 10
"""Most mistakes with a closest name. Each search goes through all names."""


def check_structure(robot: ET.Element, reading: Reading) -> None:
    """Raise DescriptionError unless the description is a tree of named links and joints."""
    links, joints = robot.findall("link"), robot.findall("joint")
    _check_counts(robot, reading)
    if not links:
        raise refusal("no-robot", reading.whole, "it has no links", "is it a robot description?")
    for elements in (links, joints):
        _check_names(elements, reading)
    names = {link.get("name", "") for link in links}
    for joint in joints:
        for end in ("parent", "child"):
            _check_end(joint, end, names, reading)
    reading.require_usable()
    _check_parents(joints, reading)
    reading.require_usable()
    _check_connected(robot, reading)


def _check_counts(robot: ET.Element, reading: Reading) -> None:
    counts = Counter(element.tag for element in robot if element.tag in MAX_PARTS)
    counts.update(shape.tag for link in robot.findall("link") for shape in link if shape.tag in MAX_PARTS)
    for tag, most in MAX_PARTS.items():
        if counts[tag] > most:
            what = f"it has {counts[tag]:,} elements <{tag}>; at most {most:,} are read"
            raise refusal("too-large", reading.whole, what, "is it a whole scene? leave out all but the robot")


def _check_names(elements: list[ET.Element], reading: Reading) -> None:
    for element in elements:
        if not element.get("name"):
            reading.note("name-unusable", element, "it has no name", "every link and joint needs one")
        elif len(element.get("name", "")) > MAX_NAME:
            what = f"its name has {len(element.get('name', '')):,} characters; at most {MAX_NAME} are read"
            reading.note("name-unusable", element, what, "shorten it")
    counts = Counter(element.get("name") for element in elements)
    last = {element.get("name"): element for element in elements}
    for name, count in counts.items():
        if name and count > 1:
            reading.note("name-unusable", last[name], f"the name is used by {count} {last[name].tag}s", "rename one")


def _check_end(joint: ET.Element, end: str, names: set[str], reading: Reading) -> None:
    element = joint.find(end)
    link = None if element is None else element.get("link")
    if not link:
        reading.note("not-a-tree", joint, f"it has no <{end} link=…>", f"name its {end} link")
    elif link not in names:
        hint = closest(link, names) if len(reading.findings.kept) < MOST_HINTS else ""
        remedy = f"define it, or correct the name{hint}"
        reading.note("not-a-tree", joint, f"its {end} link {link!r} is not defined", remedy)


def _check_parents(joints: list[ET.Element], reading: Reading) -> None:
    first: dict[str, ET.Element] = {}
    for joint in joints:
        child = end_of(joint, "child")
        if child in first:
            what = f"link {child!r} has two parents: joint {first[child].get('name')!r} moves it too"
            reading.note("not-a-tree", joint, what, "remove one joint")
        first[child] = joint


def end_of(joint: ET.Element, end: str) -> str:
    """The link at the "parent" or "child" end of a joint that `check_structure` has seen."""
    return joint.find(end).get("link", "")  # type: ignore[union-attr]


def root_links(robot: ET.Element) -> list[str]:
    """The links without a parent."""
    children = {end_of(joint, "child") for joint in robot.findall("joint")}
    return [name for link in robot.findall("link") if (name := link.get("name", "")) not in children]


def _check_connected(robot: ET.Element, reading: Reading) -> None:
    """Check for one root, no cycle, and a depth that Pinocchio can read."""
    roots = root_links(robot)
    if len(roots) > 1:
        what = f"{len(roots)} root links: {listed(roots)}"
        raise refusal("not-a-tree", reading.whole, what, "a robot has one: join them with fixed joints")
    children: dict[str, list[str]] = {}
    for joint in robot.findall("joint"):
        children.setdefault(end_of(joint, "parent"), []).append(end_of(joint, "child"))
    reached: set[str] = set()
    level = roots
    depth = 0
    while level:
        depth += 1
        if depth > MAX_LINKS_DEEP:
            what = f"a chain of more than {MAX_LINKS_DEEP} links"
            raise refusal("too-large", reading.whole, what, "is it generated?")
        reached.update(level)
        level = [child for link in level for child in children.get(link, [])]
    cyclic = [link.get("name", "") for link in robot.findall("link") if link.get("name") not in reached]
    if cyclic:
        what = f"the joints of {listed(cyclic)} form a cycle"
        raise refusal("not-a-tree", reading.whole, what, "a URDF is a tree: remove one of its joints")
