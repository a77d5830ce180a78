"""A second reading of a description: plain ElementTree and URDF's own rules in forty lines. Nothing of twistarm."""

from __future__ import annotations

import codecs
import re
import xml.etree.ElementTree as ET
from collections.abc import Container, Mapping

import numpy as np
from numpy.typing import ArrayLike


def parsed(data: bytes) -> ET.Element:
    """The root element; prefixes that nobody declared are part of the tag's name."""
    text = re.sub(r"^\s*<\?xml[^>]*\?>", "", decoded(data))
    text = re.sub(r"\sxmlns(:\w+)?\s*=\s*(\"[^\"]*\"|'[^']*')", "", text)
    return ET.fromstring(
        re.sub(r"(?<=[<\s/])[\w.-]+(?::[\w.-]+)+(?=[\s=/>])", lambda m: m.group().replace(":", "_"), text)
    )


def decoded(data: bytes) -> str:
    """UTF-16 by its mark, UTF-8, else Latin-1."""
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
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
    joints = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    above = {joint.find("child").get("link"): joint for joint in joints.values()}  # type: ignore[union-attr]
    g, link = np.eye(4), tip
    while link != base:
        joint = above[link]
        g = origin(joint) @ motion(joint, value, joints) @ g
        link = joint.find("parent").get("link", "")  # type: ignore[union-attr]
    return g


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


def potential_energy(robot: ET.Element, value: Mapping[str, float], base: str, massless: Container[str]) -> float:
    """Σ m · 9.81 m/s² · height of the centre, of the links beyond `base` that are not known to be massless."""
    energy = 0.0
    for link in robot.findall("link"):
        inertial, name = link.find("inertial"), link.get("name", "")
        if inertial is not None and name not in massless:
            (mass,) = numbers(inertial.find("mass"), "value", "0")
            energy += mass * 9.81 * (pose(robot, value, base, name) @ origin(inertial))[2, 3]
    return float(energy)
