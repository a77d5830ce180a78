"""The files that a mesh refers to, opened inside its package only."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ...support.errors import one_line
from ...support.files import is_file, read_bounded, stamp
from ..packages import home_of, is_too_wide
from .mesh import RefusedError

ENDINGS = {"obj": ".mtl", "gltf": ".bin", "glb": ".bin"}
"""Endings of materials and buffers, by format. Images are not drawn, so they are not opened."""

Stamps = dict[Path, tuple[int, ...] | None]
"""Files, also missing ones, with their `stamp` when they were read."""


class Resolver:
    """Reads at most `left` bytes for trimesh, in the package of the mesh at `path`, or in its folder without one.

    It adds each file to `files`. `refused` holds the first refusal, because some readers go on without the file.
    """

    file_name = "mesh"

    def __init__(self, kind: str, path: Path, left: int, files: Stamps) -> None:
        self._ending, self._place, self._left = ENDINGS.get(kind), Path(os.path.realpath(path)), left
        self._files = files
        self.refused: RefusedError | None = None

    def get(self, name: Any) -> bytes:
        """The bytes of a file. FileNotFoundError if there is none, RefusedError if it must not be read."""
        what = f"it refers to {one_line(str(name), 80)!r}"
        if not isinstance(name, str) or Path(name).suffix.lower() != self._ending:
            raise FileNotFoundError(f"{what}, which is not opened")
        try:
            spelling = name.strip().replace("\\", "/")
            places = [Path(os.path.realpath(self._place.parent / each)) for each in (spelling, unquote(spelling))]
            place, root = next(filter(is_file, places), places[0]), home_of(self._place)
            if is_too_wide(root) or not place.is_relative_to(root):
                raise RefusedError(f"{what}, a file outside its package")
            self._files[place] = stamp(place)
            data = read_bounded(place, self._left)
        except FileNotFoundError:
            raise FileNotFoundError(f"{what}, which is not there") from None
        except (RefusedError, OSError, ValueError) as error:
            why = f"{what}, which cannot be read: {getattr(error, 'strerror', error)}"
            self.refused = self.refused or (error if isinstance(error, RefusedError) else RefusedError(why))
            raise self.refused from None
        self._left -= len(data)
        return as_utf8(data) if self._ending == ".mtl" else data

    __getitem__ = get

    def keys(self) -> list[str]:
        """No names, so trimesh searches nothing."""
        return []

    def namespaced(self, name: str) -> Resolver:
        """The same resolver, so that all names start in this folder."""
        return self


def as_utf8(data: bytes) -> bytes:
    """Text in Latin-1 as UTF-8: trimesh would look for a library that guesses."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data
