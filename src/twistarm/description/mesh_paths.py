"""Paths of meshes: all kinds of URIs resolved inside packages, and the remedy for a missing file."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote

from ..support.errors import closest
from ..support.files import is_file
from ..support.messages import Text, package_folder
from .packages import PackageIndex

_IN_PACKAGE = re.compile(r"(?:(?:package|model)://([^/\\]*)|\$\(find\s+([^)\s]+)\))[/\\]*")


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
    None if there is no such file, or if it really lies outside the packages and the caller's folders.
    """
    beside, folders = packages.file.parent, list(_folders(parsed(uri), packages))
    found = (folder / path for folder in folders for path in _spellings(parsed(uri).path))
    reals = (Path(os.path.realpath(path)) for path in found if is_file(path))
    given = (*folders, *packages.user_dirs)
    return next((real for real in reals if real.is_relative_to(beside) or packages.allows(real, given)), None)


def why_missing(uri: str, packages: PackageIndex) -> tuple[str, str]:
    """Why there is no file at a URI, and the remedy. Both are equal for files with one remedy."""
    _, package, path = parsed(uri)
    folders = list(_folders(parsed(uri), packages))
    if package and not folders:
        near = closest(package, packages.names())
        correct = f"correct the name{near}, or " if near else ""
        remedy = Text("{correct}pass {folder}", correct=correct, folder=package_folder(package))
        return f"package {package!r} not found", remedy
    if any(is_file(folder / each) for folder in folders for each in _spellings(path)):
        remedy = Text("pass {folder}", folder=package_folder("them"))
        return "they lie outside the description's package", remedy
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
