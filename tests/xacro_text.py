"""A two-joint arm as a xacro file, and packages laid out in folders."""

from __future__ import annotations

from pathlib import Path

from urdf_text import joint, robot

XMLNS = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
ARM = robot(joint("a", "base_link", "upper"), joint("b", "upper", "tool0"))
MANIFEST = "<package><name>{}</name></package>".format


def as_xacro(inside: str) -> str:
    return ARM.replace('<robot name="tiny">', f'<robot name="tiny" {XMLNS}>{inside}')


def lay(folder: Path, files: dict[str, str]) -> Path:
    """The folder, with files by their path in it."""
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    return folder
