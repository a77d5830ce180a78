"""Bodies and pairs of them in Pinocchio's collision library: overlap, batches on threads, distances."""

from __future__ import annotations

import threading
from collections.abc import Container, Iterator, Sequence
from copy import copy
from typing import Any

import numpy as np

from ..support.checks import Array
from .bodies import Body
from .pinocchio_model import PinocchioModel, import_pinocchio

MANY = 150  # Bodies from which sorting them along the axes is quicker than all pairs of their boxes.
TOLERANCE = 1e-9  # Of the distance between convex shapes [m].


class Checker:
    """Checks `pairs` of bodies, each with a margin [m], at configurations q of Pinocchio's model.

    Any thread may use it. Each has its own data.
    """

    def __init__(
        self, model: PinocchioModel, bodies: Sequence[Body], pairs: Sequence[tuple[int, int]], margins: Sequence[float]
    ) -> None:
        self._pin = import_pinocchio()
        self._model, self.bodies, self.pairs, self.margins = model, tuple(bodies), tuple(pairs), tuple(margins)
        self._geometry = self._pin.GeometryModel()
        for i, body in enumerate(self.bodies):
            frame = model.frame_id(body.carrier)
            at = model.model.frames[frame]
            placement = at.placement * self._pin.SE3(body.pose)
            self._geometry.addGeometryObject(
                self._pin.GeometryObject(f"{i}", at.parentJoint, frame, placement, body.shape)
            )
        for first, second in self.pairs:
            self._geometry.addCollisionPair(self._pin.CollisionPair(first, second))
        both = ((k, *way) for k, (i, j) in enumerate(self.pairs) for way in ((i, j), (j, i)))
        found = ((k, i, j, self.bodies[i].solid, self.bodies[j].samples) for k, i, j in both)
        self._solids = [(k, i, j, solid, samples) for k, i, j, solid, samples in found if solid and solid.closed]
        self._local = threading.local()

    def with_margins(self, margins: Sequence[float]) -> Checker:
        """The same bodies and pairs with other margins [m]. Those of kept triangles are not negative: Coal has none."""
        other = copy(self)
        least = (0.0 if any(self.bodies[i].solid for i in pair) else -np.inf for pair in self.pairs)
        other.margins, other._local = tuple(map(max, margins, least)), threading.local()
        return other

    def collides(self, q: Array) -> bool:
        """Whether some pair overlaps or comes nearer than its margin at q (nq,)."""
        if not self.pairs:
            return False
        data, geometry, manager = self._own()
        hit: bool = self._pin.computeCollisions(self._model.model, data, manager, q, True)
        return hit or any(True for _ in self.enclosed(geometry))

    def batch(self, Q: Array, threads: int) -> Array:
        """`collides` of each row of Q (N, nq), on this many threads: (N,) of bool."""
        if not self.pairs:
            return np.zeros(len(Q), dtype=bool)
        pool = self._pool(threads)
        found = self._pin.computeCollisionsInParallel(threads, pool, np.asfortranarray(Q.T), True)
        hit = np.asarray(found, dtype=bool)
        return np.array([each or self.collides(q) for each, q in zip(hit, Q, strict=True)]) if self._solids else hit

    def overlapping(self, q: Array) -> list[int]:
        """The indices of the pairs that overlap or come nearer than their margin at q (nq,)."""
        data, geometry, _ = self._own()
        self._pin.computeCollisions(self._model.model, data, self._geometry, geometry, q, False)
        hit = {k for k, result in enumerate(geometry.collisionResults) if result.isCollision()}
        return sorted(hit.union(self.enclosed(geometry)))

    def distances(self, q: Array) -> Array:
        """The distance [m] of each pair at q (nq,), negative by the depth of an overlap."""
        data, geometry, _ = self._own()
        self._pin.computeDistances(self._model.model, data, self._geometry, geometry, q)
        metres = np.array([result.min_distance for result in geometry.distanceResults])
        inside = [*self.enclosed(geometry)]
        metres[inside] = -np.abs(metres[inside])
        return metres

    def points(self, k: int) -> Array:
        """The nearest points (2, 3) of pair k in Pinocchio's world, after `distances` in the same thread."""
        result = self._own()[1].distanceResults[k]
        return np.array([result.getNearestPoint1(), result.getNearestPoint2()])

    def enclosed(self, geometry: Any, pairs: Container[int] | None = None) -> Iterator[int]:
        """Yield those of `pairs`, by default all, of which a body is inside the closed mesh of the other one.

        Bodies are where `geometry` has them. Where their surfaces meet, either answer is possible.
        """
        for k, i, j, solid, samples in self._solids:
            if pairs is None or k in pairs:
                relative = geometry.oMg[i].actInv(geometry.oMg[j]).homogeneous
                if solid.contains(samples @ relative[:3, :3].T + relative[:3, 3]):
                    yield k

    def _own(self) -> tuple[Any, Any, Any]:
        """The thread's data of the model, of the geometry, and the broadphase manager."""
        own: tuple[Any, Any, Any] | None = getattr(self._local, "own", None)
        if own is None:
            geometry = self._geometry.createData()
            self._ask(geometry)
            kind = "Naive" if len(self.bodies) < MANY else "SSaP"
            manager = getattr(self._pin, f"BroadPhaseManager_{kind}CollisionManager")(
                self._model.model, self._geometry, geometry
            )
            own = self._local.own = (self._model.data, geometry, manager)
        return own

    def _pool(self, threads: int) -> Any:
        """The data of a batch on this many threads."""
        if getattr(self._local, "threads", 0) != threads:
            # Pools of broadphase managers do not widen half-spaces by a margin.
            self._local.pool = self._pin.GeometryPool(self._model.model, self._geometry, threads)
            self._local.threads = threads
            for data in self._local.pool.getGeometryDatas():
                self._ask(data)
        return self._local.pool

    def _ask(self, geometry: Any) -> None:
        """Set margins and accuracy, by new requests: GJK starts from the centres of the shapes.

        Pinocchio's requests start it from the pair's previous direction. It then misses one deep overlap of cylinders
        in 10,000, and the answer depends on the questions before. The usual tolerance reports gaps of 1e-7 m.
        """
        coal = self._pin.coal
        collision, distance = coal.CollisionRequest(), coal.DistanceRequest()
        guesses = coal.GJKInitialGuess.BoundingVolumeGuess, coal.GJKInitialGuess.DefaultGuess
        collision.distance_upper_bound = 0.0
        collisions, distances = geometry.collisionRequests, geometry.distanceRequests
        for k, (margin, pair) in enumerate(zip(self.margins, self.pairs, strict=True)):
            kept = any(self.bodies[i].solid for i in pair)  # a triangle of a mesh has no centre to start from
            for request in (collision, distance):
                request.gjk_tolerance, request.gjk_initial_guess = TOLERANCE, guesses[kept]
            collision.security_margin = margin
            collisions[k], distances[k] = collision, distance  # copies
