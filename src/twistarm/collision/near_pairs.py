"""Which pairs of a scene are near: lower bounds of all distances first, then the few that count are measured."""

from __future__ import annotations

from bisect import insort
from collections.abc import Sequence
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.bodies import Body
from ..arm.checker import Checker
from ..arm.engine import gaps_of
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array
from .swept import ancestors, pair_speeds

ENDLESS = 1e3  # Half the depth of a half-space [m].
LOOK = 0.05  # Pairs nearer than this beyond their margin [m] are always near.
ROUNDING = 1e-6  # What bounds may be too large by rounding, and distances too small by GJK's tolerance [m].

Indices = NDArray[np.signedinteger[Any]]


class NearPairs(Checker):
    """Finds the near pairs of a scene. `speeds` (pairs, n) bounds how fast each coordinate brings a pair closer.

    A distance is at least that of the ball round the smaller body and the rounded box round the larger one. For the
    pairs `exact`, spheres against spheres, capsules, boxes and half-spaces, it is just that.
    """

    def __init__(
        self,
        model: PinocchioModel,
        bodies: Sequence[Body],
        pairs: Sequence[tuple[int, int]],
        margins: Sequence[float],
        most: Array,
    ) -> None:
        super().__init__(model, bodies, pairs, margins)
        self.least, self.dq_dtheta = np.array(self.margins), model.dq_dtheta
        self._looked = self.least + LOOK
        self._cover(most)
        self._slides = bool((pair_speeds(model, bodies, pairs, 2.0 * most + 1.0) > self.speeds).any())
        count = model.model.njoints
        carried = np.array([[j in ancestors(model, body) for j in range(count)] for body in self.bodies], dtype=float)
        first, second = np.array(self.pairs, dtype=int).reshape(-1, 2).T
        self.between = np.zeros((len(self.pairs), model.model.nv))
        for j in range(1, count):
            self.between[:, model.model.idx_vs[j]] = (carried[first] - carried[second])[:, j]
        self._last = 0  # the nearest pair of the last question, likely that of the next
        objects = list(self._geometry.geometryObjects)
        kinds = np.array([type(body.shape).__name__ for body in self.bodies], dtype=str)
        boxes = [body.shape.aabb_local for body in self.bodies]
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
        for rows, each, middle in zip(at, objects, centre, strict=True):
            rows[:, 0], rows[:, 1:] = each.placement.act(middle), each.placement.rotation
        joints, around = [each.parentJoint for each in objects], radius[ball] + edge[box]
        around[~self.exact] += ROUNDING
        self._gaps = gaps_of(joints, at, ball.tolist(), box.tolist(), (half - edge[:, None])[box], around)
        self.exact &= self._gaps is not None

    def _cover(self, most: Array) -> None:
        """Take speeds that hold while |theta| is at most `most` (n,)."""
        self._most = most
        self.speeds = pair_speeds(self._model, self.bodies, self.pairs, most)

    def nearest(self, theta: Array) -> tuple[int, float, Array]:
        """The nearest pair at theta (n,), its distance [m], and its nearest points (2, 3) in Pinocchio's world."""
        q = self._model.q(theta)
        if self._gaps is None:
            best = int(self.distances(q).argmin())
            metres, found = self.measure(self._own().geometry, best)
        else:
            frames, geometry = self._model.joint_frames(q), self.place(q)
            best, metres = self._gaps.nearest(frames, self._last, ROUNDING, lambda k: self.measure(geometry, k)[0])
            self._last, found = best, geometry.distanceResults[best]
        return best, metres, np.array([found.getNearestPoint1(), found.getNearestPoint2()])

    def near(self, theta: Array, reach: Array) -> Near:
        """The pairs at theta (n,) that may be nearer than margin and LOOK, and what they may lose over `reach` (n,)."""
        self._cover_at_least(theta, reach)
        limit = self.speeds.dot(reach)
        limit += self._looked
        q = self._model.q(theta)
        frames = self._model.joint_frames(q)
        pairs, gaps = self._gaps.near(frames, limit)
        return Near(self, q, frames, pairs, gaps, limit.take(pairs))

    def bounds(self, theta: Array, reach: Array | float, pairs: Indices) -> Array:
        """Lower bounds of the distances (k,) [m] of these pairs (k,) at theta (n,), also of the depths of overlaps.

        `speeds` then holds up to `reach` (n,) from theta. Without the compiled core the bounds are -infinity.
        """
        self._cover_at_least(theta, reach)
        if self._gaps is None:
            return np.full(len(pairs), -np.inf)
        low: Array = self._gaps.measure(self._model.joint_frames(self._model.q(theta)), pairs.tolist())[:, 0]
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
        """The distances (k,) [m] of these pairs (k,) at theta (n,), and `approach` (k, n)."""
        q = self._model.q(theta)
        frames, geometry = self._model.joint_frames(q), self.place(q)
        found = [None if self.exact[k] else self.measure(geometry, k) for k in pairs.tolist()]
        return self.approach(q, frames, pairs, found)

    def approach(
        self, q: Array, frames: Array, pairs: Indices, found: Sequence[tuple[float, Any] | None]
    ) -> tuple[Array, Array]:
        """The distances (k,) [m] of these pairs (k,), and -∂distance/∂theta (k, n), by their witness points.

        `frames` are the joint frames at q (nq,). `found` is what `measure` has just given, None for an exact pair.

        Source: Faverjon and Tournassoud, A local based approach for path planning of manipulators with a high number of
        degrees of freedom, ICRA 1987.
        """
        rows = [each and wrench(*each) for each in found]
        if None in rows:
            exact = self._gaps.measure(frames, pairs.tolist()).tolist()
            rows = [each or row for each, row in zip(rows, exact, strict=True)]
        J = self._pin.computeJointJacobians(self._model.model, self._own().data, q)
        numbers = np.array(rows).reshape(-1, 7)
        return numbers[:, 0], (numbers[:, 1:] @ J * self.between.take(pairs, axis=0)) @ self.dq_dtheta

    def place(self, q: Array) -> Any:
        """The geometry of this thread with all bodies where they are at q (nq,)."""
        own = self._own()
        self._pin.updateGeometryPlacements(self._model.model, own.data, self._geometry, own.geometry, q)
        return own.geometry

    def measure(self, geometry: Any, k: int) -> tuple[float, Any]:
        """The distance [m] of pair k where `geometry` has it, negative by the depth of an overlap, and all of it.

        The latter is the geometry's, which the next measure of the pair replaces.
        """
        found = self._pin.computeDistance(self._geometry, geometry, k)
        metres: float = found.min_distance
        if self._solids and any(True for _ in self.enclosed(geometry, (k,))):
            metres = -abs(metres)
        return metres, found

    def _cover_at_least(self, theta: Array, reach: Array | float) -> None:
        if self._slides and ((most := np.abs(theta) + reach) > self._most).any():
            self._cover(np.maximum(2.0 * most, self._most))


