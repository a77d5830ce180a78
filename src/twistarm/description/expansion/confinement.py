"""The files that a description may read."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
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


class Confinement:
    """Reads the files of one description where its packages lie (`PackageIndex.allows`)."""

    def __init__(self, file: Path, packages: PackageIndex) -> None:
        self._file, self._packages = Path(os.path.realpath(file)), packages

    def read(self, name: str) -> tuple[Path, str]:
        """The real path and the text of the regular file `name`.

        Refused outside the folders, whether or not there is a file. OSError if there is none inside.
        """
        try:
            note_file(Path(name))
            real = Path(os.path.realpath(name))
            self.require_inside(real)  # a device is not even opened
            return real, decoded(read_bounded(real, MAX_BYTES))
        except ValueError:
            raise Refused(
                "file-outside-packages", f"{name!a} is no path", "write a path or $(find package)/…"
            ) from None
        except OSError as error:
            codes = {errno.EINVAL: "file-unreadable", errno.EFBIG: "file-unreadable"}
            if error.errno not in codes:
                raise
            remedy = "include regular files of a description"
            raise Refused(codes[error.errno], f"{name}: {error.strerror}", remedy) from error

    def entries(self, folder: str) -> list[str]:
        """The sorted names in a readable folder. Refused and OSError as in `read`."""
        self.require_inside(Path(os.path.realpath(folder)))
        return sorted(os.listdir(folder))

    def require_inside(self, real: Path) -> None:
        """Refused if `real`, a path without links, lies outside the folders."""
        if real != self._file and not self._packages.allows(real):
            what = f"{real} lies outside the folders that may be read: its own package, and those found by their name"
            remedy = Text("pass {folder}", folder=package_folder("its package"))
            raise Refused("file-outside-packages", what, remedy)


def causes(error: BaseException) -> Iterator[BaseException]:
    """The error and all that it wraps: xacro keeps the original in `.exc`, Python in `__cause__`/`__context__`."""
    seen: set[int] = set()
    stack: list[BaseException | None] = [error]
    while stack:
        current = stack.pop()
        if isinstance(current, BaseException) and id(current) not in seen:
            seen.add(id(current))
            yield current
            stack += [getattr(current, "exc", None), current.__cause__, current.__context__]
