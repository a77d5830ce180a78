"""The robot descriptions in a folder, and what is no robot on its own among them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from ..description.arm_file import read_arm_file
from ..description.findings import Finding
from ..errors import DescriptionError, InputError

DEEPEST, MOST = 12, 2000
"""Folders below the given one, and files in all, that are looked at."""

_SUFFIXES = (".urdf", ".xacro")


def descriptions_in(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Every URDF and xacro file and every arm.toml below a folder, hidden folders left out, in order.

    A file that an arm.toml names as its source is looked at through it, with its arguments. Raises InputError where
    there is none, or too many.
    """
    root = Path(folder)
    found = list(_walk(root, 0))
    if not found:
        raise InputError(f"{root}: no *.urdf, *.xacro or arm.toml in this folder or below")
    if len(found) > MOST:
        raise InputError(f"{root}: more than {MOST} descriptions; name a smaller folder")
    spoken_for = {source for path in found if path.suffix == ".toml" for source in _source(path)}
    return tuple(path for path in found if path.resolve() not in spoken_for)


def is_part(path: Path, findings: Iterable[Finding]) -> bool:
    """Whether a file was refused for holding macros only, for other files to include: xacro without links."""
    return path.suffix == ".xacro" and any(one.code == "no-robot" for one in findings)


def _walk(folder: Path, depth: int) -> Iterator[Path]:
    try:
        entries = sorted(folder.iterdir())
    except OSError:  # one that may not be opened holds nothing for us
        return
    for path in entries:
        if path.name.startswith("."):
            continue
        if path.is_dir():
            if depth < DEEPEST and not path.is_symlink():
                yield from _walk(path, depth + 1)
        elif path.name == "arm.toml" or path.suffix in _SUFFIXES:
            yield path


def _source(arm_file: Path) -> list[Path]:
    try:
        return [read_arm_file(arm_file).description.resolve()]
    except DescriptionError:  # it is told when its turn comes
        return []
