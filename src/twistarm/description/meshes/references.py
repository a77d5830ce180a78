"""Files that a mesh refers to: materials and buffers, opened only inside its package."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from ...support.errors import one_line
from ...support.files import read_bounded
from ..packages import is_too_wide, package_name
from .mesh_file import LARGEST_FILE, MeshFile, RefusedError

ENDINGS = {"obj": ".mtl", "gltf": ".bin", "glb": ".bin"}
"""Endings of materials and buffers, by format. Images are not drawn, so they are not opened."""

ITSELF = "model.gltf"
"""The file that trimesh asks for if a glTF is not JSON."""


class References:
    """A resolver for trimesh that reads files in the package of the mesh, or in its folder without a package.

    `refused` holds the first refusal, because some readers go on without the file.
    """

    file_name = "mesh"

    def __init__(self, mesh: MeshFile) -> None:
        self._mesh, self._left = mesh, LARGEST_FILE
        parents = mesh.place.parents
        self._root = next((f for f in parents if not is_too_wide(f) and package_name(f)), mesh.place.parent)
        self.refused: RefusedError | None = None

    def get(self, name: str) -> bytes:
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

    def namespaced(self, name: str) -> References:
        """The same resolver, so that all names start in this folder."""
        return self

    def _read(self, name: Any) -> bytes:
        shown = f"it refers to {one_line(str(name), 80)!r}"
        if name == ITSELF:
            raise RefusedError("it is no JSON")
        if not isinstance(name, str) or Path(name).suffix.lower() != ENDINGS.get(self._mesh.kind):
            raise FileNotFoundError(f"{shown}, which is not opened")
        name = name.strip().replace("\\", "/")
        try:
            try:
                data = self._inside(name)
            except FileNotFoundError:
                data = self._inside(unquote(name))  # a URI of glTF
        except FileNotFoundError:
            raise FileNotFoundError(f"{shown}, which is not there") from None
        except (OSError, ValueError) as error:
            raise RefusedError(f"{shown}, which cannot be read: {getattr(error, 'strerror', error)}") from None
        if data is None:
            raise RefusedError(f"{shown}, a file outside its package")
        self._left -= len(data)
        self._mesh.read(len(data))
        return data

    def _inside(self, name: str) -> bytes | None:
        """The bytes of a file in the package, None for one outside."""
        place = Path(os.path.realpath(self._mesh.place.parent / name))
        inside = place.is_relative_to(self._root) and not is_too_wide(self._root)
        return read_bounded(place, self._left) if inside else None
