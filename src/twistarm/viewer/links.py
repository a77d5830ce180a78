"""The links of a description, drawn: primitives, meshes, and capsules where there is neither."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..checks import Array
from ..description.tree import Description, Geometry, Link
from ..errors import TwistarmError, listed, one_line
from . import drawing
from .drawing import STICK, Colour
from .meshes import Part, load_parts
from .nodes import link_path

PLAIN: Colour = (0.62, 0.66, 0.72, 1.0)

FRAME = 0.08
"""The axes of a link whose mesh is missing, in sizes of the arm."""


@dataclass(frozen=True)
class Drawn:
    """What one mesh came to: messages that draw it or what stands in for it, and why it could not be read."""

    objects: tuple[bytes, ...]
    notes: tuple[str, ...]


def draw_plain(description: Description, size: float) -> list[bytes]:
    """Every link in a node of its own, as far as that needs no file; `size` [m] scales what stands in for meshes."""
    return [part for link in description.links.values() for part in _plain(description, link, size)]


def count_meshes(description: Description) -> int:
    """How many times `draw_meshes` yields."""
    return sum(visual.mesh is not None for link in description.links.values() for visual in link.visuals)


def lost_meshes(description: Description) -> tuple[str, ...]:
    """The meshes that were not found, in words."""
    visuals = [(link.name, visual) for link in description.links.values() for visual in link.visuals]
    lost = [name for name, visual in visuals if visual.shape == "mesh" and visual.mesh is None]
    return (f"not drawn, the mesh was not found: {listed(dict.fromkeys(lost))}",) if lost else ()


def draw_meshes(description: Description, size: float) -> Iterator[Drawn]:
    """Every mesh in its link's node, one after the other; a file is read once, and its fault told once."""
    read: dict[Path, list[Part] | str] = {}
    told = {""}
    for link in description.links.values():
        undrawn = not any(visual.shape != "mesh" for visual in link.visuals)
        meshes = [(i, visual, visual.mesh) for i, visual in enumerate(link.visuals) if visual.mesh is not None]
        for k, (i, visual, path) in enumerate(meshes, 1):
            if path not in read:
                read[path] = _parts_or_reason(path)
            objects, note = _mesh_or_reason(f"{link_path(link.name)}/visual{i}", visual, path, read[path])
            undrawn = undrawn and not objects
            if undrawn and k == len(meshes):
                objects = _stand_in(description, link, size)
            yield Drawn(tuple(objects), () if note in told else (note,))
            told.add(note)


def _parts_or_reason(path: Path) -> list[Part] | str:
    try:
        return load_parts(path)
    except Exception as error:  # whatever ails one mesh, the others are drawn
        return str(error) if isinstance(error, TwistarmError) else _reason(path, error)


def _mesh_or_reason(node: str, visual: Geometry, path: Path, parts: list[Part] | str) -> tuple[list[bytes], str]:
    if isinstance(parts, str):
        return [], parts
    try:
        return _mesh(node, visual, parts), ""
    except Exception as error:
        return [], _reason(path, error)


def _reason(path: Path, error: Exception) -> str:
    return one_line(
        f"cannot draw mesh {path}: {str(error) or type(error).__name__}; export it again as STL, DAE or OBJ"
    )


def _plain(description: Description, link: Link, size: float) -> list[bytes]:
    path = link_path(link.name)
    drawn = [part for i, visual in enumerate(link.visuals) for part in _shape(f"{path}/visual{i}", visual)]
    waits = any(visual.mesh is not None for visual in link.visuals)
    return drawn or ([] if waits else _stand_in(description, link, size))


def _stand_in(description: Description, link: Link, size: float) -> list[bytes]:
    """Capsules from the link's origin to the joints that it carries; with its frame, where meshes are missing."""
    carried = [joint.origin[:3, 3] for joint in description.joints.values() if joint.parent == link.name]
    ends = [end for end in carried if np.linalg.norm(end) > 1e-3 * size]
    path, radius = link_path(link.name), 0.012 * size
    drawn = drawing.triad(f"{path}/frame", FRAME * size) if link.visuals else []
    for i, end in enumerate(ends):
        drawn.append(drawing.rod(f"{path}/stick{i}", np.zeros(3), end, radius, STICK))
        drawn.append(drawing.sphere(f"{path}/end{i}", radius, STICK, drawing.at(end)))
    return [*drawn, drawing.sphere(f"{path}/origin", 1.6 * radius, STICK, np.eye(4))] if ends else drawn


def _shape(path: str, visual: Geometry) -> list[bytes]:
    colour, g, size = visual.colour or PLAIN, visual.origin, visual.size
    if visual.shape == "box":
        return [drawing.box(path, size, colour, g)]
    if visual.shape == "sphere":
        return [drawing.sphere(path, size[0], colour, g)]
    if visual.shape == "cylinder":
        return [drawing.cylinder(path, size[0], size[1], colour, g)]
    return _capsule(path, size[0], size[1], colour, g) if visual.shape == "capsule" else []


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
