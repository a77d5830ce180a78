"""The package index behind `$(find pkg)` and `package://pkg/…`, without ROS, and copies of packages."""

from __future__ import annotations

import functools
import io
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Iterator
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

MAX_FOLDERS = 20_000
"""Most folders of one search. The user's folders, those near the description and those of ROS's variables count apart.
Ubuntu's ROS with all its tools has some 400 packages. So many folders take a second."""

ENTRIES_PER_FOLDER = 20
"""Entries that take as long as one folder."""

_NAME = re.compile(r"\w[\w.-]*")
_VARIABLE = re.compile(r"[A-Za-z_]\w*", re.ASCII)

SOURCES = "src"
"""The folder of a workspace with its packages."""

INSTALLED, SHARE = "install", "share"
"""The folder where colcon installs them, and the folder between."""

MARKS = ("urdf", "xacro", "robots", "meshes", "models", "launch", "worlds", "config")
"""Folders of a robot's package. It has one of them, or a xacro or URDF file."""

_OF_ZIP = re.compile(
    r"(?:-(?:main|master|trunk|dev\w*|ros\d?|v?\d[\w.]*|[0-9a-f]{7,40}|[a-z]+-devel|noetic|foxy|humble|jazzy|rolling))?"
    r"(?: ?\(\d+\))?"
)
"""The text behind the name of an archive's folder: a branch, a version, a number of the download."""


