"""Paths of meshes: all kinds of URIs resolved, and the remedy for a missing file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote

from ..support.errors import closest
from ..support.files import is_file
from ..support.messages import Text, package_folder
from .meshes.reading import FORMATS
from .packages import PackageIndex

_IN_PACKAGE = re.compile(r"(?:(?:package|model)://([^/\\]*)|\$\(find\s+([^)\s]+)\))[/\\]*")

SIMILAR, MOST_ENTRIES = 0.7, 1_000
"""Similarity of a name and its misspelling, and most files of a folder to compare."""


class MeshUri(NamedTuple):
    """The text before the path, the package ("" for none), and the path."""

    head: str
    package: str
    path: str


def parsed(uri: str) -> MeshUri:
    """The parts of a URI. `package://./x` and `package:///x` have no package."""
    uri = uri.strip()
    if match := _IN_PACKAGE.match(uri):
        package = match[1] or match[2] or ""
        return MeshUri(match[0], "" if package == "." else package, uri[match.end() :])
    if uri.startswith("file://"):
        return MeshUri("file://", "", uri[len("file://") :].replace("localhost/", "/", 1))
    return MeshUri("", "", uri)


def plain(uri: str) -> str:
    """The URI with single slashes instead of several or of backslashes."""
    head, package, path = parsed(uri)
    scheme = head if not package else head.rstrip("/\\") + "/"
    return scheme + re.sub(r"(?<=.)[/\\]+", "/", path)


def resolve_uri(uri: str, packages: PackageIndex) -> Path | None:
    """The mesh file of a URI: `package://`, `model://`, `file://`, `$(find p)/…`, absolute, or beside the file.

    Without a package's name, `package://` begins at the file's folder, at those above, or at the caller's folders.
    None if there is no such file.
    """
    found = (folder / path for folder in _folders(parsed(uri), packages) for path in _spellings(parsed(uri).path))
    path = next((path for path in found if is_file(path)), None)
    return None if path is None else Path(os.path.realpath(path))


def why_missing(uri: str, packages: PackageIndex) -> tuple[str, str]:
    """Why there is no file at a URI, and the remedy. Both are equal for files with one remedy."""
    head, package, path = parsed(uri)
    folders = list(_folders(parsed(uri), packages))
    if package and not folders:
        return _package_missing(package, path, packages)
    if near := next((near for folder in folders if (near := _near(folder, _spellings(path)[-1]))), None):
        return "other names stand there", f"write {plain(head + near)!r}"
    where = f"in package {package!r}" if package else "where the description looks for them"
    return f"no such file stands {where}", "correct the paths, or put the files there"


def _folders(uri: MeshUri, packages: PackageIndex) -> Iterator[Path]:
    """The folders in which its path may begin."""
    if uri.package:
        folder = packages.find_for_mesh(uri.package)
        yield from () if folder is None else (folder,)
    else:
        yield packages.file.parent
        if uri.head not in ("", "file://"):
            yield from packages.near[1:]


def _spellings(path: str) -> list[str]:
    """The path as written, with %20 decoded, and with slashes for backslashes."""
    decoded = unquote(path)
    return list(dict.fromkeys((path, decoded, path.replace("\\", "/"), decoded.replace("\\", "/"))))


def _package_missing(package: str, path: str, packages: PackageIndex) -> tuple[str, str]:
    what, near = f"package {package!r} not found", closest(package, packages.names())
    correct = f"correct the name{near}, or " if near else ""
    for folder in packages.near:
        if path and any(is_file(folder / name) for name in _spellings(path)):
            remedy = f"{correct}give the folder {folder.name!r} the name {package}"
            return f"{what}, but the path is relative to the folder {folder.name!r}", remedy
    return what, Text("{correct}pass {folder}", correct=correct, folder=package_folder(package))


def _near(folder: Path, path: str) -> str | None:
    """The path of a mesh below the folder that differs in case, or by a misspelt file name."""
    *parents, name = path.split("/")
    done: list[str] = []
    for part in parents:
        entry = part if os.path.isdir(folder / part) else _alike(part, _entries(folder, files=False))
        if entry is None:
            return None
        folder, done = folder / entry, [*done, entry]
    meshes = [entry for entry in _entries(folder, files=True) if entry.lower().endswith(FORMATS)]
    last = _alike(name, meshes) or next(iter(get_close_matches(name, meshes, 1, SIMILAR)), None)
    return None if last is None else "/".join([*done, last])


def _alike(name: str, entries: list[str]) -> str | None:
    return next((entry for entry in entries if entry.casefold() == name.casefold()), None)


def _entries(folder: Path, *, files: bool) -> list[str]:
    """The first names of visible files, or folders, in a folder."""
    try:
        with os.scandir(folder) as inside:
            entries = [entry for _, entry in zip(range(MOST_ENTRIES), inside, strict=False)]
            return sorted(e.name for e in entries if not e.name.startswith(".") and e.is_dir() != files)
    except (OSError, ValueError):
        return []
