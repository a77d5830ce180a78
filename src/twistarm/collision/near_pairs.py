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
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array
from .swept import ancestors, pair_speeds

ENDLESS = 1e3  # Half the size [m] of a plane without end.
LOOK = 0.05  # Pairs nearer than this beyond their margin [m] are always near.
FEW = 40  # So many pairs of other shapes than spheres are measured sooner than bounded.
WORLD = np.eye(3, 4, 1)[None]  # [p R] of the world.
ROUNDING = 1e-6  # What bounds may be too large by rounding, and distances too small by GJK's tolerance [m].

Indices = NDArray[np.signedinteger[Any]]


class NearPairs(Checker):
    """Finds the near pairs of a scene. `speeds` (pairs, n) bounds how fast each coordinate brings a pair closer.

    A distance is at least that of the ball round the smaller body and the rounded box round the larger one. For balls
    against balls, capsules, boxes and planes it is just that.
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
        objects = list(self._geometry.geometryObjects)
        self._joints = np.array([each.parentJoint for each in objects], dtype=int)
        boxes = [body.shape.aabb_local for body in self.bodies]
        low = np.array([box.min_ for box in boxes]).reshape(-1, 3).clip(-ENDLESS, ENDLESS)
        high = np.array([box.max_ for box in boxes]).reshape(-1, 3).clip(-ENDLESS, ENDLESS)
        half, centre = 0.5 * (high - low), 0.5 * (low + high)
        kinds = np.array([type(body.shape).__name__ for body in self.bodies], dtype=str)
        balls = kinds == "Sphere"
        edge = np.where(balls | (kinds == "Capsule"), half.min(axis=1, initial=np.inf), 0.0)
        radius = np.where(balls, edge, np.linalg.norm(half, axis=1))
        # [1 0; c R] puts the centre c and the axes R of each box into frames [p R].
        self._at = np.zeros((len(objects), 4, 4))
        for at, each, middle in zip(self._at, objects, centre, strict=True):
            at[0, 0], at[1:, 0], at[1:, 1:] = 1.0, each.placement.act(middle), each.placement.rotation
        # The ball of a sphere, or else of the smaller body of a pair, and the box of the other.
        rank = np.where(balls, radius - ENDLESS, radius)
        swapped = rank[first] > rank[second]
        self._ball, self._box = np.where(swapped, second, first), np.where(swapped, first, second)
        self._half = (half - edge[:, None])[self._box].T.copy()
        self._radius = radius[self._ball] + edge[self._box]
        endless = np.where(self._half.max(axis=0, initial=0.0) < 0.5 * ENDLESS, 0.0, np.inf)
        self._balls = self._radius + np.linalg.norm(self._half, axis=0) + endless + ROUNDING
        # The way between the centres of a pair is joint_frames @ ways[0] + ways[1].
        centres = np.zeros((count, 4, len(objects)))
        centres[self._joints, :, np.arange(len(objects))] = self._at[:, :, 0]
        ways = centres[:, :, self._ball] - centres[:, :, self._box]
        self._ways = ways[1:].reshape(4 * (count - 1), len(self.pairs)), ways[0, 1:]
        quick = balls[self._ball] & np.isin(kinds, ("Sphere", "Capsule", "Box", "Halfspace"))[self._box]
        self._all_at_once = len(quick) - quick.sum() < FEW and not self._solids

    def _cover(self, most: Array) -> None:
        """Take speeds that hold while |theta| is at most `most` (n,)."""
        self._most = most
        self.speeds = pair_speeds(self._model, self.bodies, self.pairs, most)
        self._fastest = self.speeds.max(axis=0, initial=0.0)

    def nearest(self, theta: Array) -> tuple[int, float, Array]:
        """The nearest pair at theta (n,), its distance [m], and its nearest points (2, 3) in Pinocchio's world."""
        data, geometry, *_ = self._own()
        self._local.at = None
        if self._all_at_once:
            q = self._model.q(theta)
            best = self._pin.computeDistances(self._model.model, data, self._geometry, geometry, q)
            found = geometry.distanceResults[best]
            metres = found.min_distance
        else:
            # The distance of two balls is a bound that takes three operations, and few pairs more are measured.
            way = self._model.joint_frames(self._model.q(theta)) @ self._ways[0]
            way += self._ways[1]
            low = np.sqrt(np.einsum("ip,ip->p", way, way)) - self._balls
            self._pin.updateGeometryPlacements(self._model.model, data, self._geometry, geometry)
            bounds, metres, best, found = low.tolist(), inf, 0, None
            for k in low.argsort().tolist():
                if bounds[k] > metres:
                    break
                result = self._pin.computeDistance(self._geometry, geometry, k)
                distance = result.min_distance if not self._solids else self.measure(geometry, k)[0]
                if found is None or distance < metres or (distance == metres and k < best):
                    metres, best, found = distance, k, result
        return best, metres, np.array([found.getNearestPoint1(), found.getNearestPoint2()])

    def near(self, theta: Array, reach: Array) -> Near:
        """The pairs at theta (n,) that may be nearer than margin and LOOK, and what they may lose over `reach` (n,)."""
        low = self.bounds(theta, reach)
        limit = self.speeds.dot(reach)
        limit += self._looked
        maybe = (low < limit).nonzero()[0]
        return Near(self, theta.copy(), maybe, low.take(maybe), limit.take(maybe))

    def bounds(self, theta: Array, reach: Array | float = 0.0) -> Array:
        """Lower bounds (pairs,) of the distances [m] at theta (n,), also of the depths of overlaps.

        They come from a configuration nearby, kept for each thread. `speeds` then holds up to `reach` (n,) from theta.
        """
        if self._slides and ((far := np.abs(theta) + reach) > self._most).any():
            self._cover(np.maximum(2.0 * far, self._most))
        seen = getattr(self._local, "seen", None)
        if seen is None or self._fastest.dot(moved := np.abs(theta - seen[0])) > LOOK:
            seen = self._local.seen = theta.copy(), self._gaps(theta) - ROUNDING
            return seen[1].copy()
        low: Array = seen[1] - self.speeds.dot(moved)
        return low

    def _gaps(self, theta: Array) -> Array:
        """The bounds from theta (n,) itself."""
        # `take` needs a third of the time of an index, and there are many pairs.
        frames = self._model.joint_frames(self._model.q(theta)).reshape(3, -1, 4).transpose(1, 0, 2)
        at = np.concatenate([WORLD, frames]).take(self._joints, axis=0) @ self._at
        centres = np.ascontiguousarray(at[:, :, 0])
        way = centres.take(self._ball, axis=0) - centres.take(self._box, axis=0)
        beyond = np.einsum("pij,pi->jp", at.take(self._box, axis=0)[:, :, 1:], way)
        np.abs(beyond, out=beyond)
        beyond -= self._half
        inside = np.minimum(beyond.max(axis=0), 0.0)
        np.maximum(beyond, 0.0, out=beyond)
        gaps: Array = np.sqrt(np.einsum("jp,jp->p", beyond, beyond)) + inside - self._radius
        return gaps

    def measured(self, theta: Array, pairs: Indices) -> tuple[Array, Array]:
        """The distances (k,) [m] of these pairs (k,) at theta (n,), and `approach` (k, n); see `Near`."""
        found = Near(self, theta, pairs, np.zeros(len(pairs)), np.full(len(pairs), np.inf))
        every = np.arange(len(pairs))
        found.measure(every)
        return found.distances, found.approach(every)

    def place(self, theta: Array) -> tuple[Any, Any]:
        """Pinocchio's data at theta with the Jacobians, and the geometry's with all bodies in their places.

        Theta may not change afterwards: the same array again is where they are.
        """
        data, geometry, *_ = self._own()
        if getattr(self._local, "at", None) is theta:
            return data, geometry
        self._local.at = theta
        self._pin.computeJointJacobians(self._model.model, data, self._model.q(theta))
        self._pin.updateGeometryPlacements(self._model.model, data, self._geometry, geometry)
        return data, geometry

    def measure(self, geometry: Any, k: int) -> tuple[float, Any]:
        """The distance [m] of pair k where `geometry` has it, negative by the depth of an overlap, and all of it."""
        found = self._pin.computeDistance(self._geometry, geometry, k)
        metres: float = found.min_distance
        if self._solids and any(True for _ in self.enclosed(geometry, (k,))):
            metres = -abs(metres)
        return metres, found

    def distances_of(self, theta: Array, pairs: Indices) -> list[float]:
        """The distances [m] of these pairs (k,) at theta (n,), without their directions."""
        _, geometry = self.place(theta)
        return [self.measure(geometry, k)[0] for k in pairs.tolist()]


