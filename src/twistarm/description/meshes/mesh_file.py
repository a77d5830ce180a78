"""Mesh files: the formats and sizes that are read, a file opened within bounds, and the parts read from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...support.checks import Array
from ...support.errors import DescriptionError
from ...support.files import read_bounded

LARGEST_FILE = 100_000_000
"""Bytes of a mesh file, and of all that it refers to. The largest of some hundred arms has 5 MB."""

TRIANGLES = 1_000_000
"""Triangles of one file, about as many as an arm's pixels on a screen."""

PARTS = 5_000
"""Parts of one file, each drawn by itself. The largest files have some hundred."""

MEMORY = 1_200_000_000
"""Bytes of address space. To simplify and shade a million triangles takes 0.9 GB."""

LONGEST = 1e9
"""Largest coordinate [m], as in a description. Its fourth power is still a finite number."""

SECONDS, SECONDS_PER_MEGABYTE, SECONDS_AT_MOST = 3.0, 1.0, 30.0
"""Processor time for one mesh. A megabyte of COLLADA takes 0.1 s."""

ARM_SECONDS, ARM_SECONDS_AT_MOST = 8.0, 90.0
"""Processor time for all meshes of an arm, plus SECONDS_PER_MEGABYTE of each."""

PATIENCE = 4.0
"""Wall time of a mesh over its processor time. The machine may be busy, or its disk slow."""

FORMATS = ("stl", "obj", "dae", "ply", "glb", "gltf")
"""Plain formats that exporters write. Archives unpack to any size, so they are not read. CAD formats are not either."""

LIGHTER = "export it with fewer triangles"

REMEDY = "export it as STL, OBJ, DAE, PLY or GLB"

Colour = tuple[float, float, float, float]


def seconds_for(size: int) -> float:
    """Processor time [s] that a mesh of `size` bytes may take."""
    return min(SECONDS + SECONDS_PER_MEGABYTE * size / 1e6, SECONDS_AT_MOST)


class UnreadableMeshError(DescriptionError):
    """A mesh that cannot be drawn: its name, `reason` and `remedy`. The message does not show the folder."""

    def __init__(self, path: Path, reason: str, remedy: str = REMEDY) -> None:
        super().__init__(f"cannot read mesh {path.name}: {reason}; {remedy}")
        self.path, self.reason, self.remedy = path, reason, remedy

    def __reduce__(self) -> tuple[type[UnreadableMeshError], tuple[Path, str, str]]:
        return type(self), (self.path, self.reason, self.remedy)


class RefusedError(Exception):
    """Why a mesh is not read, in words that follow its name. A reader takes an OSError for a missing file."""


@dataclass(frozen=True)
class Part:
    """Triangles of one material: vertices (N, 3), unit normals (N, 3), faces (F, 3).

    `colour` is None where the file gives none. `exact` tells that the triangles are not simplified.
    """

    vertices: Array
    normals: Array
    faces: NDArray[np.int64]
    colour: Colour | None
    exact: bool = True


class MeshFile(NamedTuple):
    """An open mesh file: its format, its bytes, and its path without links.

    `read` takes the number of bytes of this file, and of each file that it refers to.
    """

    kind: str
    data: bytes
    place: Path
    read: Callable[[int], None]


def format_of(path: Path) -> str:
    """The format by the file's ending. UnreadableMeshError for one that is not in FORMATS."""
    ending = path.suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        what = f"{f'.{ending} files are' if ending else 'a file without an ending is'} not read here"
        raise UnreadableMeshError(path, what)
    return ending


def size_of(path: Path) -> int:
    """The bytes of the file, 0 if there is none."""
    try:
        return path.stat().st_size
    except OSError:
        return 0


def mesh_file(path: Path, read: Callable[[int], None] = lambda size: None) -> MeshFile:
    """Read the file at `path`.

    Raises UnreadableMeshError for another format, and OSError as `read_bounded`.
    """
    kind = format_of(path)
    data = read_bounded(path, LARGEST_FILE)
    read(len(data))
    return MeshFile(kind, data, path.resolve(), read)
