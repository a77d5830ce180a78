"""Meshes a thousand times too large or too small, pointers in their place, and files that cannot be read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ..checks import Array
from ..description.findings import Finding, finding
from ..description.tree import Description, Geometry
from ..errors import listed
from ..files import is_file

TOO_LARGE = 20.0
"""Times the arm's own size: no link is as long."""

TOO_SMALL = 1.0 / 50.0
"""Of the arm's own size: of all its meshes the largest is longer."""

LARGEST_FILE, LARGEST_TOTAL = 20_000_000, 100_000_000
"""Bytes of one mesh, and of all, that are read for their size."""

SHOWN = 3
"""File names in one finding."""

_POINTER = b"version https://git-lfs"


def check_meshes(description: Description) -> Iterator[Finding]:
    """Every mesh file once: its first bytes, then the size of what it holds."""
    shapes = _meshes(description)
    pointers = [path for path in shapes if _is_pointer(path)]
    if pointers:
        yield _told(
            "mesh-lfs-pointer",
            description,
            pointers,
            "Git LFS pointers, not meshes; they are not drawn",
            "run git lfs pull in the repository they come from",
        )
    rest = {path: shape for path, shape in shapes.items() if path not in pointers}
    try:
        import trimesh  # noqa: F401
    except ImportError:
        if rest:
            what = f"{len(rest)} mesh files, whose size was not looked at: that needs trimesh"
            yield finding("mesh-not-looked-at", description.place(), what, "pip install 'twistarm[view]'")
        return
    yield from _sizes(description, rest)


def _sizes(description: Description, shapes: dict[Path, Geometry]) -> Iterator[Finding]:
    small = _affordable(shapes)
    lengths = {path: length_of(path) for path in small}
    broken = [path for path, length in lengths.items() if length is None]
    if broken:
        remedy = "export them again as STL, DAE or OBJ"
        yield _told("mesh-unreadable", description, broken, "cannot be read as meshes; they are not drawn", remedy)
    if len(small) < len(shapes):
        left = [path for path in shapes if path not in small]
        what = f"too many bytes to look at their size here ({LARGEST_FILE / 1e6:.0f} MB each at most)"
        yield _told("mesh-not-looked-at", description, left, what, "look at them with twistarm view")
    sized = {path: length * max(map(abs, shapes[path].size)) for path, length in lengths.items() if length}
    yield from _out_of_scale(description, shapes, sized)


def _out_of_scale(
    description: Description, shapes: dict[Path, Geometry], lengths: dict[Path, float]
) -> Iterator[Finding]:
    """`lengths` [m], scaled, against the size of the arm."""
    size = _size(description)
    large = [path for path, length in lengths.items() if length > TOO_LARGE * size]
    if large:
        length, scale = lengths[large[0]], shapes[large[0]].size
        yield _told(
            "mesh-too-large",
            description,
            large,
            f"{length:.4g} m long, on an arm of {size:.3g} m: in millimetres",
            f'write scale="{_numbers(np.array(scale) / 1e3)}" in <mesh>',
        )
    elif lengths and max(lengths.values()) < TOO_SMALL * size:
        path = max(lengths, key=lambda path: lengths[path])
        yield _told(
            "mesh-too-small",
            description,
            list(lengths),
            f"{lengths[path]:.2g} m long at most, on an arm of {size:.3g} m: scaled down twice",
            f'write scale="{_numbers(np.array(shapes[path].size) * 1e3)}" in <mesh>',
        )


def length_of(path: Path) -> float | None:
    """The longest side of the mesh's box, in metres where its file names the unit; None if it cannot be read."""
    import trimesh

    try:
        scene = trimesh.load_scene(str(path))
        metres = trimesh.units.unit_conversion(scene.units, "meters") if scene.units else 1.0
        length = float(np.ptp(scene.bounds, axis=0).max()) * float(metres)
    except Exception:  # the readers of trimesh raise whatever their format made them stumble over
        return None
    return length if np.isfinite(length) and length > 0 else None


def _meshes(description: Description) -> dict[Path, Geometry]:
    """Every mesh file that is there, with a shape that uses it."""
    shapes = [shape for link in description.links.values() for shape in (*link.visuals, *link.collisions)]
    return {shape.mesh: shape for shape in shapes if shape.mesh is not None and is_file(shape.mesh)}


def _affordable(shapes: dict[Path, Geometry]) -> list[Path]:
    total, chosen = 0, []
    for path in shapes:
        size = path.stat().st_size
        if size <= LARGEST_FILE and total + size <= LARGEST_TOTAL:
            total += size
            chosen.append(path)
    return chosen


def _is_pointer(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            return file.read(len(_POINTER)) == _POINTER
    except OSError:
        return False


def _size(description: Description) -> float:
    """How far apart the links' frames are at zero [m]; 1 where they are all in one place."""
    points: Array = np.stack([g[:3, 3] for g in description.link_poses({}).values()])
    return float(np.ptp(points, axis=0).max()) or 1.0


def _told(code: str, description: Description, paths: Sequence[Path], what: str, remedy: str) -> Finding:
    names = listed([path.name for path in paths], SHOWN)
    return finding(code, description.place(), f"{names}: {what}", remedy)


def _numbers(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in values)
