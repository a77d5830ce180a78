"""The links of a description: primitives at once, then the meshes. Simple shapes until they arrive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, inf
from pathlib import Path

import numpy as np

from ...description.meshes import REMEDY, Part, read_mesh
from ...description.tree import Description, Geometry, Link
from ...support.errors import TwistarmError, listed, one_line
from ...support.files import stamp
from . import drawing
from .drawing import STICK, Colour, link_path

# Triangles of all meshes of an arm. A screen has some 200,000 pixels for it, and a processor draws them in 0.1 s.
TRIANGLES = 80_000
FEWEST = 500  # Least triangles of a mesh, so that a bolt beside a heavy base keeps its shape.

PLAIN: Colour = (0.62, 0.66, 0.72, 1.0)

FRAME = 0.08  # Length of the axes for a link without its mesh, in sizes of the arm.
# Radius of a replacing capsule: in sizes of the arm, and at most in lengths of the link's longest.
THICK, STOUT = 0.025, 0.3
# The parts of a mesh, or why it cannot be read, by its file, the file's stamp and the most triangles.
Read = dict[tuple[Path, "tuple[int, ...] | None", float], "list[Part] | str"]


@dataclass(frozen=True)
class MeshDrawing:
    """The result for the mesh at `node`: messages that draw it or its replacement, and a failure's reason.

    `readable`: its file could be read. `exact`: it shows all triangles of the file.
    """

    node: str
    objects: tuple[bytes, ...]
    note: str
    readable: bool
    exact: bool


def draw_plain(description: Description, size: float) -> list[bytes]:
    """Draw each link in a separate node without files, with simple shapes for its meshes.

    `size` [m] scales the replacements.
    """
    return [part for link in description.links.values() for part in _plain(description, link, size)]


def count_meshes(description: Description) -> int:
    """How many times `draw_meshes` yields."""
    return sum(len(_meshes(link)) for link in description.links.values())


def missing_meshes(description: Description) -> tuple[str, ...]:
    """The meshes that were not found, in words."""
    visuals = [(link.name, visual) for link in description.links.values() for visual in link.visuals]
    missing = [name for name, visual in visuals if visual.shape == "mesh" and visual.mesh is None]
    return (f"meshes not found, drawn as simple shapes: {listed(dict.fromkeys(missing))}",) if missing else ()


def draw_meshes(description: Description, size: float, exact: bool, read: Read) -> Iterator[MeshDrawing]:
    """Draw each mesh in its link's node.

    A file is read unless it is in `read`, which keeps it. Its fault is reported once.

    Unless `exact`, an arm of more than TRIANGLES is simplified to about that many. Each file keeps its share by bytes.
    """
    shares = {} if exact else _shares(description)
    reported = {""}
    for link in description.links.values():
        meshes, replaced, any_readable = _meshes(link), _is_only_meshes(link), False
        for k, (node, visual, path) in enumerate(meshes, 1):
            most = shares.get(path, inf)
            key = path, stamp(path), most
            if key not in read:
                read[key] = _parts_or_reason(path, most)
            parts = read[key]
            objects, note = ([], parts) if isinstance(parts, str) else (_mesh(node, visual, parts), "")
            readable, whole = bool(objects), isinstance(parts, str) or all(part.exact for part in parts)
            any_readable = any_readable or readable
            if replaced and k == len(meshes):
                objects += [drawing.removed(stand_in_path(link))] if any_readable else missing_frame(link, size)
            yield MeshDrawing(node, tuple(objects), "" if note in reported else note, readable, whole)
            reported.add(note)


def _meshes(link: Link) -> list[tuple[str, Geometry, Path]]:
    """The link's meshes that were found: node, visual, file."""
    path = link_path(link.name)
    return [(f"{path}/visual{i}", visual, visual.mesh) for i, visual in enumerate(link.visuals) if visual.mesh]


def _is_only_meshes(link: Link) -> bool:
    """Whether there is nothing to draw of a link but its meshes."""
    return all(visual.shape == "mesh" for visual in link.visuals)


