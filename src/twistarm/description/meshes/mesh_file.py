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
    """Why a mesh is not read, in words that follow its name.

    It is no OSError, which readers take for a missing file.
    """


class MeshFile(NamedTuple):
    """An opened mesh file: its format, its bytes, and its real path.

    `read` receives the size of this file and of each file it refers to.
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
