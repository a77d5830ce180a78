"""The packages behind `$(find pkg)` and `package://pkg/…`, without ROS, and the files that a description may read."""

from __future__ import annotations

import functools
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from urllib.parse import unquote

from ..support.checks import require_names
from ..support.errors import InputError, closest, quote
from ..support.files import as_paths, is_file, read_bounded
from ..support.messages import Text, package_folder

MAX_DEPTH = 4  # Depth of the search for packages under a folder of the user.
MAX_PARENTS = 8  # Parents of the description that the search covers, with their children.
NEAR = 3  # Parents of the description that may be its package.
MANIFEST_BYTES = 100_000  # Of a package.xml. Long ones have some 10 kB.
# The folders of a workspace with its packages, with those that colcon installs, and the folder between.
SOURCES, INSTALLED, SHARE = "src", "install", "share"
# Names of folders that usually lie inside the folder of an arm.
PARTS = ("urdf", "xacro", "robots", "robot", "description", "model", "models")
# Folders of a robot's package. It has one of them, or a xacro or URDF file.
MARKS = ("urdf", "xacro", "robots", "meshes", "models", "launch", "worlds", "config")

_NAME = re.compile(r"\w[\w.-]*")  # Of a package, or of an environment variable.


@dataclass(frozen=True)
class PackageIndex:
    """Packages near a description, by the `<name>` in their package.xml (folder names may differ).

    The search goes through the user's folders, then each parent of the description. There it covers the children,
    those of `src` and the installed packages. Then follow `<prefix>/share/*` of AMENT_PREFIX_PATH, and
    ROS_PACKAGE_PATH. If no package.xml has the name, a folder of that name in the first two places may be the package;
    `copies` are the folders found so. `mesh_dirs` come last and give only meshes.
    """

    file: Path
    user_dirs: tuple[Path, ...] = ()
    mesh_dirs: tuple[Path, ...] = ()
    copies: dict[str, Path] = field(default_factory=dict, repr=False, compare=False)

    def find(self, package: str) -> Path | None:
        """The folder of `package`, or None."""
        found = self._packages_near.get(package) or self._sourced.get(package)
        return found[0] if found else self._copy(package)

    def find_for_mesh(self, package: str) -> Path | None:
        """As `find`, then in `mesh_dirs`. Meshes are only drawn, so their contents cannot leak."""
        return self.find(package) or self.in_mesh_dirs.get(package)

    def remedy(self, package: str) -> str:
        """What to do about a package that is not found."""
        near = closest(package, [*self._packages_near, *self._sourced])
        correct = f"correct the name{near}, or " if near else ""
        return Text("{correct}pass {folder}", correct=correct, folder=package_folder(package))

    def allows(self, real: Path, also: Iterable[Path] = ()) -> bool:
        """Whether the description may read the file at `real`, a path without links.

        It may read in its own package or folder, in the packages that `find` knows, and in the folders `also`. A link
        counts by its real path, because an archive may hold any link.
        """
        folders = [folder for folder in (self._own, *also) if not is_too_wide(folder)]
        own = real == Path(os.path.realpath(self.file)) or any(real.is_relative_to(folder) for folder in folders)
        return own or any(folder in self._readable or folder in self.copies.values() for folder in real.parents)

    @functools.cached_property
    def _own(self) -> Path:
        """The description's package, else its folder, or the folder above if its folder is called urdf or so."""
        home = home_of(Path(os.path.realpath(self.file)))
        inside = home.name in PARTS and package_name(home) is None and not is_too_wide(home.parent)
        return home.parent if inside else home

    @functools.cached_property
    def _readable(self) -> set[Path]:
        """The folders of all packages that have a name, and where links of a build lead from those of the environment.

        `colcon build --symlink-install` makes `share/NAME/package.xml` a link to the sources. A stranger's archive may
        hold such links too, so those near the description do not count.
        """
        folders = {*chain(*self._packages_near.values())}
        for folder in chain(*self._sourced.values()):
            folders |= {Path(os.path.realpath(folder)), Path(os.path.realpath(folder / "package.xml")).parent}
        return {folder for folder in folders if not is_too_wide(folder)}

    def _copy(self, package: str) -> Path | None:
        """The folder of that name that looks like a robot's package, one above the description first.

        A link does not count, nor the home folder and those above it. Of the folders beside them (`/etc`) only those
        above the description count.
        """
        above = self.file.parents
        own = [
            folder
            for folder in self._folders_near
            if folder.name == package and package[:1] != "." and os.path.realpath(folder) == str(folder)
            if not is_too_wide(folder) and _is_marked(folder)
            if folder in above or not (folder.parent == Path(folder.anchor) or folder.parent in _home().parents)
        ]
        found = min(own, key=lambda folder: folder not in above, default=None)
        return None if found is None else self.copies.setdefault(package, found)

    @functools.cached_property
    def _folders_near(self) -> list[Path]:
        folders = [below for folder in self.user_dirs for below in _through(folder, MAX_DEPTH)]
        for parent in list(self.file.parents)[:MAX_PARENTS]:
            folders += [*_through(parent, 1), *_children(parent / SOURCES), *_installed(parent / INSTALLED)]
            if parent.name == SHARE:
                folders += _installed(parent.parent.parent)
        return folders

    @functools.cached_property
    def _packages_near(self) -> dict[str, list[Path]]:
        return _by_name(self._folders_near)

    @functools.cached_property
    def _sourced(self) -> dict[str, list[Path]]:
        """The packages of the environment."""
        ament, ros = (
            [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
            for variable in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH")
        )
        folders = [below for prefix in ament for below in _through(prefix / SHARE, 1)]
        return _by_name([*folders, *(below for folder in ros for below in _through(folder, MAX_DEPTH))])

    @functools.cached_property
    def in_mesh_dirs(self) -> dict[str, Path]:
        """Packages in `mesh_dirs` by the name in their package.xml, then other folders by their names."""
        folders = [folder for top in self.mesh_dirs for folder in _through(top, MAX_DEPTH)]
        named = {folder.name: folder for folder in reversed(folders)}
        return named | {name: found[0] for name, found in _by_name(folders).items()}


def package_index(
    file: Path, user_dirs: Iterable[str | os.PathLike[str]] = (), mesh_dirs: Iterable[str | os.PathLike[str]] = ()
) -> PackageIndex:
    """The index for one description. InputError for a user's folder that does not exist."""
    given = [as_paths(dirs, "package_dirs") for dirs in (user_dirs, mesh_dirs)]
    for folder in chain(*given):
        if not os.path.isdir(folder):
            raise InputError(f"package_dirs: {quote(str(folder))} is not a folder; give one that holds packages")
    users, meshes = (tuple(folder.resolve() for folder in folders) for folders in given)
    return PackageIndex(file.resolve(), users, meshes)


def checked_names(given: object, argument: str) -> tuple[str, ...]:
    """The names of an `argument`, from one name or several, each once. InputError for another text."""
    names = (given,) if isinstance(given, str) else require_names(given, argument)
    for name in names:
        if not _NAME.fullmatch(name):
            raise InputError(f"{argument} takes names alone, without paths and values; got {quote(name)}")
    return tuple(dict.fromkeys(names))


def home_of(file: Path) -> Path:
    """The package that holds a file, else its folder."""
    return next((folder for folder in file.parents if package_name(folder) and not is_too_wide(folder)), file.parent)


def package_name(folder: Path) -> str | None:
    """The `<name>` in the folder's package.xml.

    None without a readable one, and for a file with a document type, which may hold entities.
    """
    try:
        data = read_bounded(folder / "package.xml", MANIFEST_BYTES)
        if b"<!DOCTYPE" in data.replace(b"\0", b""):
            return None
        return (ET.fromstring(data).findtext("{*}name") or "").strip() or None
    except (ET.ParseError, OSError, ValueError, LookupError):
        return None


def is_too_wide(folder: Path) -> bool:
    """Whether the folder is the home folder or one above it."""
    return _home().is_relative_to(folder)


def _home() -> Path:
    return Path(os.path.realpath(os.path.expanduser("~")))


def _is_marked(folder: Path) -> bool:
    """Whether it looks like a robot's package: messages may quote its files."""
    marks = (os.path.isdir(folder / mark) for mark in MARKS)
    return any(marks) or any(any(folder.glob(pattern)) for pattern in ("*.xacro", "*.urdf"))


def _by_name(folders: Iterable[Path]) -> dict[str, list[Path]]:
    """The packages among folders, by the name in their package.xml."""
    found: dict[str, list[Path]] = {}
    for folder in folders:
        if name := package_name(folder):
            found.setdefault(name, []).append(folder)
    return found


def _through(folder: Path, depth: int) -> Iterator[Path]:
    """`folder` and the folders below, `depth` levels deep, each level by its names. Links are followed."""
    level = [folder]
    yield folder
    for _ in range(depth):
        level = [child for parent in level for child in _children(parent)]
        yield from level


def _children(folder: Path) -> list[Path]:
    """The visible folders in a folder, by their names. None in an unreadable one."""
    try:
        with os.scandir(folder) as inside:
            visible = [entry for entry in inside if not entry.name.startswith(".")]
            names = sorted(entry.name for entry in visible if entry.is_symlink() or entry.is_dir())
    except OSError:
        return []
    return [folder / name for name in names if os.path.isdir(folder / name)]


def _installed(folder: Path) -> Iterator[Path]:
    """Packages that colcon has installed there: `NAME/share/NAME`, or all in `share`."""
    yield from filter(os.path.isdir, (prefix / SHARE / prefix.name for prefix in _children(folder)))
    yield from _children(folder / SHARE)


_IN_PACKAGE = re.compile(r"(?:(?:package|model)://([^/\\]*)|\$\(find\s+([^)\s]+)\))[/\\]*")


def resolve_uri(uri: str, packages: PackageIndex) -> Path | None:
    """The mesh file of a URI: `package://`, `model://`, `file://`, `$(find p)/…`, absolute, or beside the file.

    Without a package's name, `package://` begins at the file's folder, at those above, or at the caller's folders.
    None if there is no such file, or if it really lies outside the packages and the caller's folders.
    """
    _, folders, files = _places(uri, packages)
    reals = (Path(os.path.realpath(file)) for file in files)
    given = (*folders, *packages.user_dirs)
    own = packages.file.parent
    return next((real for real in reals if real.is_relative_to(own) or packages.allows(real, given)), None)


def why_missing(uri: str, packages: PackageIndex) -> tuple[str, str]:
    """Why there is no file at a URI, and the remedy. Both are equal for files with one remedy."""
    package, folders, files = _places(uri, packages)
    if not folders:
        return f"package {package!r} not found", packages.remedy(package)
    if files:
        remedy = Text("pass {folder}", folder=package_folder("them"))
        return "they lie outside the description's package", remedy
    where = f"in package {package!r}" if package else "where the description looks for them"
    return f"there is no such file {where}", "correct the paths, or put the files there"


def _places(uri: str, packages: PackageIndex) -> tuple[str, list[Path], list[Path]]:
    """The package that a URI names, the folders in which its path may begin, and the files that are there.

    `package://./x` and `package:///x` name no package. The path may have %20 for a space, and backslashes.
    """
    found = _IN_PACKAGE.match(uri.strip())
    package = (found[1] or found[2] or "") if found else ""
    package = "" if package == "." else package
    path = uri.strip()[found.end() :] if found else re.sub(r"^file://(localhost(?=/))?", "", uri.strip())
    if package:
        folders = [folder for folder in [packages.find_for_mesh(package)] if folder is not None]
    else:
        parents = packages.file.parents
        folders = [*parents[:NEAR], *packages.user_dirs] if found else [parents[0]]
    files = (folder / spelling for folder in folders for spelling in (path, unquote(path).replace("\\", "/")))
    return package, folders, [file for file in files if is_file(file)]
