"""The files that a mesh refers to, opened inside its package only."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ...support.errors import one_line
from ...support.files import read_bounded, stamp
from ..packages import home_of, is_too_wide
from .mesh import RefusedError

ENDINGS = {"obj": ".mtl", "gltf": ".bin", "glb": ".bin"}
"""Endings of materials and buffers, by format. Images are not drawn, so they are not opened."""

ITSELF = "model.gltf"
"""The file that trimesh asks for if a glTF is not JSON."""


Stamps = dict[Path, tuple[int, ...] | None]
"""Files, also missing ones, with their `stamp` when they were read."""


class Resolver:
    """Reads at most `left` bytes for trimesh, in the package of the mesh at `path`, or in its folder without one.

    It adds each file to `files`. `refused` holds the first refusal, because some readers go on without the file.
    """

    file_name = "mesh"

    def __init__(self, kind: str, path: Path, left: int, files: Stamps) -> None:
        self._ending, self._place, self._left = ENDINGS.get(kind), Path(os.path.realpath(path)), left
        self._root = home_of(self._place)
        self._files = files
        self.refused: RefusedError | None = None

    def get(self, name: Any) -> bytes:
        """The bytes of a file. FileNotFoundError if there is none, RefusedError if it must not be read."""
        try:
            return self._read(name)
        except RefusedError as error:
            self.refused = self.refused or error
            raise

    __getitem__ = get

    def keys(self) -> list[str]:
        """No names, so trimesh searches nothing."""
        return []

    def namespaced(self, name: str) -> Resolver:
        """The same resolver, so that all names start in this folder."""
        return self

    def _read(self, name: Any) -> bytes:
        shown = f"it refers to {one_line(str(name), 80)!r}"
        if name == ITSELF:
            raise RefusedError("it is no JSON")
        if not isinstance(name, str) or Path(name).suffix.lower() != self._ending:
            raise FileNotFoundError(f"{shown}, which is not opened")
        name = name.strip().replace("\\", "/")
        spellings = (name, unquote(name))  # the second is a URI's of glTF
        try:
            places = [Path(os.path.realpath(self._place.parent / each)) for each in spellings]
            place = next((place for place in places if place.exists()), places[0])
            if is_too_wide(self._root) or not place.is_relative_to(self._root):
                raise RefusedError(f"{shown}, a file outside its package")
            self._files[place] = stamp(place)
            data = read_bounded(place, self._left)
        except FileNotFoundError:
            raise FileNotFoundError(f"{shown}, which is not there") from None
        except (OSError, ValueError) as error:
            raise RefusedError(f"{shown}, which cannot be read: {getattr(error, 'strerror', error)}") from None
        self._left -= len(data)
        return as_utf8(data) if self._ending == ".mtl" else data


def as_utf8(data: bytes) -> bytes:
    """Text in Latin-1 as UTF-8: trimesh would look for a library that guesses."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data
