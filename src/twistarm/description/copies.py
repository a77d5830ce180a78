"""Copies of packages: folders with a package's name and without a package.xml."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

MARKS = ("urdf", "xacro", "robots", "meshes", "models", "launch", "worlds", "config")
"""Folders of a robot's package. It has one of them, or a xacro or URDF file."""

_OF_ZIP = re.compile(
    r"(?:-(?:main|master|trunk|dev\w*|ros\d?|v?\d[\w.]*|[0-9a-f]{7,40}|[a-z]+-devel|noetic|foxy|humble|jazzy|rolling))?"
    r"(?: ?\(\d+\))?"
)
"""The text behind the name of an archive's folder: a branch, a version, a number of the download."""


def find_copy(package: str, folders: Iterable[Path], file: Path, *, marked: bool) -> Path | None:
    """The first of `folders` that may be a copy of `package`.

    It has that name, or that name with a branch or a version behind it, as the folder of a ZIP. A folder above `file`
    may have any ending. A link does not count, nor the home folder and those above it. Of the folders beside them
    (`/etc`) only those above `file` count. With `marked` the folder must look like a robot's package, because messages
    may quote the files in it.
    """
    if package.startswith("."):
        return None
    bearing = (folder for folder in folders if _bears(folder.name, package, above=folder in file.parents))
    nearest = sorted(bearing, key=lambda folder: (folder.name != package, folder not in file.parents))
    named = (folder for folder in nearest if os.path.realpath(folder) == str(folder))
    fitting = (folder for folder in named if not is_too_wide(folder) and (folder in file.parents or _is_own(folder)))
    return next((folder for folder in fitting if not marked or _is_marked(folder)), None)


def _bears(name: str, package: str, *, above: bool) -> bool:
    rest = name[len(package) :] if name.startswith(package) else "/"
    return not rest or bool(_OF_ZIP.fullmatch(rest)) or (above and rest[0] in "-_ ")


def is_too_wide(folder: Path) -> bool:
    """Whether the folder is the home folder or one above it."""
    return _home().is_relative_to(folder)


def _is_own(folder: Path) -> bool:
    """Whether it lies deeper than the folders of the system and of other users."""
    return folder.parent != Path(folder.anchor) and folder.parent not in _home().parents


def _home() -> Path:
    return Path(os.path.realpath(os.path.expanduser("~")))


def _is_marked(folder: Path) -> bool:
    try:
        entries = list(folder.iterdir())
    except OSError:
        return False
    return any(entry.suffix in (".xacro", ".urdf") or (entry.name in MARKS and entry.is_dir()) for entry in entries)