@dataclass(frozen=True)
class PackageIndex:
    """Packages near a description, by the `<name>` in their package.xml (folder names may differ).

    The search goes through the user's folders, then each parent of the description. There it covers the children,
    those of `src` and the installed packages. Then follow `<prefix>/share/*` of AMENT_PREFIX_PATH, and
    ROS_PACKAGE_PATH. If no package.xml has the name, a copy in the first two places may have it (`find_copy`).
    `mesh_dirs` come last and give only meshes.
    """

    file: Path
    user_dirs: tuple[Path, ...] = ()
    mesh_dirs: tuple[Path, ...] = ()
    _copies: dict[tuple[str, bool], Path | None] = field(default_factory=dict, repr=False, compare=False)
    _found: dict[str, Path | None] = field(default_factory=dict, repr=False, compare=False)
    _by_name: dict[str, list[Path]] = field(default_factory=dict, repr=False, compare=False)
    _unseen: dict[str, None] = field(default_factory=dict, repr=False, compare=False)
    _search: list[Iterator[tuple[str | None, Path | None]]] = field(default_factory=list, repr=False, compare=False)

    def find(self, package: str) -> Path | None:
        """The folder of `package`, or None."""
        return self._by_manifest(package) or self._copy(package, marked=True)

    def find_for_mesh(self, package: str) -> Path | None:
        """As `find`, or any folder of that name. Meshes are only drawn, so their contents cannot leak."""
        return self.find(package) or self._copy(package, marked=False) or self.find_for_mesh_alone(package)

    def find_for_mesh_alone(self, package: str) -> Path | None:
        """The folder of `package` in `mesh_dirs`, or None. No text is read there."""
        return self._in_mesh_dirs.get(package)

    @functools.cached_property
    def _in_mesh_dirs(self) -> dict[str, Path]:
        """Packages by the name in their package.xml, then other folders by their names."""
        walk = self._walk("package_dirs")
        folders = [folder for top in self.mesh_dirs for folder in walk.through(top, MAX_DEPTH)]
        named = [(name, folder) for folder in folders if (name := package_name(folder))]
        return dict(reversed([*named, *((folder.name, folder) for folder in folders)]))

    def is_copy(self, folder: Path) -> bool:
        """Whether `find` has returned that folder, which has no package.xml."""
        return any(found == folder for (_, marked), found in self._copies.items() if marked)

    def names(self) -> list[str]:
        """The names of all packages that can be found."""
        self._by_manifest("")
        return [name for name, folder in self._found.items() if folder is not None]

    def copies(self) -> dict[str, Path]:
        """The folders taken for a package only by their name."""
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
        """A copy of the package. Call it after `_by_manifest` has searched all near folders."""
        key = package, marked
        if key not in self._copies:
            folders = [folder for name, those in self._by_name.items() if name.startswith(package) for folder in those]
            self._copies[key] = find_copy(package, folders, self.file, marked=marked)
        return self._copies[key]

    @property
    def near(self) -> tuple[Path, ...]:
        """Folders that may be packages under another name: those above the description, and the user's."""
        return (*list(self.file.parents)[:NEAR], *self.user_dirs)

    def searched(self) -> str:
        """The places of the search, in words."""
        places = [str(path) for path in (*self.user_dirs, *self.mesh_dirs)]
        places.append(f"the folders above {self.file.name}")
        places += [name for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH") if os.environ.get(name)]
        return ", ".join(places) + "".join(self._unseen)

    def sourced(self, package: str) -> Iterator[Path]:
        """Every folder of `package` in the environment, also those that `find` does not reach."""
        return (folder for folder in self._folders_of_environment() if package_name(folder) == package)

    def _folders(self) -> Iterator[Path]:
        for folder in self._folders_near():
            self._by_name.setdefault(folder.name, []).append(folder)
            yield folder
        yield from self._folders_of_environment()

    def _folders_of_environment(self) -> Iterator[Path]:
        walk = self._walk("the variables of ROS")
        for prefix in _environment_paths("AMENT_PREFIX_PATH"):
            yield from walk.through(prefix / "share", 1)
        for folder in _environment_paths("ROS_PACKAGE_PATH"):
            yield from walk.through(folder, MAX_DEPTH)

    def _folders_near(self) -> Iterator[Path]:
        walk = self._walk("package_dirs")
        for folder in self.user_dirs:
            yield from walk.through(folder, MAX_DEPTH)
        walk = self._walk("the folders above")
        for parent in list(self.file.parents)[:MAX_PARENTS]:
            yield from walk.through(parent, 1)
            yield from walk.children(parent / SOURCES)
            yield from walk.installed(parent / INSTALLED)
            if parent.name == SHARE:
                yield from walk.installed(parent.parent.parent)

    def _walk(self, where: str) -> Walk:
        """A walk that adds to `searched` if it ends early."""
        what = f" (only the first {MAX_FOLDERS:,} of the folders of {where}: name nearer ones as package_dirs)"
        return Walk(lambda: self._unseen.setdefault(what))


@dataclass
class Walk:
    """A breadth-first walk through at most `left` folders. It calls `ended` if it stops early.

    Hidden and unreadable folders are left out, and links to folders that the walk has passed.
    """

    ended: Callable[[], None]
    left: int = MAX_FOLDERS
    _seen: set[tuple[int, int]] = field(default_factory=set)

    def through(self, folder: Path, depth: int) -> Iterator[Path]:
        """`folder` and the folders below, `depth` levels deep."""
        level = [folder]
        yield folder
        for _ in range(depth):
            level = [child for parent in level for child in self.children(parent)]
            yield from level

    def children(self, folder: Path) -> list[Path]:
        """The folders in a folder, by their names."""
        if self.left <= 0:
            return []
        found, entries = [], 0
        try:
            with os.scandir(folder) as inside:
                for entry in inside:
                    entries += 1
                    if not entry.name.startswith(".") and self._leads_on(entry):
                        found.append(entry.name)
                    if len(found) + entries // ENTRIES_PER_FOLDER > self.left:
                        break
        except OSError:
            pass
        self.left -= len(found) + entries // ENTRIES_PER_FOLDER
        if self.left <= 0:
            self.ended()
        return [folder / name for name in sorted(found)]

    def installed(self, folder: Path) -> Iterator[Path]:
        """Packages that colcon has installed there: `NAME/share/NAME`, or all in `share`."""
        homes = (prefix / SHARE / prefix.name for prefix in self.children(folder))
        yield from filter(os.path.isdir, homes)
        yield from self.children(folder / SHARE)

    def _leads_on(self, entry: os.DirEntry[str]) -> bool:
        """Whether it is a folder, or a link to a folder that the walk has not passed."""
        try:
            if not entry.is_dir():
                return False
            status = entry.stat()
        except OSError:
            return False
        place = status.st_dev, status.st_ino
        new = place not in self._seen
        self._seen.add(place)
        return new or not entry.is_symlink()


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


def _environment_paths(variable: str) -> list[Path]:
    return [Path(part) for part in os.environ.get(variable, "").split(os.pathsep) if part]


def find_copy(package: str, folders: Iterable[Path], file: Path, *, marked: bool) -> Path | None:
    """The first of `folders` that may be a copy of `package`: a folder without a package.xml.

    It has that name, or that name with a branch or a version behind it, as the folder of a ZIP. A folder above `file`
    may have any ending. A link does not count, nor the home folder and those above it. Of the folders beside them
    (`/etc`) only those above `file` count. With `marked` the folder must look like a robot's package, because messages
    may quote the files in it.
    """
    if package.startswith("."):
        return None
    bearing = (folder for folder in folders if _bears(folder.name, package, above=folder in file.parents))
    nearest = sorted(bearing, key=lambda folder: (folder.name != package, folder not in file.parents))
    named = (folder for folder in nearest if os.path.realpath(folder) == str(folder))
    fitting = (folder for folder in named if not is_too_wide(folder) and (folder in file.parents or _is_own(folder)))
    return next((folder for folder in fitting if not marked or _is_marked(folder)), None)


def _bears(name: str, package: str, *, above: bool) -> bool:
    rest = name[len(package) :] if name.startswith(package) else "/"
    return not rest or bool(_OF_ZIP.fullmatch(rest)) or (above and rest[0] in "-_ ")


def is_too_wide(folder: Path) -> bool:
    """Whether the folder is the home folder or one above it."""
    return _home().is_relative_to(folder)


def _is_own(folder: Path) -> bool:
    """Whether it lies deeper than the folders of the system and of other users."""
    return folder.parent != Path(folder.anchor) and folder.parent not in _home().parents


def _home() -> Path:
    return Path(os.path.realpath(os.path.expanduser("~")))


def _is_marked(folder: Path) -> bool:
    try:
        entries = list(folder.iterdir())
    except OSError:
        return False
    return any(entry.suffix in (".xacro", ".urdf") or (entry.name in MARKS and entry.is_dir()) for entry in entries)
