"""Where packages are: the index behind `$(find pkg)` and `package://pkg/…`, without ROS."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..checks import require_names
from ..errors import InputError, shown
from ..files import as_path, is_file, read_bounded
from .copies import find_copy

MAX_DEPTH = 4
"""How deep under a folder that the user names packages are looked for."""

MAX_PARENTS = 8
"""How many parents of the description are looked through, with their children."""

MANIFEST_BYTES = 1_000_000
"""A package.xml is a page long."""

_NAME = re.compile(r"\w[\w.-]*")

SOURCES = "src"
"""Where a workspace keeps its packages."""


@dataclass(frozen=True)
class PackageIndex:
    """Packages found near a description, by the `<name>` in their package.xml (folder names may differ).

    Searched in this order: the folders the user names, each parent of the description with its children and those of
    its `src`, `<prefix>/share/*` of AMENT_PREFIX_PATH, and ROS_PACKAGE_PATH. Where no package.xml has the name, a copy
    in the first two places may bear it (`find_copy`).
    """

    file: Path
    user_dirs: tuple[Path, ...] = ()
    _copies: dict[tuple[str, bool], Path | None] = field(default_factory=dict, repr=False, compare=False)
    _found: dict[str, Path | None] = field(default_factory=dict, repr=False, compare=False)
    _near: list[Path] = field(default_factory=list, repr=False, compare=False)
    _search: list[Iterator[tuple[str | None, Path | None]]] = field(default_factory=list, repr=False, compare=False)

    def find(self, package: str) -> Path | None:
        """The folder of `package`, or None."""
        return self._by_manifest(package) or self._copy(package, marked=True)

    def find_for_mesh(self, package: str) -> Path | None:
        """As `find`, and a folder of that name whatever it holds: a mesh is drawn, it cannot be quoted."""
        return self.find(package) or self._copy(package, marked=False)

    def is_copy(self, folder: Path) -> bool:
        """Whether `find` has answered with that folder, which no package.xml names."""
        return self._copies.get((folder.name, True)) == folder

    def copies(self) -> dict[str, Path]:
        """The folders that were taken for a package by their own name alone."""
        return {package: folder for (package, _), folder in self._copies.items() if folder is not None}

    def _by_manifest(self, package: str) -> Path | None:
        if not self._search:
            self._search.append((package_name(folder), folder) for folder in self._folders())
        while package not in self._found:
            name, folder = next(self._search[0], (package, None))
            if name is not None:
                self._found.setdefault(name, folder)
        return self._found[package]

    def _copy(self, package: str, *, marked: bool) -> Path | None:
        """Asked for after every folder near was looked through for a package.xml."""
        key = package, marked
        if key not in self._copies:
            self._copies[key] = find_copy(package, self._near, self.file, marked=marked)
        return self._copies[key]

    def searched(self) -> str:
        """Where a package was looked for, in words."""
        places = [str(path) for path in self.user_dirs]
        places.append(f"the folders above {self.file.name}")
        places += [name for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH") if os.environ.get(name)]
        return ", ".join(places)

    def sourced(self, package: str) -> Iterator[Path]:
        """Every folder of `package` in the environment's, those behind another that `find` answers with too."""
        return (folder for folder in _folders_of_environment() if package_name(folder) == package)

    def _folders(self) -> Iterator[Path]:
        for folder in self._folders_near():
            self._near.append(folder)
            yield folder
        yield from _folders_of_environment()

    def _folders_near(self) -> Iterator[Path]:
        for folder in self.user_dirs:
            yield from _walk(folder, MAX_DEPTH)
        for parent in list(self.file.parents)[:MAX_PARENTS]:
            yield from _walk(parent, 1)
            yield from _children(parent / SOURCES)


def package_index(file: Path, user_dirs: Iterable[str | os.PathLike[str]] = ()) -> PackageIndex:
    """The index for one description; InputError for a user's folder that does not exist."""
    if isinstance(user_dirs, (str, os.PathLike)):
        user_dirs = [user_dirs]
    return PackageIndex(file.resolve(), tuple(_users_folder(as_path(folder)) for folder in user_dirs))


def _users_folder(folder: Path) -> Path:
    try:
        resolved = folder.resolve()
        usable = resolved.is_dir()
    except (OSError, ValueError) as error:
        raise InputError(f"package_dirs: {shown(str(folder))} is no usable path ({error})") from error
    if not usable:
        raise InputError(f"package_dirs: {resolved} is not a folder")
    return resolved


def package_names(without: object) -> tuple[str, ...]:
    """The packages to do without, one or several; InputError for what is no name of a package."""
    names = (without,) if isinstance(without, str) else require_names(without, "without")
    for name in names:
        if not _NAME.fullmatch(name):
            raise InputError(f"without takes names of packages, as in $(find NAME)/…; got {shown(name)}")
    return tuple(dict.fromkeys(names))


def package_name(folder: Path) -> str | None:
    """The `<name>` in the folder's package.xml; None without a readable one of a manifest's size."""
    manifest = folder / "package.xml"
    if not is_file(manifest):
        return None
    try:
        text = read_bounded(manifest, MANIFEST_BYTES)
        name = ET.fromstring(text, ET.XMLParser(target=_Plain())).findtext("name")
    except (ET.ParseError, OSError, ValueError, LookupError):
        return None
    return name.strip() if name else None


class _Plain(ET.TreeBuilder):
    """Elements without a document type, hence without entities."""

    def doctype(self, *_: object) -> None:
        raise ET.ParseError("a document type is not allowed")


def _walk(folder: Path, depth: int) -> Iterator[Path]:
    """`folder` and its subfolders, breadth first, hidden ones and unreadable ones left out."""
    level = [folder]
    for _ in range(depth + 1):
        yield from level
        level = [child for parent in level for child in _children(parent)]


def _children(folder: Path) -> list[Path]:
    try:
        return sorted(child for child in folder.iterdir() if not child.name.startswith(".") and child.is_dir())
    except OSError:
        return []


def _folders_of_environment() -> Iterator[Path]:
    for prefix in _environment_paths("AMENT_PREFIX_PATH"):
        yield from _walk(prefix / "share", 1)
    for folder in _environment_paths("ROS_PACKAGE_PATH"):
        yield from _walk(folder, MAX_DEPTH)


def _environment_paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
