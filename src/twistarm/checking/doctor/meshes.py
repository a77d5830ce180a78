"""Meshes a thousand times too large or too small, pointer files, and unreadable files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...description.findings import Finding, finding
from ...description.meshes import UnreadableMeshError, read_mesh
from ...description.tree import Description
from ...support.checks import Array
from ...support.errors import listed
from ...support.files import is_file, open_regular
from .motions import LONGEST_REACH

TOO_LARGE = 20.0
"""Times the arm's own size: no link is as long."""

TOO_SMALL = 1.0 / 50.0
"""Of the arm's own size: of all its meshes the largest is longer."""

SHOWN = 3
"""File names in one finding."""

_POINTER = b"version https://git-lfs"


class Use(NamedTuple):
    """A mesh file, and the scale that one shape uses it at."""

    path: Path
    scale: tuple[float, ...]


def check_meshes(description: Description) -> Iterator[Finding]:
    """Every mesh file once: its first bytes, then the size of what it holds."""
    uses = _uses(description)
    paths = list(dict.fromkeys(use.path for use in uses))
    pointers = [path for path in paths if _is_pointer(path)]
    if pointers:
        what = "Git LFS pointers, not meshes; they are not drawn"
        remedy = "run git lfs pull in the repository they come from"
        yield _mesh_finding("mesh-unreadable", description, pointers, what, remedy)
    yield from _sizes(description, [path for path in paths if path not in pointers], uses)


def _sizes(description: Description, paths: list[Path], uses: list[Use]) -> Iterator[Finding]:
    lengths: dict[Path, float] = {}
    broken: dict[tuple[str, str], list[Path]] = {}
    for path in paths:
        found = _length(path)
        if isinstance(found, UnreadableMeshError):
            broken.setdefault((found.reason, found.remedy), []).append(path)
        else:
            lengths[path] = found
    for (reason, remedy), files in broken.items():
        yield _mesh_finding("mesh-unreadable", description, files, f"{reason}; simple shapes are drawn instead", remedy)
    flat = [use.path for use in uses if not all(use.scale)]
    if flat:
        remedy = 'write scale="1 1 1" in <mesh>, or what makes metres of the unit it was exported in'
        yield _mesh_finding("unit-doubtful", description, flat, "a scale of 0 leaves nothing of it to see", remedy)
    sized = {
        use: length * max(map(abs, use.scale)) for use in uses if all(use.scale) and (length := lengths.get(use.path))
    }
    yield from _out_of_scale(description, sized)


def _out_of_scale(description: Description, lengths: dict[Use, float]) -> Iterator[Finding]:
    """`lengths` [m], scaled, against the size of the arm."""
    size = _size(description)
    large = {use: length for use, length in lengths.items() if length > TOO_LARGE * size}
    if large:
        what = f"{max(large.values()):.4g} m long, on an arm of {size:.3g} m: likely in millimetres"
        yield _mesh_finding("unit-doubtful", description, [use.path for use in large], what, _rescaled(large, 1e-3))
    elif lengths and max(lengths.values()) < TOO_SMALL * size and size < LONGEST_REACH:
        longest = max(lengths, key=lambda use: lengths[use])
        what = f"{lengths[longest]:.2g} m long at most, on an arm of {size:.3g} m: scaled down twice"
        yield _mesh_finding(
            "unit-doubtful", description, [use.path for use in lengths], what, _rescaled([longest], 1e3)
        )


def _rescaled(uses: Iterable[Use], factor: float) -> str:
    """The scale to write for meshes with one scale, or the factor for several."""
    scales = {use.scale for use in uses}
    if len(scales) > 1:
        return f"multiply their scales in <mesh> by {factor:g}"
    numbers = " ".join(f"{scale * factor:.6g}" for scale in scales.pop())
    return f'write scale="{numbers}" in <mesh>'


def _length(path: Path) -> float | UnreadableMeshError:
    try:
        return read_mesh(path).length
    except UnreadableMeshError as error:
        return error


def _uses(description: Description) -> list[Use]:
    """Every mesh file that is there, with each scale that it is used at."""
    shapes = [shape for link in description.links.values() for shape in (*link.visuals, *link.collisions)]
    uses = (Use(shape.mesh, shape.size) for shape in shapes if shape.mesh is not None and is_file(shape.mesh))
    return list(dict.fromkeys(uses))


def _is_pointer(path: Path) -> bool:
    try:
        with open_regular(path) as file:
            return file.read(len(_POINTER)) == _POINTER
    except OSError:
        return False


def _size(description: Description) -> float:
    """The largest distance between link frames at zero [m]; 1 if all coincide."""
    points: Array = np.stack([g[:3, 3] for g in description.link_poses({}).values()])
    return float(np.ptp(points, axis=0).max()) or 1.0


def _mesh_finding(code: str, description: Description, paths: Sequence[Path], what: str, remedy: str) -> Finding:
    names = listed(dict.fromkeys(path.name for path in paths), SHOWN)
    return finding(code, description.place(), f"{names}: {what}", remedy)
