"""Meshes a thousand times too large or too small, pointer files, and unreadable files."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

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


Use = tuple[Path, tuple[float, ...]]
"""A mesh file, and the scale that one shape uses it at."""


def check_meshes(description: Description) -> Iterator[Finding]:
    """Every mesh file once: its first bytes, then the size of what it holds."""

    def found(code: str, paths: Iterable[Path], what: str, remedy: str) -> Finding:
        names = listed(dict.fromkeys(path.name for path in paths), SHOWN)
        return finding(code, description.place(), f"{names}: {what}", remedy)

    shapes = [shape for link in description.links.values() for shape in (*link.visuals, *link.collisions)]
    uses: dict[Use, None] = {(shape.mesh, shape.size): None for shape in shapes if shape.mesh and is_file(shape.mesh)}
    broken: dict[tuple[str, str], list[Path]] = {}
    lengths: dict[Path, float] = {}
    for path in dict.fromkeys(path for path, _ in uses):
        if _is_pointer(path):
            why = (
                "Git LFS pointers, not meshes; they are not drawn",
                "run git lfs pull in the repository they come from",
            )
            broken.setdefault(why, []).append(path)
            continue
        try:
            lengths[path] = read_mesh(path).length
        except UnreadableMeshError as error:
            why = f"{error.reason}; simple shapes are drawn instead", error.remedy
            broken.setdefault(why, []).append(path)
    for (what, remedy), paths in broken.items():
        yield found("mesh-unreadable", paths, what, remedy)
    if flat := [path for path, scale in uses if not all(scale)]:
        remedy = 'write scale="1 1 1" in <mesh>, or what makes metres of the unit it was exported in'
        yield found("unit-doubtful", flat, "a scale of 0 leaves nothing of it to see", remedy)
    sized = {(p, scale): lengths[p] * max(map(abs, scale)) for p, scale in uses if all(scale) and lengths.get(p)}
    points: Array = np.stack([g[:3, 3] for g in description.link_poses({}).values()])
    size = float(np.ptp(points, axis=0).max()) or 1.0  # of the arm at zero [m]; 1 if all frames coincide
    if large := {use: length for use, length in sized.items() if length > TOO_LARGE * size}:
        what = f"{max(large.values()):.4g} m long, on an arm of {size:.3g} m: likely in millimetres"
        yield found("unit-doubtful", (path for path, _ in large), what, _rescaled(large, 1e-3))
    elif sized and max(sized.values()) < TOO_SMALL * size and size < LONGEST_REACH:
        longest = max(sized, key=lambda use: sized[use])
        what = f"{sized[longest]:.2g} m long at most, on an arm of {size:.3g} m: scaled down twice"
        yield found("unit-doubtful", (path for path, _ in sized), what, _rescaled([longest], 1e3))


def _rescaled(uses: Iterable[Use], factor: float) -> str:
    """The scale to write for meshes with one scale, or the factor for several."""
    scales = {scale for _, scale in uses}
    if len(scales) > 1:
        return f"multiply their scales in <mesh> by {factor:g}"
    numbers = " ".join(f"{scale * factor:.6g}" for scale in scales.pop())
    return f'write scale="{numbers}" in <mesh>'


def _is_pointer(path: Path) -> bool:
    try:
        with open_regular(path) as file:
            return file.read(len(_POINTER)) == _POINTER
    except OSError:
        return False
