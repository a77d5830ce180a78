"""Copies of packages: folders with a package's name but without package.xml."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from pathlib import Path

MARKS = ("urdf", "xacro", "robots", "meshes", "models", "launch", "worlds", "config")
"""Folders of which a package of a robot holds one, or else a xacro or URDF file."""

_OF_ZIP = re.compile(
    r"(?:-(?:main|master|trunk|dev\w*|ros\d?|v?\d[\w.]*|[0-9a-f]{7,40}|[a-z]+-devel|noetic|foxy|humble|jazzy|rolling))?"
    r"(?: ?\(\d+\))?"
)
"""What the folder of an archive has behind the name: a branch, a version, and a number where it was loaded again."""


def find_copy(package: str, folders: Iterable[Path], file: Path, *, marked: bool) -> Path | None:
    """The first of `folders` that is a copy of `package`: a real folder with that name, not a link.

    A branch or a version may follow the name, as in the folder of a ZIP; above `file`, any text may.

    The home folder and its parents never count. Beside them (`/etc`) only the folder of `file` does. `marked`: it must
    hold the usual content of robot packages, because its files may be opened and quoted.
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
    """Whether it is the home folder, or one that holds it."""
    return _home().is_relative_to(folder)


def _is_own(folder: Path) -> bool:
    """Whether it lies deeper than the folders of the system and of other people."""
    return folder.parent != Path(folder.anchor) and folder.parent not in _home().parents


def _home() -> Path:
    return Path(os.path.realpath(os.path.expanduser("~")))


def _is_marked(folder: Path) -> bool:
    try:
        entries = list(folder.iterdir())
    except OSError:
        return False
    return any(entry.suffix in (".xacro", ".urdf") or (entry.name in MARKS and entry.is_dir()) for entry in entries)
