"""Bodies of an arm's links, for collisions with each other and with the base plane."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from ...description.tree import Description, Geometry, Link
from ...support.checks import Array
from ..pinocchio_model import PinocchioModel, import_pinocchio
from .hull import outer_points

MOST_SHAPES, MOST_PAIRS = 500, 2_000
"""The most shapes and pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"

Pair = tuple[str, str]


class Bodies:
    """The shapes of an arm's moved links and all others, for Pinocchio's collision library.

    A link has its collision shapes, or else its visuals; meshes by `outer_points`. What the joint `first` carries is
    tested against the rest and the base plane, except links of one joint and `exempt` (sorted) pairs.
    """

    def __init__(
        self, model: PinocchioModel, description: Description, base: str, first: str, exempt: frozenset[Pair]
    ) -> None:
        self._pin, self._model = import_pinocchio(), model
        self._geometry = self._pin.GeometryModel()
        self._links: list[str] = []
        self._add(base, GROUND, self._pin.coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0), np.eye(4))
        shapes = sum(len(link.collisions or link.visuals) for link in description.links.values())
        for link in description.links.values() if shapes <= MOST_SHAPES else ():
            for shape, origin in _shapes(self._pin.coal, link):
                self._add(link.name, link.name, shape, origin)
        for one, other in self._pairs(description.beyond(first), exempt):
            self._geometry.addCollisionPair(self._pin.CollisionPair(one, other))
        self._data = self._geometry.createData()

    def overlapping(self, theta: Array) -> frozenset[Pair]:
        """Pairs of links that overlap at theta (n,), and links that reach below the base plane."""
        model, data, geometry = self._model.model, self._model.data, self._geometry
        self._pin.computeCollisions(model, data, geometry, self._data, self._model.q(theta), False)
        hits = np.flatnonzero([result.isCollision() for result in self._data.collisionResults])
        pairs = [geometry.collisionPairs[int(k)] for k in hits]
        return frozenset((self._links[pair.first], self._links[pair.second]) for pair in pairs)

    def _add(self, link: str, name: str, shape: Any, origin: Array) -> None:
        frame = self._model.frame_id(link)
        at = self._model.model.frames[frame]
        placement = at.placement * self._pin.SE3(origin)
        body = self._pin.GeometryObject(f"{len(self._links)}", at.parentJoint, frame, placement, shape)
        self._geometry.addGeometryObject(body)
        self._links.append(name)

    def _pairs(self, moved: frozenset[str], exempt: frozenset[Pair]) -> list[tuple[int, int]]:
        """Indices of the shapes to compare."""
        joints = [body.parentJoint for body in self._geometry.geometryObjects]
        parents, links = self._model.model.parents, self._links
        pairs = [
            (one, other)
            for one, other in combinations(range(len(links)), 2)
            if (links[one] in moved or links[other] in moved)
            and (links[one] == GROUND or joints[one] not in (joints[other], parents[joints[other]]))
            and (links[one] == GROUND or joints[other] != parents[joints[one]])
            and (min(links[one], links[other]), max(links[one], links[other])) not in exempt
        ]
        return pairs if len(pairs) <= MOST_PAIRS else []


def _shapes(coal: Any, link: Link) -> Iterator[tuple[Any, Array]]:
    """The link's shapes as the collision library has them, with their places in the link."""
    for geometry in link.collisions or link.visuals:
        shape = _shape(coal, geometry)
        if shape is not None:
            yield shape, geometry.origin


def _shape(coal: Any, geometry: Geometry) -> Any:
    if geometry.shape == "mesh":
        points = None if geometry.mesh is None else outer_points(geometry.mesh, geometry.size)
        return None if points is None else _hull(coal, points)
    if not all(size > 0.0 for size in geometry.size):
        return None
    kind = {"box": coal.Box, "cylinder": coal.Cylinder, "sphere": coal.Sphere, "capsule": coal.Capsule}[geometry.shape]
    return kind(*geometry.size)


def _hull(coal: Any, points: Array) -> Any:
    corners = coal.StdVec_Vec3s()
    for point in points:
        corners.append(point)
    return coal.Convex.convexHull(corners, True, "Qt")