def _shares(description: Description) -> Mapping[Path, int]:
    """Triangles for each file, by its size and number of uses."""
    files = [path for link in description.links.values() for _, _, path in _meshes(link)]
    sizes = {path: found[1] if (found := stamp(path)) else 0 for path in files}
    whole = max(sum(sizes[path] for path in files), 1)
    return {path: max(ceil(TRIANGLES * size / whole), FEWEST) for path, size in sizes.items()}


def _parts_or_reason(path: Path, most: float) -> list[Part] | str:
    try:
        return read_mesh(path).parts(most)
    except Exception as error:  # a fault of one mesh does not stop the others
        if isinstance(error, TwistarmError):
            return str(error)
        return one_line(f"cannot draw mesh {path.name}: {str(error) or type(error).__name__}; {REMEDY}")


def _plain(description: Description, link: Link, size: float) -> list[bytes]:
    path = link_path(link.name)
    objects = [
        part
        for i, visual in enumerate(link.visuals)
        for part in shape(f"{path}/visual{i}", visual, visual.colour or PLAIN)
    ]
    if not _is_only_meshes(link):
        return objects
    missing = link.visuals and not _meshes(link)
    return [*stand_in(description, link, size), *(missing_frame(link, size) if missing else [])]


def _mesh(path: str, visual: Geometry, parts: Sequence[Part]) -> list[bytes]:
    matrix = visual.origin @ np.diag([*visual.size, 1.0])
    # A file's own materials come first, as in RViz: descriptions give coloured meshes a placeholder colour.
    colours = [part.colour or visual.colour or PLAIN for part in parts]
    return [
        drawing.triangles(f"{path}/part{i}", part.vertices, part.normals, part.faces, colour, matrix)
        for i, (part, colour) in enumerate(zip(parts, colours, strict=True))
    ]


def stand_in_path(link: Link) -> str:
    """The node of a link's replacement shapes."""
    return f"{link_path(link.name)}/stand-in"


def stand_in(description: Description, link: Link, size: float) -> list[bytes]:
    """The link's collision primitives, or capsules from its origin to the joints that it carries."""
    path = stand_in_path(link)
    objects = [part for i, solid in enumerate(link.collisions) for part in shape(f"{path}/solid{i}", solid, STICK)]
    carried = [joint.origin[:3, 3] for joint in description.joints.values() if joint.parent == link.name]
    ends = [end for end in carried if np.linalg.norm(end) > 1e-3 * size]
    if objects or not ends:
        return objects
    radius = min(THICK * size, STOUT * max(float(np.linalg.norm(end)) for end in ends))
    objects = [drawing.sphere(f"{path}/origin", 1.3 * radius, STICK, np.eye(4))]
    for i, end in enumerate(ends):
        objects.append(drawing.rod(f"{path}/stick{i}", np.zeros(3), end, radius, STICK))
        objects.append(drawing.sphere(f"{path}/end{i}", radius, STICK, drawing.at(end)))
    return objects


def missing_frame(link: Link, size: float) -> list[bytes]:
    """The frame of a link with missing meshes."""
    return drawing.triad(f"{link_path(link.name)}/frame", FRAME * size)


def shape(path: str, geometry: Geometry, colour: Colour) -> list[bytes]:
    """A primitive of a description at `path`. Nothing for a mesh."""
    g, size = geometry.origin, geometry.size
    if geometry.shape == "box":
        return [drawing.box(path, size, colour, g)]
    if geometry.shape == "sphere":
        return [drawing.sphere(path, size[0], colour, g)]
    if geometry.shape == "cylinder":
        return [drawing.cylinder(path, size[0], size[1], colour, g)]
    if geometry.shape != "capsule":
        return []
    (radius, length), side = size[:2], drawing.cylinder(f"{path}/side", size[0], size[1], colour, g)
    ends = {name: g @ drawing.at(np.array([0.0, 0.0, z])) for name, z in (("bottom", -length / 2), ("top", length / 2))}
    return [side, *(drawing.sphere(f"{path}/{name}", radius, colour, end) for name, end in ends.items())]
