"""Which files a xacro description may open: those of its own package and of the packages that the index finds."""

from __future__ import annotations

import os
import stat
from dataclasses import dataclass, field
from pathlib import Path

from ..copies import is_too_wide
from ..packages import PackageIndex, package_name
from .work import Refused

MAX_BYTES = 10_000_000
"""No hand writes a larger description; a scan's mesh is not opened here."""

OUTSIDE = "file-outside-packages"

_PARTS = ("urdf", "xacro", "robots", "robot", "description", "model", "models")
"""Folders that usually stand inside the folder of an arm, which is then its tree."""


@dataclass(frozen=True)
class Confinement:
    """The folders that `file` and whatever it includes may read from, links followed before anything is decided.

    The file's own package (the nearest folder above with a package.xml), or without one its folder and, where that is
    called urdf or the like, the one above; and the very folders in which the index finds packages, those in
    `package_dirs` among them. A folder without a package.xml is one only where the description asks for a package of
    its name and it looks like one (`PackageIndex`). Never the home folder or the root of the file system as a whole.
    """

    file: Path
    packages: PackageIndex
    roots: tuple[Path, ...] = ()
    _known: dict[Path, bool] = field(default_factory=dict, repr=False, compare=False)

    def admit(self, name: str) -> Path:
        """The regular file that `name` stands for; Refused outside the roots, OSError where there is none."""
        try:
            real = Path(os.path.realpath(name))
            status = real.stat()
        except ValueError:
            raise Refused(OUTSIDE, f"{name!a} is no path", "write a path or $(find package)/…") from None
        self.require_inside(real)
        if not stat.S_ISREG(status.st_mode):
            raise Refused("file-unreadable", f"{name} is no regular file", "include files, not folders or devices")
        if status.st_size > MAX_BYTES:
            what = f"{name} has {status.st_size / 1e6:.0f} MB; at most {MAX_BYTES / 1e6:.0f} MB are read"
            raise Refused("file-too-large", what, "is it a xacro or YAML file?")
        return real

    def require_inside(self, real: Path) -> None:
        """Refused where `real`, a path without links, lies in none of the folders."""
        inside = real == self.file or any(real.is_relative_to(root) for root in self.roots)
        if not inside and not any(map(self._is_known, real.parents)):
            allowed = ", ".join(map(str, self.roots)) or "none"
            what = f"{real} lies outside the folders that may be read ({allowed}, and packages found by their name)"
            raise Refused(OUTSIDE, what, "pass package_dirs=[folder that holds its package]")

    def _is_known(self, folder: Path) -> bool:
        """Whether it is where the index finds a package, be it there or through the links of a workspace."""
        if folder not in self._known:
            name = None if is_too_wide(folder) else package_name(folder)
            found = None if name is None else self.packages.find(name)
            named = found is not None and folder in _real_folders(found)
            self._known[folder] = named or self.packages.is_copy(folder)
        return self._known[folder]


def confinement(file: Path, packages: PackageIndex) -> Confinement:
    """What `file` may open, given the packages that the index finds."""
    real = Path(os.path.realpath(file))
    return Confinement(real, packages, tuple(root for root in _own_folders(real) if not is_too_wide(root)))


def _real_folders(package: Path) -> tuple[Path, ...]:
    """The package's folder, and where its manifest lies: `colcon build --symlink-install` links each file by itself."""
    return Path(os.path.realpath(package)), Path(os.path.realpath(package / "package.xml")).parent


def _own_folders(file: Path) -> list[Path]:
    package = next((folder for folder in file.parents if package_name(folder) and not is_too_wide(folder)), None)
    if package is not None:
        return [package]
    return [file.parent, *([file.parent.parent] if file.parent.name in _PARTS else [])]
