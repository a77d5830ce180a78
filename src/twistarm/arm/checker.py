"""Bodies and pairs of them in Pinocchio's collision library: overlap, batches on threads, distances."""

from __future__ import annotations

import threading
from collections.abc import Container, Iterable, Iterator, Sequence
from copy import copy
from typing import Any, NamedTuple

import numpy as np

from ..support.checks import Array
from .bodies import Body
from .pinocchio_model import PinocchioModel, import_pinocchio

TOLERANCE = 1e-9  # Of the distance between convex shapes [m].


class _Own(NamedTuple):
    """Data of a thread. They are of the model and of the geometry, with a broad phase on one with few pairs.

    Checkers that differ in their margins share it. It has those of the one that was asked last.
    """

    data: Any
    geometry: Any
    boxes: tuple[Any, Any]
    manager: Any
    callback: Any


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
        self._solids = []
        for k, pair in enumerate(self.pairs):
            for outer, inner in (pair, pair[::-1]):
                solid = self.bodies[outer].solid
                if solid is not None and solid.closed:
                    self._solids.append((k, outer, inner, solid, self.bodies[inner].samples))
        self._kept = [any(self.bodies[i].solid or self.bodies[i].kind == "points" for i in pair) for pair in self.pairs]
        self._shared, self._local = threading.local(), threading.local()
        self._margin_tables: tuple[Array, Array] | None = None

    def with_margins(self, margins: Sequence[float] | Array) -> Checker:
        """The same bodies and pairs with other margins [m].

        Those of kept triangles and voxels are not negative: Coal has none.
        """
        other = copy(self)
        other.margins = tuple(np.maximum(margins, np.where(self._kept, 0.0, -np.inf)).tolist())
        other._local, other._margin_tables = threading.local(), None
        return other

    def collides(self, q: Array) -> bool:
        """Whether some pair overlaps or comes nearer than its margin at q (nq,)."""
        if not self.pairs:
            return False
        own, pin, local = self._own(), self._pin, self._local
        # One call for all three takes half as long again: Boost tries its other signatures first.
        pin.updateGeometryPlacements(self._model.model, own.data, self._geometry, own.geometry, q)
        # The pair that was found last is the first to collide more often than not.
        if pin.computeCollision(self._geometry, own.geometry, getattr(local, "hit", 0)):
            return True
        pin.updateGeometryPlacements(self._model.model, own.data, own.boxes[0], own.boxes[1])
        own.manager.update()
        if own.manager.collide(own.callback):
            local.hit = own.callback.collisionPairIndex
            return True
        return bool(self._solids) and any(True for _ in self.enclosed(own.geometry))

    def batch(self, Q: Array, threads: int) -> Array:
        """`collides` of each row of Q (N, nq), on this many threads: (N,) of bool."""
        if threads == 1 or not self.pairs:
            return np.array([self.collides(q) for q in Q], dtype=bool)
        columns = np.asfortranarray(Q.T)
        found = [self._pin.computeCollisionsInParallel(threads, pool, columns, True) for pool in self._pools(threads)]
        hit = np.any(np.array(found, dtype=bool), axis=0)
        if not self._solids:
            return hit
        return np.array([overlaps or self.collides(q) for overlaps, q in zip(hit, Q, strict=True)])

    def overlapping(self, q: Array) -> list[int]:
        """The indices of the pairs that overlap or come nearer than their margin at q (nq,)."""
        data, geometry, *_ = self._own()
        self._pin.computeCollisions(self._model.model, data, self._geometry, geometry, q, False)
        hit = {k for k, result in enumerate(geometry.collisionResults) if result.isCollision()}
        return sorted(hit.union(self.enclosed(geometry)))

    def distances(self, q: Array, pairs: Sequence[int] | None = None) -> Array:
        """The distances (k,) [m] of these pairs at q (nq,), by default all, negative by the depth of an overlap."""
        data, geometry, *_ = self._own()
        self._pin.updateGeometryPlacements(self._model.model, data, self._geometry, geometry, q)
        chosen = range(len(self.pairs)) if pairs is None else pairs
        metres = np.array([self._pin.computeDistance(self._geometry, geometry, k).min_distance for k in chosen])
        inside = {*self.enclosed(geometry, chosen)}
        return np.where([k in inside for k in chosen], -np.abs(metres), metres)

    def enclosed(self, geometry: Any, pairs: Container[int] | None = None) -> Iterator[int]:
        """Yield those of `pairs`, by default all, with one body inside the closed mesh of the other.

        Bodies are where `geometry` has them. Where their surfaces meet, either answer is possible.
        """
        for k, i, j, solid, samples in self._solids:
            if pairs is None or k in pairs:
                relative = geometry.oMg[i].actInv(geometry.oMg[j]).homogeneous
                if solid.contains(samples @ relative[:3, :3].T + relative[:3, 3]):
                    yield k

    def _own(self) -> _Own:
        own: _Own | None = getattr(self._shared, "own", None)
        if own is None:
            geometry = self._geometry.createData()
            self._ask(geometry, range(len(self.pairs)))
            # The manager reads every pair at each update. One of each body is enough.
            last = {body: k for k, pair in enumerate(self.pairs) for body in pair}
            model = self._with_pairs(sorted({*last.values()}))
            data = model.createData()
            manager = self._pin.BroadPhaseManager_SSaPCollisionManager(self._model.model, model, data)
            callback = self._pin.CollisionCallBackDefault(self._geometry, geometry, True)
            own = self._shared.own = _Own(self._model.data, geometry, (model, data), manager, callback)
            self._shared.asked = None
        if self._shared.asked is not self:
            self._margin_tables = self._margin_tables or self._tables()
            self._shared.asked, (margins, widest) = self, self._margin_tables
            own.geometry.setSecurityMargins(self._geometry, margins, True, False)
            own.boxes[1].setSecurityMargins(own.boxes[0], widest, True, False)
        return own

    def _tables(self) -> tuple[Array, Array]:
        """The margin of each pair (bodies, bodies), and one no less than any of either body.

        The manager widens each box by the largest margin of its pairs.
        """
        first, second = np.array(self.pairs, dtype=int).reshape(-1, 2).T
        margins = np.zeros((len(self.bodies), len(self.bodies)))
        margins[first, second] = margins[second, first] = self.margins
        widest = np.full(len(self.bodies), -np.inf)
        for bodies in (first, second):
            np.maximum.at(widest, bodies, self.margins)
        return np.asfortranarray(margins), np.asfortranarray(np.maximum.outer(widest, widest))

    def _with_pairs(self, pairs: Iterable[int]) -> Any:
        """The geometry with these of the pairs."""
        model = self._pin.GeometryModel()
        for shape in self._geometry.geometryObjects:
            model.addGeometryObject(shape)
        for k in pairs:
            model.addCollisionPair(self._pin.CollisionPair(*self.pairs[k]))
        return model

    def _pools(self, threads: int) -> list[Any]:
        """The data of a batch on this many threads: one with a broad phase, and one for pairs with a plane.

        The broad phase does not widen half-spaces by a margin.
        """
        if getattr(self._local, "threads", 0) != threads:
            flat = [k for k, pair in enumerate(self.pairs) if any(self.bodies[i].kind == "plane" for i in pair)]
            rest = sorted({*range(len(self.pairs))}.difference(flat))
            model = self._with_pairs(rest)
            for shape, body in zip(model.geometryObjects, self.bodies, strict=True):
                shape.disableCollision = body.kind == "plane"
            pools = [self._pin.BroadPhaseManagerPool_DynamicAABBTreeCollisionManager(self._model.model, model, threads)]
            if flat:
                pools.append(self._pin.GeometryPool(self._model.model, self._with_pairs(flat), threads))
            for pool, pairs in zip(pools, (rest, flat), strict=False):
                for data in pool.getGeometryDatas():
                    self._ask(data, pairs)
            self._local.pools, self._local.threads = pools, threads
        return self._local.pools

    def _ask(self, geometry: Any, pairs: Iterable[int]) -> None:
        """Set margins and accuracy of these pairs, by new requests: GJK starts from the centres of the shapes.

        Pinocchio's requests start it from the pair's previous direction. It then misses one deep overlap of cylinders
        in 10,000, and the answer depends on the questions before. The usual tolerance reports gaps of 1e-7 m.
        """
        coal, requests = self._pin.coal, []
        # Kept triangles and voxels have no centre to start from.
        for guess in (coal.GJKInitialGuess.BoundingVolumeGuess, coal.GJKInitialGuess.DefaultGuess):
            requests.append((coal.CollisionRequest(), coal.DistanceRequest()))
            for request in requests[-1]:
                request.gjk_tolerance, request.gjk_initial_guess = TOLERANCE, guess
            requests[-1][0].distance_upper_bound = 0.0
        collisions, distances = geometry.collisionRequests, geometry.distanceRequests
        for k, pair in enumerate(pairs):
            collision, distance = requests[self._kept[pair]]
            collision.security_margin = self.margins[pair]
            collisions[k], distances[k] = collision, distance  # copies
