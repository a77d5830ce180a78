"""A mesh file, opened within bounds."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, NamedTuple

from ...support.files import open_regular, opened_path
from .formats import format_of
from .limits import LARGEST_FILE


class RefusedError(Exception):
    """Why a mesh is not read, in words that follow its name; no OSError, which a reader takes for a missing file."""


class MeshFile(NamedTuple):
    """A mesh file that was opened: its format, its bytes, and where it lies, links followed.

    `read` is told how many bytes it has, and of each file that it refers to.
    """

    kind: str
    data: bytes
    place: Path
    read: Callable[[int], None]


def mesh_file(path: Path, read: Callable[[int], None] = lambda size: None) -> MeshFile:
    """The file at `path`; UnreadableMeshError for another format, RefusedError for one too large, or OSError."""
    kind = format_of(path)
    with open_regular(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > LARGEST_FILE:
            raise RefusedError(f"it has {size / 1e6:.0f} MB; at most {LARGEST_FILE / 1e6:.0f} MB are read")
        data = file.read(LARGEST_FILE)
        read(len(data))
        return MeshFile(kind, data, _place(file, path), read)


def _place(file: BinaryIO, path: Path) -> Path:
    try:
        return opened_path(file)
    except OSError:  # the system does not tell, and nothing that the mesh refers to will be read
        return Path(os.path.realpath(path))