class Near:
    """Pairs (k,) that may be near at theta (n,), with lower bounds of their distances (k,) [m].

    A pair that is measured has its distance, negative by the depth of an overlap; infinity if it is beyond its limit.
    """

    def __init__(self, among: NearPairs, theta: Array, pairs: Indices, low: Array, limit: Array) -> None:
        self.pairs, self.distances = pairs, low
        self._among, self._theta, self._limit = among, theta, limit
        self._found: dict[int, tuple[float, Any]] = {}

    def measure(self, rows: Indices) -> bool:
        """Measure those of these rows that are not. Return whether there was one."""
        new = [row for row in rows.tolist() if row not in self._found]
        if new:
            _, geometry = self._among.place(self._theta)
            for row in new:
                self._measure(geometry, row)
        return bool(new)

    def closest(self, count: int) -> Indices:
        """The rows of the pairs with the least room beyond their margins, at most `count`; they are measured."""
        if not len(self.pairs):
            return self.pairs
        margins = self._among.least.take(self.pairs)
        low, (_, geometry) = self.distances - margins, self._among.place(self._theta)
        bounds, closest = low.tolist(), list[tuple[float, int]]()
        for row in low.argsort().tolist():
            if len(closest) == count and bounds[row] > closest[-1][0]:
                break
            if row not in self._found:
                self._measure(geometry, row)
            if self.distances[row] < inf:
                insort(closest, (float(self.distances[row] - margins[row]), row))
                del closest[count:]
        return np.array([row for _, row in closest], dtype=int)

    def approach(self, rows: Indices) -> Array:
        """−∂distance/∂theta (k, n) of measured rows (k,), by the witness points of the distance.

        Source: Faverjon and Tournassoud, A local based approach for path planning of manipulators with a high number of
        degrees of freedom, ICRA 1987.
        """
        wrenches = []
        for row in rows.tolist():
            metres, found = self._found[row]
            (a, b, c), (x, y, z) = found.normal.tolist(), found.getNearestPoint1().tolist()
            if (metres < 0.0) != (found.min_distance < 0.0):
                a, b, c = -a, -b, -c
            wrenches.append((a, b, c, y * c - z * b, z * a - x * c, x * b - y * a))
        # Overlapping triangles have no depth and no direction.
        forces = np.array(wrenches).reshape(-1, 6)
        if not isfinite(forces.sum()):
            forces[~np.isfinite(forces).all(axis=1)] = 0.0
        among, pairs, (data, _) = self._among, self.pairs[rows], self._among.place(self._theta)
        approach: Array = (forces @ data.J * among.between[pairs]) @ among.dq_dtheta
        return approach

    def _measure(self, geometry: Any, row: int) -> None:
        self._found[row] = self._among.measure(geometry, int(self.pairs[row]))
        metres = self._found[row][0]
        self.distances[row] = metres if metres < self._limit[row] else inf
