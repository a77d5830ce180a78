"""Mesh formats, by the ending of the file that a description names."""

from __future__ import annotations

from pathlib import Path

from ...support.errors import DescriptionError

FORMATS = ("stl", "obj", "dae", "ply", "glb", "gltf")
"""Plain ones that exporters write. Archives, of which a small file unpacks to any size, and formats of CAD programs are
not read."""

LIGHTER = "export it with fewer triangles"

REMEDY = "export it as STL, OBJ, DAE, PLY or GLB"


class UnreadableMeshError(DescriptionError):
    """A mesh that cannot be drawn: its name, `reason` and `remedy` in words, without its path."""

    def __init__(self, path: Path, reason: str, remedy: str = REMEDY) -> None:
        super().__init__(f"cannot read mesh {path.name}: {reason}; {remedy}")
        self.path, self.reason, self.remedy = path, reason, remedy

    def __reduce__(self) -> tuple[type[UnreadableMeshError], tuple[Path, str, str]]:  # type: ignore[override]
        return type(self), (self.path, self.reason, self.remedy)


def format_of(path: Path) -> str:
    """One of FORMATS; UnreadableMeshError for another ending."""
    ending = path.suffix.lower().removeprefix(".")
    if ending not in FORMATS:
        what = f"{f'.{ending} files are' if ending else 'a file without an ending is'} not read here"
        raise UnreadableMeshError(path, what)
    return ending
