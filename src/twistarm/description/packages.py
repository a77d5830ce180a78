"""Where packages are: the index behind `$(find pkg)` and `package://pkg/…`, without ROS."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import InputError
from ..files import as_path, is_file

MAX_DEPTH = 4
"""How deep under a folder that the user names packages are looked for."""

MAX_PARENTS = 8
"""How many parents of the description are looked through, with their children."""

MANIFEST_BYTES = 1_000_000
"""A package.xml is a page long."""


@dataclass(frozen=True)
class PackageIndex:
    """Packages found near a description, by the `<name>` in their package.xml (folder names may differ).

    Searched in this order: the folders the user names, each parent of the description with its children,
    `<prefix>/share/*` of AMENT_PREFIX_PATH, and ROS_PACKAGE_PATH.
    """

    file: Path
    user_dirs: tuple[Path, ...] = ()
    _found: dict[str, Path | None] = field(default_factory=dict, repr=False, compare=False)
    _search: list[Iterator[tuple[str | None, Path | None]]] = field(default_factory=list, repr=False, compare=False)

    def find(self, package: str) -> Path | None:
        """The folder of `package`, or None."""
        if not self._search:
            self._search.append((package_name(folder), folder) for folder in self._folders())
        while package not in self._found:
            name, folder = next(self._search[0], (package, None))
            if name is not None:
                self._found.setdefault(name, folder)
        return self._found[package]

    def find_for_mesh(self, package: str) -> Path | None:
        """As `find`, and where no package.xml names it, a folder of that name beside the file or in a user's folder."""
        found = self.find(package)
        if found is not None:
            return found
        places = [*self.user_dirs, *list(self.file.parents)[:MAX_PARENTS]]
        candidates = [path for place in places for path in (place / package, place) if path.name == package]
        return next((path for path in candidates if path.is_dir()), None)

    def searched(self) -> str:
        """Where a package was looked for, in words."""
        places = [str(path) for path in self.user_dirs]
        places.append(f"the folders above {self.file.name}")
        places += [name for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH") if os.environ.get(name)]
        return ", ".join(places)

    def _folders(self) -> Iterator[Path]:
        for folder in self.user_dirs:
            yield from _walk(folder, MAX_DEPTH)
        for parent in list(self.file.parents)[:MAX_PARENTS]:
            yield from _walk(parent, 1)
        for prefix in _environment_paths("AMENT_PREFIX_PATH"):
            yield from _walk(prefix / "share", 1)
        for folder in _environment_paths("ROS_PACKAGE_PATH"):
            yield from _walk(folder, MAX_DEPTH)


def package_index(file: Path, user_dirs: Iterable[str | os.PathLike[str]] = ()) -> PackageIndex:
    """The index for one description; InputError for a user's folder that does not exist."""
    if isinstance(user_dirs, (str, os.PathLike)):
        user_dirs = [user_dirs]
    folders = tuple(as_path(folder).resolve() for folder in user_dirs)
    for folder in folders:
        if not folder.is_dir():
            raise InputError(f"package_dirs: {folder} is not a folder")
    return PackageIndex(file.resolve(), folders)


def package_name(folder: Path) -> str | None:
    """The `<name>` in the folder's package.xml; None without a readable one of a manifest's size."""
    manifest = folder / "package.xml"
    if not is_file(manifest):
        return None
    try:
        if manifest.stat().st_size > MANIFEST_BYTES:
            return None
        name = ET.parse(manifest, ET.XMLParser(target=_Plain())).getroot().findtext("name")
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


def _environment_paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
