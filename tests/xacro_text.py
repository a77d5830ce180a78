"""A two-joint arm as a xacro file."""

from __future__ import annotations

from hostile.sandbox import XMLNS
from urdf_text import joint, robot

ARM = robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0"))


def as_xacro(inside: str) -> str:
    return ARM.replace('<robot name="tiny">', f'<robot name="tiny" {XMLNS}>{inside}')
