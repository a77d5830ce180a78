"""Mutations of an XML tree: its structure, its numbers, its names. Each changes the tree in place."""

from __future__ import annotations

import copy
import re
import xml.etree.ElementTree as ET
from random import Random

from . import hostile

NUMBER = re.compile(r"-?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
NAMING = ("name", "link", "joint")


def _elements(root: ET.Element) -> list[ET.Element]:
    return [element for element in root.iter() if isinstance(element.tag, str)]


def _below(root: ET.Element, rng: Random) -> tuple[ET.Element, ET.Element] | None:
    """A random (parent, child), the kinematic ones preferred; None in an empty tree."""
    pairs = [(parent, child) for parent in _elements(root) for child in parent]
    kinematic = [
        pair for pair in pairs if pair[1].tag in ("joint", "origin", "axis", "limit", "parent", "child", "mimic")
    ]
    pool = kinematic if kinematic and rng.random() < 0.7 else pairs
    return rng.choice(pool) if pool else None


def _joints(root: ET.Element) -> list[ET.Element]:
    return [element for element in _elements(root) if element.tag == "joint" and element.find("parent") is not None]


def _links(root: ET.Element) -> list[str]:
    return [element.get("name", "") for element in root.findall("link")]


# -- structure ---------------------------------------------------------------------------------------------------------


def delete(root: ET.Element, rng: Random) -> None:
    if pair := _below(root, rng):
        pair[0].remove(pair[1])


def duplicate(root: ET.Element, rng: Random) -> None:
    if pair := _below(root, rng):
        pair[0].insert(rng.randrange(len(pair[0]) + 1), copy.deepcopy(pair[1]))


def move(root: ET.Element, rng: Random) -> None:
    if pair := _below(root, rng):
        parent, child = pair
        parent.remove(child)
        targets = _elements(root)
        target = rng.choice(targets)
        target.insert(rng.randrange(len(target) + 1), child)


def rename_tag(root: ET.Element, rng: Random) -> None:
    element = root if rng.random() < 0.05 else (_below(root, rng) or (root, root))[1]
    element.tag = rng.choice(hostile.TAGS)


def drop_attribute(root: ET.Element, rng: Random) -> None:
    pair = _below(root, rng)
    if pair and pair[1].attrib:
        del pair[1].attrib[rng.choice(sorted(pair[1].attrib))]


def change_type(root: ET.Element, rng: Random) -> None:
    if joints := _joints(root):
        rng.choice(joints).set("type", rng.choice(hostile.JOINT_TYPES))


def reparent(root: ET.Element, rng: Random) -> None:
    joints, links = _joints(root), _links(root)
    if joints and links:
        end = rng.choice(joints).find(rng.choice(("parent", "child")))
        if end is not None:
            end.set("link", rng.choice([*links, "nowhere"]))


def mimic(root: ET.Element, rng: Random) -> None:
    if joints := _joints(root):
        joint, master = rng.choice(joints), rng.choice(joints)
        element = ET.SubElement(joint, "mimic", joint=master.get("name", "") if rng.random() < 0.9 else "nobody")
        for name in ("multiplier", "offset"):
            if rng.random() < 0.7:
                element.set(name, rng.choice(("0", "1", "-1", "0.5", "1e-9", "1e8", rng.choice(hostile.NUMBERS))))


def nest(root: ET.Element, rng: Random) -> None:
    if pair := _below(root, rng):
        for _ in range(rng.choice((3, 90, 150, 250))):
            inner = ET.Element(rng.choice(("a", "joint", "link", "origin")))
            pair[1].append(inner)
            pair = pair[1], inner


def litter(root: ET.Element, rng: Random) -> None:
    if pair := _below(root, rng):
        pair[1].text = rng.choice(("text", "0 0 1", "\u00e4", "\ufffe" if rng.random() < 0.1 else "1e400", "${1}"))


# -- numbers -----------------------------------------------------------------------------------------------------------


def _numeric(root: ET.Element, rng: Random) -> tuple[ET.Element, str] | None:
    """A random (element, attribute) that holds a number, those of joints preferred."""
    found = [
        (e, name)
        for e in _elements(root)
        for name, value in e.attrib.items()
        if NUMBER.search(value) and name not in NAMING
    ]
    kinematic = [
        pair
        for pair in found
        if pair[1] in ("xyz", "rpy", "lower", "upper", "multiplier", "offset", "velocity", "effort")
    ]
    pool = kinematic if kinematic and rng.random() < 0.8 else found
    return rng.choice(pool) if pool else None


def hostile_number(root: ET.Element, rng: Random) -> None:
    if place := _numeric(root, rng):
        element, name = place
        spans = [match.span() for match in NUMBER.finditer(element.get(name, ""))]
        start, end = rng.choice(spans)
        value = element.get(name, "")
        element.set(name, value[:start] + rng.choice(hostile.NUMBERS) + value[end:])


def hostile_vector(root: ET.Element, rng: Random) -> None:
    if place := _numeric(root, rng):
        place[0].set(place[1], rng.choice(hostile.VECTORS if place[1] in ("xyz", "rpy") else hostile.NUMBERS))


def other_number(root: ET.Element, rng: Random) -> None:
    """A number that is one, but another: the reading must follow it."""
    if place := _numeric(root, rng):
        text = NUMBER.sub(lambda match: f"{rng.uniform(-2, 2):.17g}", place[0].get(place[1], ""))
        place[0].set(place[1], text)


def count(root: ET.Element, rng: Random) -> None:
    if place := _numeric(root, rng):
        words = place[0].get(place[1], "").split()
        words = words[:-1] if rng.random() < 0.5 else [*words, rng.choice(("0", "1", "x"))]
        place[0].set(place[1], " ".join(words))


def separators(root: ET.Element, rng: Random) -> None:
    if place := _numeric(root, rng):
        joiner = rng.choice((",", ", ", ";", "\t", "\n", "  ", "\u00a0", "\u2003", "_", "/"))
        place[0].set(place[1], joiner.join(place[0].get(place[1], "").split()))


# -- names -------------------------------------------------------------------------------------------------------------


def hostile_name(root: ET.Element, rng: Random) -> None:
    """One name changed, so that whatever refers to it dangles."""
    found = [(element, name) for element in _elements(root) for name in NAMING if name in element.attrib]
    if found:
        element, name = rng.choice(found)
        element.set(name, rng.choice(hostile.NAMES))


def rename(root: ET.Element, rng: Random) -> None:
    """One name changed wherever it stands."""
    names = sorted({element.get(name, "") for element in _elements(root) for name in NAMING if name in element.attrib})
    if names:
        old = rng.choice(names)
        new = rng.choice([*hostile.NAMES, *names])
        for element in _elements(root):
            for name in NAMING:
                if element.get(name) == old:
                    element.set(name, new)


STRUCTURE = (*(delete, duplicate, move, rename_tag, drop_attribute, change_type), *(reparent, mimic, nest, litter))
NUMBERS = (hostile_number, hostile_vector, other_number, count, separators)
NAMES = (hostile_name, rename)
