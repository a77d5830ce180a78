"""The packages behind `$(find pkg)` and `package://pkg/…`, without ROS, and the files that a description may read."""

from __future__ import annotations

import functools
import io
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..support.checks import require_names
from ..support.errors import InputError, shown
from ..support.files import as_path, is_file, open_regular

MAX_DEPTH = 4
"""Depth of the search for packages under a folder of the user."""

MAX_PARENTS = 8
"""Parents of the description that the search covers, with their children."""

NEAR = 3
"""Parents of the description that may be its package."""

MANIFEST_BYTES = 16_384
"""Bytes read of a package.xml. The name is near the head, behind a licence at most."""

SOURCES, INSTALLED, SHARE = "src", "install", "share"
"""The folders of a workspace with its packages, with those that colcon installs, and the folder between."""

PARTS = ("urdf", "xacro", "robots", "robot", "description", "model", "models")
"""Names of folders that usually lie inside the folder of an arm."""

MARKS = ("urdf", "xacro", "robots", "meshes", "models", "launch", "worlds", "config")
"""Folders of a robot's package. It has one of them, or a xacro or URDF file."""

_NAME = re.compile(r"\w[\w.-]*")
_VARIABLE = re.compile(r"[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class PackageIndex:
    """Packages near a description, by the `<name>` in their package.xml (folder names may differ).

    The search goes through the user's folders, then each parent of the description. There it covers the children,
    those of `src` and the installed packages. Then follow `<prefix>/share/*` of AMENT_PREFIX_PATH, and
    ROS_PACKAGE_PATH. If no package.xml has the name, a folder of that name in the first two places may be the package.
    `mesh_dirs` come last and give only meshes.
    """

    file: Path
    user_dirs: tuple[Path, ...] = ()
    mesh_dirs: tuple[Path, ...] = ()
    _copies: dict[tuple[str, bool], Path | None] = field(default_factory=dict, repr=False, compare=False)
    _found: dict[str, Path] = field(default_factory=dict, repr=False, compare=False)
    _search: list[Iterator[Path]] = field(default_factory=list, repr=False, compare=False)
    _allowed: dict[Path, bool] = field(default_factory=dict, repr=False, compare=False)

    def find(self, package: str) -> Path | None:
        """The folder of `package`, or None."""
        return self._by_manifest(package) or self._copy(package, marked=True)

    def find_for_mesh(self, package: str) -> Path | None:
        """As `find`, or any folder of that name. Meshes are only drawn, so their contents cannot leak."""
        return self.find(package) or self._copy(package, marked=False) or self.find_for_mesh_alone(package)

    def find_for_mesh_alone(self, package: str) -> Path | None:
        """The folder of `package` in `mesh_dirs`, or None. No text is read there."""
        return self._in_mesh_dirs.get(package)

    def names(self) -> list[str]:
        """The names of all packages that can be found."""
        self._by_manifest("")
        return list(self._found)

    def copies(self) -> dict[str, Path]:
        """The folders taken for a package only by their name."""
        return {package: folder for (package, _), folder in self._copies.items() if folder is not None}

    @property
    def near(self) -> tuple[Path, ...]:
        """Folders in which a mesh without a package's name may lie: those above the description, and the user's."""
        return (*list(self.file.parents)[:NEAR], *self.user_dirs)

    def searched(self) -> str:
        """The places of the search, in words."""
        places = [str(path) for path in (*self.user_dirs, *self.mesh_dirs)]
        places.append(f"the folders above {self.file.name}")
        places += [name for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH") if os.environ.get(name)]
        return ", ".join(places)

    def allows(self, real: Path) -> bool:
        """Whether the description may read the file at `real`, a path without links.

        It may read in its own package or folder, and in the packages that `find` knows. A link counts by its real
        path, because an archive may hold any link. Links of the user's build lead on: to the sources in the `src` of
        the workspace that installs the package, and to the sources of a package in the environment.
        """
        return any(real.is_relative_to(root) for root in self._own) or any(map(self._is_package, real.parents))

    @functools.cached_property
    def _own(self) -> list[Path]:
        """The description's package, else its folder, and the folder above if its folder is called urdf or so."""
        file = Path(os.path.realpath(self.file))
        package = next((folder for folder in file.parents if package_name(folder) and not is_too_wide(folder)), None)
        folder = package or (file.parent.parent if file.parent.name in PARTS else file.parent)
        return [each for each in {folder, package or file.parent} if not is_too_wide(each)]

    def _is_package(self, folder: Path) -> bool:
        if folder not in self._allowed:
            name = None if is_too_wide(folder) else package_name(folder)
            found = None if name is None else self.find(name)
            named = found is not None and (
                found == folder or _is_built_from(found, folder) or folder in self._sourced(str(name))
            )
            self._allowed[folder] = named or any(made == folder for (_, read), made in self._copies.items() if read)
        return self._allowed[folder]

    def _sourced(self, package: str) -> Iterator[Path]:
        """Real folders of the environment's packages of a name, and of their package.xml."""
        for found in self._folders_of_environment():
            if package_name(found) == package:
                yield from (Path(os.path.realpath(found)), Path(os.path.realpath(found / "package.xml")).parent)

    def _by_manifest(self, package: str) -> Path | None:
        if not self._search:
            self._search.append(self._folders())
        while package not in self._found:
            folder = next(self._search[0], None)
            if folder is None:
                return None
            if name := package_name(folder):
                self._found.setdefault(name, folder)
        return self._found[package]

    def _copy(self, package: str, *, marked: bool) -> Path | None:
        """The first folder of that name, above the description if there is one. `marked`: it looks like a package.

        A link does not count, nor the home folder and those above it. Of the folders beside them (`/etc`) only those
        above the description count.
        """
        if (package, marked) not in self._copies:
            above = self.file.parents
            named = [folder for folder in self._folders_near if folder.name == package and package[:1] != "."]
            own = [
                folder
                for folder in sorted(named, key=lambda folder: folder not in above)
                if os.path.realpath(folder) == str(folder) and not is_too_wide(folder)
                if folder in above or not (folder.parent == Path(folder.anchor) or folder.parent in _home().parents)
            ]
            found = next((folder for folder in own if not marked or _is_marked(folder)), None)
            self._copies[package, marked] = found
        return self._copies[package, marked]

    def _folders(self) -> Iterator[Path]:
        yield from self._folders_near
        yield from self._folders_of_environment()

    @functools.cached_property
    def _folders_near(self) -> list[Path]:
        folders = [below for folder in self.user_dirs for below in _through(folder, MAX_DEPTH)]
        for parent in list(self.file.parents)[:MAX_PARENTS]:
            folders += [*_through(parent, 1), *_children(parent / SOURCES), *_installed(parent / INSTALLED)]
            if parent.name == SHARE:
                folders += _installed(parent.parent.parent)
        return folders

    def _folders_of_environment(self) -> Iterator[Path]:
        for prefix in _environment_paths("AMENT_PREFIX_PATH"):
            yield from _through(prefix / SHARE, 1)
        for folder in _environment_paths("ROS_PACKAGE_PATH"):
            yield from _through(folder, MAX_DEPTH)

    @functools.cached_property
    def _in_mesh_dirs(self) -> dict[str, Path]:
        """Packages by the name in their package.xml, then other folders by their names."""
        folders = [folder for top in self.mesh_dirs for folder in _through(top, MAX_DEPTH)]
        named = [(name, folder) for folder in folders if (name := package_name(folder))]
        return dict(reversed([*named, *((folder.name, folder) for folder in folders)]))


def package_index(
    file: Path, user_dirs: Iterable[str | os.PathLike[str]] = (), mesh_dirs: Iterable[str | os.PathLike[str]] = ()
) -> PackageIndex:
    """The index for one description. InputError for a user's folder that does not exist."""
    if isinstance(user_dirs, (str, os.PathLike)):
        user_dirs = [user_dirs]
    users, meshes = (tuple(_users_folder(as_path(folder)) for folder in dirs) for dirs in (user_dirs, mesh_dirs))
    return PackageIndex(file.resolve(), users, meshes)


def _users_folder(folder: Path) -> Path:
    try:
        resolved = folder.resolve()
        usable = resolved.is_dir()
    except (OSError, ValueError, RuntimeError) as error:  # the last for links in a circle, before Python 3.13
        raise InputError(f"package_dirs: {shown(str(folder))} is no usable path ({error})") from error
    if not usable:
        raise InputError(f"package_dirs: {resolved} is not a folder")
    return resolved


def package_names(ignore_packages: object) -> tuple[str, ...]:
    """The packages to do without, from one name or several. InputError for what is not a package name."""
    return _names(ignore_packages, "ignore_packages", _NAME, "names of packages, as in $(find NAME)/…")


def is_package_name(name: str) -> bool:
    """Whether a package may have that name: a word, not a path."""
    return _NAME.fullmatch(name) is not None


def variable_names(env_vars: object) -> tuple[str, ...]:
    """The environment variables that a file may read, from one name or several. InputError for another text."""
    return _names(env_vars, "env_vars", _VARIABLE, "names of environment variables, without their values")


def _names(given: object, argument: str, pattern: re.Pattern[str], wanted: str) -> tuple[str, ...]:
    names = (given,) if isinstance(given, str) else require_names(given, argument)
    for name in names:
        if not pattern.fullmatch(name):
            raise InputError(f"{argument} takes {wanted}; got {shown(name)}")
    return tuple(dict.fromkeys(names))


def package_name(folder: Path) -> str | None:
    """The first `<name>` in the root of the folder's package.xml.

    None without a readable one near its head, and for a file with a document type, which may hold entities.
    """
    manifest = folder / "package.xml"
    if not is_file(manifest):
        return None
    try:
        with open_regular(manifest) as file:
            head = file.read(MANIFEST_BYTES)
        if b"<!DOCTYPE" in head.replace(b"\0", b""):
            return None
        depth = 0
        for event, element in ET.iterparse(io.BytesIO(head), ("start", "end")):
            depth += 1 if event == "start" else -1
            if (event, depth, element.tag.rpartition("}")[2]) == ("end", 1, "name"):
                return (element.text or "").strip() or None
    except (ET.ParseError, OSError, ValueError, LookupError):
        pass
    return None


def is_too_wide(folder: Path) -> bool:
    """Whether the folder is the home folder or one above it."""
    return _home().is_relative_to(folder)


def _home() -> Path:
    return Path(os.path.realpath(os.path.expanduser("~")))


def _is_marked(folder: Path) -> bool:
    """Whether it looks like a robot's package, whose files messages may quote."""
    try:
        entries = list(folder.iterdir())
    except OSError:
        return False
    return any(entry.suffix in (".xacro", ".urdf") or (entry.name in MARKS and entry.is_dir()) for entry in entries)


def _is_built_from(installed: Path, folder: Path) -> bool:
    """Whether `folder` is the source of the installed package, in the same workspace.

    `colcon build --symlink-install` makes `install/…/share/NAME/package.xml` a link to `src/…/NAME/package.xml`. An
    archive may hold such links too, but only to files in the `src` beside them.
    """
    if Path(os.path.realpath(installed)) != installed or os.path.realpath(installed / "package.xml") != str(
        folder / "package.xml"
    ):
        return False
    workspace = next((parent.parent for parent in installed.parents if parent.name == INSTALLED), None)
    if workspace is None or installed.parent.name != SHARE or is_too_wide(workspace):
        return False
    sources = workspace / SOURCES
    return folder.is_relative_to(sources) and not any(part[0] == "." for part in folder.relative_to(sources).parts)


def _through(folder: Path, depth: int) -> Iterator[Path]:
    """`folder` and the folders below, `depth` levels deep, each level by its names. Links are followed once."""
    level, seen = [folder], {os.path.realpath(folder)}
    yield folder
    for _ in range(depth):
        below = [child for parent in level for child in _children(parent)]
        level = []
        for child in below:
            real = os.path.realpath(child)
            if real not in seen or real == str(child):
                seen.add(real)
                level.append(child)
        yield from level


def _children(folder: Path) -> list[Path]:
    """The visible folders in a folder, by their names. None in an unreadable one."""
    try:
        with os.scandir(folder) as inside:
            return [folder / name for name in sorted(each.name for each in inside if _is_visible_folder(each))]
    except OSError:
        return []


def _is_visible_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return not entry.name.startswith(".") and entry.is_dir()
    except OSError:
        return False


def _installed(folder: Path) -> Iterator[Path]:
    """Packages that colcon has installed there: `NAME/share/NAME`, or all in `share`."""
    yield from filter(os.path.isdir, (prefix / SHARE / prefix.name for prefix in _children(folder)))
    yield from _children(folder / SHARE)


def _environment_paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]
