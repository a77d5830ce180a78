"""Simple shapes: primitives of a description, and replacements for missing meshes."""

from __future__ import annotations

import numpy as np

from ...description.tree import Description, Geometry, Link
from ...support.checks import Array
from . import drawing
from .drawing import STICK, Colour
from .nodes import link_path

PLAIN: Colour = (0.62, 0.66, 0.72, 1.0)

FRAME = 0.08
"""Length of the axes for a link without its mesh, in sizes of the arm."""

THICK, STOUT = 0.025, 0.3
"""Radius of a replacing capsule: in sizes of the arm, and at most in lengths of the link's longest."""


def stand_in_path(link: Link) -> str:
    """The node of a link's replacement shapes."""
    return f"{link_path(link.name)}/stand-in"


def stand_in(description: Description, link: Link, size: float) -> list[bytes]:
    """The link's collision primitives, or capsules from its origin to the joints that it carries."""
    path = stand_in_path(link)
    drawn = [part for i, solid in enumerate(link.collisions) for part in shape(f"{path}/solid{i}", solid, STICK)]
    return drawn or _capsules(description, link, size)


def _capsules(description: Description, link: Link, size: float) -> list[bytes]:
    carried = [joint.origin[:3, 3] for joint in description.joints.values() if joint.parent == link.name]
    ends = [end for end in carried if np.linalg.norm(end) > 1e-3 * size]
    if not ends:
        return []
    path = stand_in_path(link)
    radius = min(THICK * size, STOUT * max(float(np.linalg.norm(end)) for end in ends))
    drawn = [drawing.sphere(f"{path}/origin", 1.3 * radius, STICK, np.eye(4))]
    for i, end in enumerate(ends):
        drawn.append(drawing.rod(f"{path}/stick{i}", np.zeros(3), end, radius, STICK))
        drawn.append(drawing.sphere(f"{path}/end{i}", radius, STICK, drawing.at(end)))
    return drawn


def lost_frame(link: Link, size: float) -> list[bytes]:
    """The frame of a link with missing meshes."""
    return drawing.triad(f"{link_path(link.name)}/frame", FRAME * size)


def shape(path: str, geometry: Geometry, colour: Colour) -> list[bytes]:
    """A primitive of a description at `path`; nothing for a mesh."""
    g, size = geometry.origin, geometry.size
    if geometry.shape == "box":
        return [drawing.box(path, size, colour, g)]
    if geometry.shape == "sphere":
        return [drawing.sphere(path, size[0], colour, g)]
    if geometry.shape == "cylinder":
        return [drawing.cylinder(path, size[0], size[1], colour, g)]
    return _capsule(path, size[0], size[1], colour, g) if geometry.shape == "capsule" else []


def _capsule(path: str, radius: float, length: float, colour: Colour, g: Array) -> list[bytes]:
    drawn = [drawing.cylinder(f"{path}/side", radius, length, colour, g)]
    for name, z in (("bottom", -length / 2), ("top", length / 2)):
        end = g.copy()
        end[:3, 3] += z * g[:3, 2]
        drawn.append(drawing.sphere(f"{path}/{name}", radius, colour, end))
    return drawn
