"""Confinement of files: a xacro description may open files of its package and of packages in the index."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from pathlib import Path

from ...support.files import read_bounded
from ...support.messages import Text, package_folder
from ..document import decoded
from ..packages import SOURCES, PackageIndex, is_too_wide, package_name
from .work import Refused

MAX_BYTES = 10_000_000
"""Largest file. No description is larger, and meshes are not opened here."""

OUTSIDE = "file-outside-packages"

_PARTS = ("urdf", "xacro", "robots", "robot", "description", "model", "models")
"""Names of folders that usually lie inside the folder of an arm."""


class Confinement:
    """The folders that `file` and its includes may read from.

    These are the file's package (the nearest folder above with a package.xml), and the folders of packages that the
    index finds. A file without a package may read its folder, and the folder above if its folder is called urdf or
    the like. A folder without a package.xml counts only if the description asks for a package of its name and it looks
    like one (`PackageIndex`). The home folder and the root of the file system never count as a whole.

    Links do not open other folders, because an archive may hold any link. Links of the user's build are an exception
    (`_is_built_from`).
    """

    def __init__(self, file: Path, packages: PackageIndex) -> None:
        self._file, self._packages = _real(file), packages
        self.roots = tuple(root for root in _own_folders(self._file) if not is_too_wide(root))
        self._known: dict[Path, bool] = {}

    def read(self, name: str) -> tuple[Path, str]:
        """The real path and the text of the regular file `name`.

        Refused outside the folders, whether or not there is a file. OSError if there is none inside.
        """
        try:
            real = _real(name)
            self.require_inside(real)  # a device is not even opened
            return real, decoded(read_bounded(name, MAX_BYTES))
        except ValueError:
            raise Refused(OUTSIDE, f"{name!a} is no path", "write a path or $(find package)/…") from None
        except OSError as error:
            codes = {errno.EINVAL: "file-unreadable", errno.EFBIG: "file-unreadable"}
            if error.errno not in codes:
                raise
            remedy = "include regular files of a description"
            raise Refused(codes[error.errno], f"{name}: {error.strerror}", remedy) from error

    def entries(self, folder: str | os.PathLike[str]) -> list[str]:
        """The sorted names in a readable folder. Refused and OSError as in `read`."""
        self.require_inside(_real(folder))
        return sorted(os.listdir(folder))

    def require_inside(self, real: Path) -> None:
        """Refused if `real`, a path without links, lies outside the folders."""
        inside = real == self._file or any(real.is_relative_to(root) for root in self.roots)
        if not inside and not any(map(self._is_known, real.parents)):
            allowed = ", ".join(map(str, self.roots)) or "none"
            what = f"{real} lies outside the folders that may be read ({allowed}, and packages found by their name)"
            raise Refused(OUTSIDE, what, Text("pass {folder}", folder=package_folder("its package")))

    def _is_known(self, folder: Path) -> bool:
        """Whether the index finds a package in it, directly or through the user's build."""
        if folder not in self._known:
            name = None if is_too_wide(folder) else package_name(folder)
            found = None if name is None else self._packages.find(name)
            named = found is not None and (
                found == folder or _is_built_from(found, folder) or folder in self._sourced(str(name))
            )
            self._known[folder] = named or self._packages.is_copy(folder)
        return self._known[folder]

    def _sourced(self, package: str) -> Iterator[Path]:
        """Targets of links of the environment's packages of a name. The user has built a workspace that is sourced."""
        for found in self._packages.sourced(package):
            yield from (_real(found), _real(found / "package.xml").parent)


def _real(path: str | os.PathLike[str]) -> Path:
    """The path without links."""
    return Path(os.path.realpath(path))


def _is_built_from(installed: Path, folder: Path) -> bool:
    """Whether `folder` is the source of the installed package, in the same workspace.

    `colcon build --symlink-install` makes `install/…/share/NAME/package.xml` a link to `src/…/NAME/package.xml`. An
    archive may hold such links too, but only to files in the `src` beside them.
    """
    if _real(installed) != installed or _real(installed / "package.xml").parent != folder:
        return False
    workspace = next((parent.parent for parent in installed.parents if parent.name == "install"), None)
    if workspace is None or installed.parent.name != "share" or is_too_wide(workspace):
        return False
    sources = workspace / SOURCES
    return folder.is_relative_to(sources) and not any(part[0] == "." for part in folder.relative_to(sources).parts)


def _own_folders(file: Path) -> list[Path]:
    package = next((folder for folder in file.parents if package_name(folder) and not is_too_wide(folder)), None)
    if package is not None:
        return [package]
    return [file.parent, *([file.parent.parent] if file.parent.name in _PARTS else [])]
