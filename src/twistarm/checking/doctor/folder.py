"""The robot descriptions in a folder, without files that only serve others."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from ...description.companions.arm_file import read_arm_file
from ...description.document import read_text
from ...description.findings import Finding
from ...description.urdf import may_be_mjcf
from ...support.errors import InputError, TwistarmError

MOST_ENTRIES = 100_000
"""Of files and folders of any name: a workspace with its builds has some ten thousand."""

_SUFFIXES = (".urdf", ".xacro")

_MOST_BYTES = 1_000_000
"""Of an MJCF that is found unasked. XML files of other kinds stand beside it."""


def descriptions_in(folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Each URDF, xacro file, MJCF and arm.toml below a folder in order, without hidden folders.

    Names that are no file, such as a link to itself, are reported in their turn. A source of an arm.toml is examined
    through it, with its arguments. Raises InputError for none or too many.
    """
    root = Path(folder)
    found = sorted(_walk(root))
    if not found:
        raise InputError(f"{root}: no *.urdf, *.xacro, MJCF or arm.toml in this folder or below")
    spoken_for = {source for path in found if path.suffix == ".toml" for source in _source(path)}
    return tuple(path for path in found if os.path.realpath(path) not in spoken_for)


def is_part(path: Path, findings: Iterable[Finding]) -> bool:
    """Whether a file was refused because it holds only macros for other files."""
    return path.suffix == ".xacro" and any(one.code == "no-robot" for one in findings)


def _walk(root: Path) -> Iterator[Path]:
    """Walk the folders, without links and unreadable ones."""
    left = MOST_ENTRIES
    for folder, folders, files in os.walk(root):
        left -= len(folders) + len(files)
        if left < 0:
            raise InputError(f"{root}: more than {MOST_ENTRIES:,} files and folders below; name a smaller folder")
        here = Path(folder)
        folders[:] = [name for name in folders if not name.startswith(".")]
        for name in files:
            if not name.startswith(".") and (name == "arm.toml" or name.endswith(_SUFFIXES) or _is_mjcf(here / name)):
                yield here / name


def _is_mjcf(path: Path) -> bool:
    try:
        return path.suffix == ".xml" and may_be_mjcf(read_text(path, _MOST_BYTES))
    except TwistarmError:
        return False


def _source(arm_file: Path) -> list[str]:
    try:
        return [os.path.realpath(read_arm_file(arm_file).description)]
    except TwistarmError:  # it is told when its turn comes
        return []
