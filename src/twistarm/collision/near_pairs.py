"""The near pairs of a scene. All distances are bounded from below first, then the few that count are measured."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm import engine
from ..arm.checker import TOLERANCE, Checker
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array
from .swept import ancestors, pair_speeds

ENDLESS = 1e3  # Half the depth of a half-space [m].
LOOK = 0.05  # Pairs nearer than this beyond their margin [m] are always near.
UNIT = 1e-6  # The square of a direction differs from 1 by no more.
GJK_TOL = 1e-6  # What bounds may be too large by rounding, and distances too small by GJK's tolerance [m].

Indices = NDArray[np.signedinteger[Any]]


class NearPairs(Checker):
    """Finds the near pairs of a scene. `speeds` (k, n) bounds how fast each coordinate brings a pair closer.

    Each part of a cloud's tile counts as a body. `body_pairs` (k,) are these pairs, as places among `bodies`.

    A distance is bounded from below. The bound takes a ball round the smaller body and a rounded box round the larger
    one. For the pairs `exact`, spheres against spheres, capsules, boxes and half-spaces, it is just that.
    """

    def __init__(self, model: PinocchioModel, checker: Checker, most: Array) -> None:
        super().__init__(model, checker.bodies, checker.pairs, checker.margins)
        parts = [getattr(body.shape, "parts", None) or [body.shape] for body in self.bodies]
        self._shapes = shapes = [part for of_body in parts for part in of_body]
        counts = np.array([len(of_body) for of_body in parts], dtype=int)
        body_of = np.repeat(np.arange(len(parts)), counts)
        # The pair of bodies, and the two shapes, of each pair of parts.
        sides = np.array(self.pairs, dtype=int).reshape(-1, 2).T
        products = counts[sides].prod(axis=0)
        self._owner = np.repeat(np.arange(len(products)), products)
        place = np.arange(len(self._owner)) - np.repeat(np.cumsum(products) - products, products)
        (begin, other), across = (np.cumsum(counts) - counts)[sides][:, self._owner], counts[sides[1]][self._owner]
        self._first, self._second = first, second = begin + place // across, other + place % across
        self.body_pairs = np.column_stack([body_of[first], body_of[second]])
        # What is measured by Coal itself: pairs with a part of a body.
        self._parted = (counts[self.body_pairs] > 1).any(axis=1)
        self._request = self._pin.coal.DistanceRequest()
        self._request.gjk_tolerance = TOLERANCE
        self.least = np.array(self.margins)[self._owner]
        self._looked = self.least + LOOK
        self._cover(most)
        self._slides = bool(
            (pair_speeds(model, self.bodies, self.pairs, 2.0 * most + 1.0)[self._owner] > self.speeds).any()
        )
        self._last = 0  # the nearest pair of the last question, likely that of the next
        objects = [self._geometry.geometryObjects[i] for i in body_of.tolist()]
        kinds = np.array([type(shape).__name__ for shape in shapes], dtype=str)
        boxes = [shape.aabb_local for shape in shapes]
        low = np.array([box.min_ for box in boxes]).reshape(-1, 3)
        high = np.array([box.max_ for box in boxes]).reshape(-1, 3)
        flat, balls = kinds == "Halfspace", kinds == "Sphere"
        low[flat], high[flat] = (-ENDLESS, -ENDLESS, -2.0 * ENDLESS), (ENDLESS, ENDLESS, 0.0)
        half, centre = 0.5 * (high - low), 0.5 * (low + high)
        edge = np.where(balls | (kinds == "Capsule"), half.min(axis=1, initial=np.inf), 0.0)
        half[flat, :2] = np.inf
        radius = np.where(balls, edge, np.linalg.norm(half, axis=1))
        # The ball of a sphere, or else of the smaller body of a pair, and the box of the other.
        rank = np.where(balls, radius - ENDLESS, radius)
        swapped = rank[first] > rank[second]
        ball, box = np.where(swapped, second, first), np.where(swapped, first, second)
        self.exact = balls[ball] & np.isin(kinds, ("Sphere", "Capsule", "Box", "Halfspace"))[box]
        # [p R] of each box in the frame of its joint.
        at = np.empty((len(objects), 3, 4))
        for rows, body, middle in zip(at, objects, centre, strict=True):
            rows[:, 0], rows[:, 1:] = body.placement.act(middle), body.placement.rotation
        joints, around = [body.parentJoint for body in objects], radius[ball] + edge[box]
        around[~self.exact] += GJK_TOL
        sizes = np.column_stack([(half - edge[:, None])[box], around, self.exact])
        motion = self._motion(*self.body_pairs.T)
        self._gaps = engine.asked("Gaps", joints, at, ball.tolist(), box.tolist(), sizes, *motion)
        self.exact &= self._gaps is not None
        self._all_exact = bool(self.exact.all())

    def _cover(self, most: Array) -> None:
        """Take speeds that hold while |theta| is at most `most` (n,)."""
        self.speeds = pair_speeds(self._model, self.bodies, self.pairs, most)[self._owner]
        self._most = most  # last: another thread may then use the speeds

    def _motion(self, first: Indices, second: Indices) -> tuple[Array, Array, Array]:
        """Each joint's twist (m, 6) in its own frame, which bodies of pairs it carries (k, m), and dq/dtheta (m, n)."""
        pin, model, data = self._pin, self._model.model, self._model.data
        joints, own = range(1, model.njoints), pin.ReferenceFrame.LOCAL
        pin.computeJointJacobians(model, data, pin.neutral(model))
        # A model with one joint has Jacobians of shape (6,).
        twists = [pin.getJointJacobian(model, data, j, own).reshape(6, -1)[:, j - 1] for j in joints]
        carried = np.array([[j in ancestors(self._model, body) for j in joints] for body in self.bodies], dtype=float)
        carried = carried.reshape(-1, len(joints))
        return np.array(twists), carried[first] - carried[second], np.ascontiguousarray(self._model.dq_dtheta)

    def nearest(self, theta: Array) -> tuple[int, float, Array]:
        """The nearest pair at theta (n,), its distance [m], and its nearest points (2, 3) in Pinocchio's world."""
        q = self._model.q(theta)
        geometry = self.place(q)
        if self._gaps is None:
            best = int(np.argmin([self.measure(geometry, k)[0] for k in range(len(self.body_pairs))]))
            metres, found = self.measure(geometry, best)
        else:
            frames = self._model.joint_frames(q)
            best, metres = self._gaps.nearest(frames, self._last, GJK_TOL, lambda k: self.measure(geometry, k)[0])
            self._last = best
            parted = self._parted[best]
            found = self.measure(geometry, best)[1] if parted else geometry.distanceResults[int(self._owner[best])]
        return best, metres, np.array([found.getNearestPoint1(), found.getNearestPoint2()])

    def near(self, theta: Array, reach: Array, count: int) -> Near:
        """The pairs at theta (n,) that may be nearer than margin and LOOK.

        What they may lose over `reach` (n,) counts too. At most `count` with the least room beyond their margins are
        measured.
        """
        self._cover_at_least(theta, reach)
        limits = self.speeds.dot(reach)
        limits += self._looked
        return self._near(self._model.q(theta), limits, count)

    def bounds(self, theta: Array, reach: Array | float, pairs: Indices) -> Array:
        """Lower bounds of the distances (k,) [m] of these pairs (k,) at theta (n,). An overlap has a negative distance.

        `speeds` then holds up to `reach` (n,) from theta. Without the compiled core the bounds are -infinity.
        """
        self._cover_at_least(theta, reach)
        if self._gaps is None:
            return np.full(len(pairs), -np.inf)
        low: Array = self._gaps.gaps(self._model.joint_frames(self._model.q(theta)), pairs.tolist())
        return low

    def distances_of(self, theta: Array, pairs: Indices) -> Array:
        """The distances (k,) [m] of these pairs (k,) at theta (n,), without their directions."""
        exact = self.exact.take(pairs).tolist()
        metres = self.bounds(theta, 0.0, pairs) if True in exact else np.empty(len(pairs))
        if False in exact:
            geometry = self.place(self._model.q(theta))
            for row, k in enumerate(pairs.tolist()):
                if not exact[row]:
                    metres[row] = self.measure(geometry, k)[0]
        return metres

    def measured(self, theta: Array, pairs: Indices) -> tuple[Array, Array]:
        """The distances (k,) [m] of these pairs (k,) at theta (n,), and -∂distance/∂theta (k, n).

        Source: Faverjon and Tournassoud, A local based approach for path planning of manipulators with a high number of
        degrees of freedom, ICRA 1987.
        """
        limits = np.full(len(self.body_pairs), -np.inf)
        limits[pairs] = np.inf
        found = self._near(self._model.q(theta), limits, len(pairs))
        rows = {k: row for row, k in enumerate(found.pairs[found.closest].tolist())}
        order = [rows[k] for k in pairs.tolist()]
        return found.distances[found.closest[order]], found.approach[order]

    def _near(self, q: Array, limits: Array, count: int) -> Near:
        frames, measure = self._model.joint_frames(q), self._measure_at(q)
        return Near(self, q, limits, *self._gaps.closest(frames, limits, self.least, count, measure))

    def _measure_at(self, q: Array) -> Callable[[int], tuple[float, ...]]:
        """Measure a pair at q (nq,): its distance [m], the direction (3,) from first body to second, its moment."""
        geometry = None if self._all_exact else self.place(q)

        def measure(k: int) -> tuple[float, ...]:
            metres, found = self.measure(geometry, k)
            (a, b, c), (x, y, z) = found.normal.tolist(), found.getNearestPoint1().tolist()
            if not abs(a * a + b * b + c * c - 1.0) <= UNIT:  # between triangles and triangles Coal tells none
                if not found.min_distance > 0.0:  # nor have they a depth where they overlap
                    return metres, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
                a, b, c = ((found.getNearestPoint2() - (x, y, z)) / found.min_distance).tolist()
            if (metres < 0.0) != (found.min_distance < 0.0):
                a, b, c = -a, -b, -c
            return metres, a, b, c, y * c - z * b, z * a - x * c, x * b - y * a

        return measure

    def place(self, q: Array) -> Any:
        """The geometry of this thread with all bodies where they are at q (nq,)."""
        try:
            data, geometry = self._local.placed
        except AttributeError:  # it needs no broad phase
            data, geometry = self._local.placed = self._model.data, self._geometry.createData()
            self._ask(geometry, range(len(self.pairs)))
        self._pin.updateGeometryPlacements(self._model.model, data, self._geometry, geometry, q)
        return geometry

    def measure(self, geometry: Any, k: int) -> tuple[float, Any]:
        """The distance [m] of pair k where `geometry` has it, and Coal's result. An overlap has a negative distance.

        The result is the geometry's. The next measure of the pair replaces it.
        """
        owner = int(self._owner[k])
        if self._parted[k]:
            coal, sides = self._pin.coal, []
            for body, part in zip(self.pairs[owner], (self._first[k], self._second[k]), strict=True):
                g = geometry.oMg[body]
                sides += [self._shapes[part], coal.Transform3s(g.rotation, g.translation)]
            found = coal.DistanceResult()
            coal.distance(*sides, self._request, found)
        else:
            found = self._pin.computeDistance(self._geometry, geometry, owner)
        metres: float = found.min_distance
        if self._solids and any(True for _ in self.enclosed(geometry, (owner,))):
            metres = -abs(metres)
        return metres, found

    def _cover_at_least(self, theta: Array, reach: Array | float) -> None:
        if self._slides and ((most := np.abs(theta) + reach) > self._most).any():
            self._cover(np.maximum(2.0 * most, self._most))


class Near:
    """Pairs (k,) that may be near at q (nq,), with lower bounds of their distances (k,) [m].

    A pair that is measured has its distance, negative by the depth of an overlap. Beyond its limit it has infinity.
    `closest` (c,) are the rows of those with the least room. `approach` (c, n) is their -∂distance/∂theta.
    """

    def __init__(
        self,
        among: NearPairs,
        q: Array,
        limits: Array,
        pairs: Indices,
        distances: Array,
        measured: NDArray[np.bool_],
        closest: Indices,
        approach: Array,
    ) -> None:
        self.pairs, self.distances, self.closest, self.approach = pairs, distances, closest, approach
        self._among, self._q, self._limits, self._measured = among, q, limits, measured

    def measure(self, rows: Indices) -> bool:
        """Measure those of these rows that are not. Return whether there was one."""
        new = rows[~self._measured[rows]].tolist()
        if new:
            geometry = self._among.place(self._q)
            for row in new:
                k = self.pairs[row]
                metres = self._among.measure(geometry, int(k))[0]
                self.distances[row], self._measured[row] = metres if metres < self._limits[k] else inf, True
        return bool(new)
