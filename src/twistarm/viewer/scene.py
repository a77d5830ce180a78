"""What is drawn of an arm, and where each thing stands at a configuration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arm import Arm
from ..checks import Array
from ..screws import exp
from . import drawing
from .axes import arm_size, draw_rods, draw_screws
from .links import draw_links, load_meshes, mesh_notes
from .nodes import link_path, rod_path, screw_path

Transforms = dict[str, list[float]]


@dataclass(frozen=True)
class Scene:
    """Messages that draw the arm once, in order; the node of each link; what could not be drawn, in words.

    Whatever moves has a node of its own: a configuration is then one matrix per node, {path: (4, 4) by columns}.
    """

    objects: tuple[bytes, ...]
    links: Mapping[str, str]
    notes: tuple[str, ...]


def build_scene(arm: Arm) -> Scene:
    """Draw `arm`: a node per link, a node per screw, and the space and tool frames.

    A mesh that was not found or cannot be read is left out and noted; a link with nothing to draw is a stick from its
    origin to the joints it carries. An arm without a description is drawn as rods between the points of its axes.
    """
    drawing.require_meshcat()
    size = arm_size(arm)
    fixed = (*draw_screws(arm), *_frames(size))
    if arm.description is None:
        return Scene((*draw_rods(arm), *fixed), {}, ())
    meshes = load_meshes(arm.description)
    links = {name: link_path(name) for name in arm.description.links}
    return Scene((*draw_links(arm.description, meshes, size), *fixed), links, mesh_notes(arm.description, meshes))


def transforms(arm: Arm, theta: Array, poses: Mapping[str, Array]) -> Transforms:
    """Where every moving node stands at theta (n,), whose `arm.poses` are `poses`: links and tool exactly there."""
    links = () if arm.description is None else arm.description.links
    placed = {link_path(name): drawing.columns(poses[name]) for name in links}
    for i, g in enumerate(partial_products(arm, theta)):
        placed[screw_path(i)] = drawing.columns(g)
        if arm.description is None:
            placed[rod_path(i)] = drawing.columns(g)
    placed["/frames/tool"] = drawing.columns(poses[arm.tip])
    return placed


def partial_products(arm: Arm, theta: Array) -> list[Array]:
    """Π_{j≤i} exp(ξ_j (A θ)_j) for every moving joint i: what the joints up to i do to space (MLS §3.2)."""
    A, _ = arm.coupling
    steps = exp(arm.screws.T, A @ theta)
    products: list[Array] = []
    g = np.eye(4)
    for step in steps:
        g = g @ step
        products.append(g)
    return products


def _frames(size: float) -> list[bytes]:
    return [*drawing.triad("/frames/space", 0.16 * size), *drawing.triad("/frames/tool", 0.16 * size)]
