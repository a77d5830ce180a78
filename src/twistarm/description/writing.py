"""Elements of URDF, with numbers that read back as the same bits."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping

import numpy as np

from ..support.checks import Array
from ..theory.rotations import to_rpy
from .bounds import WIDE


def number_text(numbers: Iterable[float]) -> str:
    """Digits that read back as the same numbers. Adding 0 drops the sign of a zero."""
    return " ".join(repr(float(number) + 0.0) for number in numbers)


def add_origin(element: ET.Element, g: Array) -> None:
    """Add the `<origin>` of a pose (4, 4)."""
    rpy = np.zeros(3) if np.array_equal(g[:3, :3], np.eye(3)) else to_rpy(g[:3, :3])
    ET.SubElement(element, "origin", xyz=number_text(g[:3, 3]), rpy=number_text(rpy))


def add_joint(
    robot: ET.Element,
    name: str,
    kind: str,
    ends: tuple[str, str],
    origin: Array,
    axis: Iterable[float] = (),
    limit: Mapping[str, float] | None = None,
) -> ET.Element:
    """Add a joint from the first of the links `ends` to a new link, the second. Return the joint's element.

    Readers of URDF refuse infinity; `WIDE` replaces it.
    """
    ET.SubElement(robot, "link", name=ends[1])
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    ET.SubElement(joint, "parent", link=ends[0])
    ET.SubElement(joint, "child", link=ends[1])
    add_origin(joint, origin)
    if kind != "fixed":
        ET.SubElement(joint, "axis", xyz=number_text(axis))
    if limit:
        numbers = {key: repr(float(np.clip(value, -WIDE, WIDE))) for key, value in limit.items()}
        ET.SubElement(joint, "limit", numbers)
    return joint


def add_mimic(joint: ET.Element, master: str, multiplier: float, offset: float = 0.0) -> None:
    """Let a joint follow another: value = multiplier · (value of `master`) + offset."""
    ET.SubElement(joint, "mimic", joint=master, multiplier=repr(float(multiplier)), offset=repr(float(offset)))
