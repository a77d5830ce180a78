"""Files beside a description, in the places of MoveIt and ROS packages."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from ...support.errors import DescriptionError, listed
from ...support.files import is_file
from ...support.messages import Argument, Text
from ..findings import Finding, Place, finding
from ..semantics import Semantics
from ..tree import Description
from .srdf import read_srdf

FOLDERS = ("config", "srdf")
"""Folders of packages with such files, in the description's folder or one above."""

MOVEIT = "*_moveit_config"
"""The MoveIt package of the same workspace: one or two folders above the description's."""


MOST_BYTES, FILE_BYTES = 3_000_000, 10_000
"""Most bytes of SRDFs to read unasked, and the least that each counts."""


def files_beside(file: Path, pattern: str) -> tuple[Path, ...]:
    """Files that match `pattern` (`*.srdf`) in the description's folder and its package's folders for them.

    Links are left out, because their files lie elsewhere.
    """
    found = (path for folder in _folders(file) for path in _glob(folder, pattern))
    return tuple(path for path in dict.fromkeys(found) if is_file(path) and path.resolve() == path)


def srdf_beside(description: Description) -> tuple[Semantics | None, tuple[Finding, ...]]:
    """The one SRDF beside the description for a robot of its name, and findings.

    None of several is used. SRDFs in xacro are programs, so they are not read unasked.
    """
    if description.path is None:
        return None, ()
    matching: list[Semantics] = []
    noted: list[Finding] = []
    left = MOST_BYTES
    every = files_beside(description.path, "*.srdf")
    for i, path in enumerate(every):
        left -= max(FILE_BYTES, path.stat().st_size)
        if left < 0:
            what = f"{len(every)} SRDFs are beside the description; {len(every) - i} of them are not looked at"
            remedy = Text("name the right one as {srdf}", srdf=Argument("srdf"))
            noted.append(finding("companion-doubtful", Place(path.name), what, remedy))
            break
        try:
            semantics = read_srdf(path)
        except DescriptionError as error:
            remedy = Text("correct it, or name another as {srdf}", srdf=Argument("srdf"))
            noted.append(finding("companion-doubtful", Place(path.name), error.message, remedy))
            continue
        if semantics.name == description.name:
            matching.append(semantics)
    if len(matching) <= 1:
        return next(iter(matching), None), tuple(noted)
    files = listed(path_from(description, semantics.path) for semantics in matching)
    what = f"several SRDFs are for a robot {description.name!r}: {files}; none is used"
    remedy = Text("name one as {srdf}", srdf=Argument("srdf"))
    return None, (*noted, finding("companion-not-used", description.place(), what, remedy))


def path_from(description: Description, file: Path) -> str:
    """The way from the description's folder to a file: `../config/arm.srdf`."""
    return os.path.relpath(file.resolve(), description.path.parent) if description.path else str(file)


def _folders(file: Path) -> Iterator[Path]:
    here = file.resolve().parent
    yield here
    for parent in (here, here.parent):
        yield from (parent / name for name in FOLDERS)
    for workspace in (here.parent, here.parent.parent):
        for package in _glob(workspace, MOVEIT):
            yield from (package / name for name in FOLDERS)


def _glob(folder: Path, pattern: str) -> list[Path]:
    try:
        return sorted(folder.glob(pattern))
    except OSError:
        return []