def wrench(metres: float, found: Any) -> tuple[float, ...]:
    """A distance [m], its direction (3,) from first body to second, and its moment (3,), by the witness points."""
    (a, b, c), (x, y, z) = found.normal.tolist(), found.getNearestPoint1().tolist()
    if not isfinite(a + b + c + x + y + z):  # overlapping triangles have no depth and no direction
        return metres, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if (metres < 0.0) != (found.min_distance < 0.0):
        a, b, c = -a, -b, -c
    return metres, a, b, c, y * c - z * b, z * a - x * c, x * b - y * a


class Near:
    """Pairs (k,) that may be near at q (nq,), with lower bounds of their distances (k,) [m].

    A pair that is measured has its distance, negative by the depth of an overlap; infinity if it is beyond its limit.
    """

    def __init__(self, among: NearPairs, q: Array, frames: Array, pairs: Indices, low: Array, limit: Array) -> None:
        self.pairs, self.distances = pairs, low
        self._among, self._q, self._frames, self._limit = among, q, frames, limit
        self._measured = among.exact.take(pairs)

    def measure(self, rows: Indices) -> bool:
        """Measure those of these rows that are not. Return whether there was one."""
        new = rows[~self._measured[rows]].tolist()
        if new:
            geometry = self._among.place(self._q)
            for row in new:
                self._measure(geometry, row)
        return bool(new)

    def closest(self, count: int) -> tuple[Indices, Array]:
        """The rows (k,) of the pairs with the least room beyond their margin, at most `count`, and their `approach`."""
        among, closest, geometry = self._among, list[tuple[float, int, Any]](), None
        if not len(self.pairs):
            return self.pairs, np.empty((0, among.dq_dtheta.shape[1]))
        exact, margins = among.exact.take(self.pairs).tolist(), among.least.take(self.pairs)
        low = self.distances - margins
        bounds = low.tolist()
        for row in low.argsort().tolist():
            room, found = bounds[row], None
            if len(closest) == count and room > closest[-1][0]:
                break
            if not exact[row]:
                geometry = geometry or among.place(self._q)
                found = self._measure(geometry, row)
                room = float(self.distances[row] - margins[row])
            if room < inf:
                insort(closest, (room, row, found))
                del closest[count:]
        rows, founds = [row for _, row, _ in closest], [found for _, _, found in closest]
        _, approach = among.approach(self._q, self._frames, self.pairs[rows], founds)
        return np.array(rows), approach

    def _measure(self, geometry: Any, row: int) -> tuple[float, Any]:
        metres, found = self._among.measure(geometry, int(self.pairs[row]))
        self.distances[row] = metres if metres < self._limit[row] else inf
        self._measured[row] = True
        return metres, found
