"""The links of a description, drawn: primitives, meshes, and sticks where there is neither."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..checks import Array
from ..description.tree import Description, Geometry, Link
from ..errors import DescriptionError, listed
from . import drawing
from .drawing import STICK, Colour
from .meshes import Part, load_parts
from .nodes import link_path

PLAIN: Colour = (0.62, 0.66, 0.72, 1.0)

Meshes = dict[Path, "list[Part] | str"]


def load_meshes(description: Description) -> Meshes:
    """Every mesh that is drawn, read once; for one that cannot be read, why."""
    visuals = (visual for link in description.links.values() for visual in link.visuals)
    return {path: _parts_or_reason(path) for path in sorted({v.mesh for v in visuals if v.mesh is not None})}


def _parts_or_reason(path: Path) -> list[Part] | str:
    try:
        return load_parts(path)
    except DescriptionError as error:
        return str(error)


def mesh_notes(description: Description, meshes: Meshes) -> tuple[str, ...]:
    """What is not drawn, and why."""
    unread = [reason for reason in meshes.values() if isinstance(reason, str)]
    visuals = [(link.name, visual) for link in description.links.values() for visual in link.visuals]
    lost = [name for name, visual in visuals if visual.shape == "mesh" and visual.mesh is None]
    return (
        *unread,
        *((f"not drawn, the mesh was not found: {listed(dict.fromkeys(lost))}",) if lost else ()),
    )


def draw_links(description: Description, meshes: Meshes, size: float) -> list[bytes]:
    """Every link in a node of its own; `size` [m] scales the sticks."""
    return [part for link in description.links.values() for part in _link(description, link, meshes, size)]


def _link(description: Description, link: Link, meshes: Meshes, size: float) -> list[bytes]:
    path = link_path(link.name)
    drawn = [part for i, visual in enumerate(link.visuals) for part in _shape(f"{path}/visual{i}", visual, meshes)]
    return drawn or _stick(description, link.name, size)


def _stick(description: Description, name: str, size: float) -> list[bytes]:
    carried = [joint.origin[:3, 3] for joint in description.joints.values() if joint.parent == name]
    ends = [end for end in carried if np.linalg.norm(end) > 1e-3 * size]
    path, radius = link_path(name), 0.012 * size
    rods = [drawing.rod(f"{path}/stick{i}", np.zeros(3), end, radius, STICK) for i, end in enumerate(ends)]
    return [*rods, drawing.sphere(f"{path}/origin", 1.6 * radius, STICK, np.eye(4))] if rods else []


def _shape(path: str, visual: Geometry, meshes: Meshes) -> list[bytes]:
    colour, g, size = visual.colour or PLAIN, visual.origin, visual.size
    if visual.shape == "box":
        return [drawing.box(path, size, colour, g)]
    if visual.shape == "sphere":
        return [drawing.sphere(path, size[0], colour, g)]
    if visual.shape == "cylinder":
        return [drawing.cylinder(path, size[0], size[1], colour, g)]
    if visual.shape == "capsule":
        return _capsule(path, size[0], size[1], colour, g)
    parts = meshes[visual.mesh] if visual.mesh is not None else ()
    return [] if isinstance(parts, str) else _mesh(path, visual, parts)


def _capsule(path: str, radius: float, length: float, colour: Colour, g: Array) -> list[bytes]:
    drawn = [drawing.cylinder(f"{path}/side", radius, length, colour, g)]
    for name, z in (("bottom", -length / 2), ("top", length / 2)):
        end = g.copy()
        end[:3, 3] += z * g[:3, 2]
        drawn.append(drawing.sphere(f"{path}/{name}", radius, colour, end))
    return drawn


def _mesh(path: str, visual: Geometry, parts: Sequence[Part]) -> list[bytes]:
    matrix = visual.origin @ np.diag([*visual.size, 1.0])
    # A file's own materials come first, as in RViz: descriptions give coloured meshes a placeholder colour.
    colours = [part.colour or visual.colour or PLAIN for part in parts]
    return [
        drawing.triangles(f"{path}/part{i}", part.vertices, part.normals, part.faces, colour, matrix)
        for i, (part, colour) in enumerate(zip(parts, colours, strict=True))
    ]
