"""The files that a description may read."""

from __future__ import annotations

import errno
import os
from pathlib import Path

from ...support.files import read_bounded
from ...support.messages import Text, package_folder
from ..document import decoded, note_file
from ..packages import PackageIndex

MAX_BYTES = 10_000_000
"""Largest file. No description is larger, and meshes are not opened here."""


class Refused(Exception):  # noqa: N818 - it is no error yet: its place is not known here
    """What a description may not do."""

    def __init__(self, code: str, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.code, self.what, self.remedy = code, what, remedy


def read_inside(name: str, packages: PackageIndex) -> tuple[Path, str]:
    """The real path and the text of the regular file `name`.

    Refused outside the folders, whether or not there is a file. OSError if there is none inside.
    """
    try:
        note_file(Path(name))
        real = real_inside(name, packages)  # a device is not even opened
        return real, decoded(read_bounded(real, MAX_BYTES))
    except ValueError:
        raise Refused("file-outside-packages", f"{name!a} is no path", "write a path or $(find package)/…") from None
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EFBIG):
            raise
        what, remedy = f"{name}: {error.strerror}", "include regular files of a description"
        raise Refused("file-unreadable", what, remedy) from error


def real_inside(name: str | Path, packages: PackageIndex) -> Path:
    """The path without links. Refused if it lies outside the folders."""
    real = Path(os.path.realpath(name))
    if not packages.allows(real):
        what = f"{real} lies outside the folders that may be read: its own package, and those found by their name"
        raise Refused("file-outside-packages", what, Text("pass {folder}", folder=package_folder("its package")))
    return real
