"""A second reading of a description: plain ElementTree and URDF's own rules in forty lines. Nothing of twistarm."""

from __future__ import annotations

import codecs
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike


def parsed(data: bytes) -> ET.Element:
    """The root element; prefixes that nobody declared are part of the tag's name."""
    text = re.sub(r"^\s*<\?xml[^>]*\?>", "", decoded(data))
    text = re.sub(r"\sxmlns(:\w+)?\s*=\s*(\"[^\"]*\"|'[^']*')", "", text)
    return ET.fromstring(
        re.sub(r"(?<=[<\s/])[\w.-]+(?::[\w.-]+)+(?=[\s=/>])", lambda m: m.group().replace(":", "_"), text)
    )


# How a text begins in each encoding, by XML 1.0, appendix F: a mark, or a first character of ASCII.
STARTS = (
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
    (b"[^\0]\0\0\0", "utf-32-le"),
    (b"\0\0\0[^\0]", "utf-32-be"),
    (b"[^\0]\0[^\0]", "utf-16-le"),
    (b"\0[^\0]\0", "utf-16-be"),
    (b"", "utf-8-sig"),
)


def decoded(data: bytes) -> str:
    """By how it begins; Latin-1 what is not of that encoding."""
    encoding = next(encoding for start, encoding in STARTS if re.match(start, data, re.DOTALL))
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        return data.decode("latin-1")


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula: I + sin a K + (1 − cos a) K²."""
    x, y, z = axis
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def numbers(element: ET.Element | None, name: str, default: str) -> np.ndarray:
    text = default if element is None else element.get(name, default)
    return np.array([float(word) for word in text.split()])


def origin(joint: ET.Element) -> np.ndarray:
    element = joint.find("origin")
    return placed(numbers(element, "xyz", "0 0 0"), numbers(element, "rpy", "0 0 0"))


def placed(xyz: ArrayLike, rpy: ArrayLike) -> np.ndarray:
    """The pose (4, 4) at xyz, turned by Rz(yaw) Ry(pitch) Rx(roll)."""
    roll, pitch, yaw = np.asarray(rpy)
    x, y, z = np.eye(3)
    g = np.eye(4)
    g[:3, :3] = rotation(z, yaw) @ rotation(y, pitch) @ rotation(x, roll)
    g[:3, 3] = xyz
    return g


def motion(joint: ET.Element, value: Mapping[str, float], joints: Mapping[str, ET.Element]) -> np.ndarray:
    """What the joint adds to its origin; a planar one slides along x, y of its plane, then turns about the normal."""
    name, kind, g = joint.get("name", ""), joint.get("type"), np.eye(4)
    axis = numbers(joint.find("axis"), "xyz", "1 0 0") if kind not in ("fixed", "floating") else np.array([1.0, 0, 0])
    axis = axis / np.linalg.norm(axis)
    if kind in ("revolute", "continuous"):
        g[:3, :3] = rotation(axis, joint_value(name, value, joints))
    elif kind == "prismatic":
        g[:3, 3] = axis * joint_value(name, value, joints)
    elif kind == "planar":
        along = np.array([0.0, 1, 0]) if abs(axis[0]) > 0.9 else np.array([1.0, 0, 0])
        x = along - axis * (axis @ along)
        x /= np.linalg.norm(x)
        g[:3, 3] = x * value.get(f"{name}_x", 0.0) + np.cross(axis, x) * value.get(f"{name}_y", 0.0)
        g[:3, :3] = rotation(axis, value.get(f"{name}_rz", 0.0))
    return g


def joint_value(name: str, value: Mapping[str, float], joints: Mapping[str, ET.Element]) -> float:
    """The given value, or multiplier · (master's value) + offset."""
    joint = joints.get(name)
    mimic = None if joint is None else joint.find("mimic")
    if name in value or joint is None or mimic is None or joint.get("type") == "fixed":
        return value.get(name, 0.0)
    (multiplier,), (offset,) = numbers(mimic, "multiplier", "1"), numbers(mimic, "offset", "0")
    if multiplier == 0.0:
        return float(offset)
    return float(multiplier * joint_value(mimic.get("joint", ""), value, joints) + offset)


def pose(robot: ET.Element, value: Mapping[str, float], base: str, tip: str) -> np.ndarray:
    """The tip seen from the base, (4, 4)."""
    joints = named_joints(robot)
    g = np.eye(4)
    for joint in path(robot, base, tip):
        g = origin(joint) @ motion(joint, value, joints) @ g
    return g


def named_joints(robot: ET.Element) -> dict[str, ET.Element]:
    return {joint.get("name", ""): joint for joint in robot.findall("joint")}


def path(robot: ET.Element, base: str, tip: str) -> list[ET.Element]:
    """The joints between, from the tip on."""
    above = {joint.find("child").get("link"): joint for joint in named_joints(robot).values()}  # type: ignore[union-attr]
    joints: list[ET.Element] = []
    while tip != base:
        joints.append(above[tip])
        tip = joints[-1].find("parent").get("link", "")  # type: ignore[union-attr]
    return joints


def coordinates(robot: ET.Element, base: str, tip: str) -> set[str]:
    """The names of the independent coordinates between base and tip: those of masters, not of followers."""
    joints, names = named_joints(robot), set()
    for joint in path(robot, base, tip):
        name = joint.get("name", "")
        if joint.get("type") == "planar":
            names |= {f"{name}_x", f"{name}_y", f"{name}_rz"}
            continue
        while (mimic := joint.find("mimic")) is not None and joint.get("type") != "fixed":
            (multiplier,) = numbers(mimic, "multiplier", "1")
            name = mimic.get("joint", "") if multiplier else ""
            joint = joints.get(name, ET.Element("joint"))
        if joint.get("type") in ("revolute", "continuous", "prismatic"):
            names.add(name)
    return names


def bounds(robot: ET.Element) -> dict[str, tuple[float, float]]:
    """lower and upper, soft limits included, of the joints that give both and neither follow nor are followed."""
    masters = {mimic.get("joint") for mimic in robot.iter("mimic")}
    return {
        joint.get("name", ""): _softened(joint, float(limit.get("lower", "")), float(limit.get("upper", "")))
        for joint in robot.findall("joint")
        for limit in joint.findall("limit")[:1]
        if joint.get("type") in ("revolute", "prismatic")
        and {"lower", "upper"} <= set(limit.attrib)
        and joint.get("name") not in masters
        and joint.find("mimic") is None
    }


def _softened(joint: ET.Element, lower: float, upper: float) -> tuple[float, float]:
    """The range inside the soft limits (URDF: a missing one is 0), or the whole one if that leaves no room."""
    soft = joint.find("safety_controller")
    if soft is None:
        return lower, upper
    least, most = (float(soft.get(f"soft_{end}_limit", "0")) for end in ("lower", "upper"))
    narrow = max(lower, least), min(upper, most)
    return narrow if least != most and narrow[0] < narrow[1] else (lower, upper)


def potential_energy(robot: ET.Element, value: Mapping[str, float], base: str) -> float:
    """Σ m · 9.81 m/s² · height of the centre, of the links beyond `base`."""
    energy = 0.0
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        if inertial is not None and (mass := mass_of(inertial)) > 0.0:
            energy += mass * 9.81 * (pose(robot, value, base, link.get("name", "")) @ origin(inertial))[2, 3]
    return float(energy)


def mass_of(inertial: ET.Element) -> float:
    """The mass of a link; 0 without `<mass>` or `<inertia>`, and if a number of the `<inertial>` is none.

    Torques alone need it, so a robot may lack it. An entry that `<inertia>` lacks is 0.
    """
    mass, inertia, place = (inertial.find(tag) for tag in ("mass", "inertia", "origin"))
    if mass is None or inertia is None:
        return 0.0
    value = mass.get("value", "")
    single = [value, *(inertia.get(f"i{axes}", "0") for axes in ("xx", "xy", "xz", "yy", "yz", "zz"))]
    triple = [] if place is None else [place.get("xyz", "0 0 0"), place.get("rpy", "0 0 0")]
    usable = all(is_numbers(text, 1) for text in single) and all(is_numbers(text, 3) for text in triple)
    return float(value) if usable else 0.0


def is_numbers(text: str, count: int) -> bool:
    """Whether the text has so many decimal numbers, none of which is larger or longer than any of a robot."""
    words = text.split()
    decimal = all(re.fullmatch(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?", word) for word in words)
    return len(words) == count and decimal and all(abs(float(word)) <= 1e9 and len(word) <= 400 for word in words)
