"""Pairs of bodies that are near: their distances, and how the coordinates bring them closer."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.bodies import Body
from ..arm.checker import Checker
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array
from .swept import ancestors, pair_speeds

ENDLESS = 1e3
"""Half the size [m] of a plane without end."""

LOOK = 0.05
"""Pairs nearer than this beyond their margin [m] are always near."""


Indices = NDArray[np.signedinteger[Any]]


class Near(NamedTuple):
    """Pairs (k,) at theta: their distances (k,) [m], negative by the depth of an overlap, and `approach` (k, n).

    approach: −∂distance/∂theta, by the witness points of the distance. Source: Faverjon and Tournassoud, A local based
    approach for path planning of manipulators with a high number of degrees of freedom, ICRA 1987.
    """

    pairs: Indices
    distances: Array
    approach: Array


class NearPairs(Checker):
    """Finds the near pairs of a scene. `speeds` (pairs, n) bounds how fast each coordinate brings a pair closer."""

    def __init__(
        self,
        model: PinocchioModel,
        bodies: Sequence[Body],
        pairs: Sequence[tuple[int, int]],
        margins: Sequence[float],
        most: Array,
    ) -> None:
        super().__init__(model, bodies, pairs, margins)
        self.least = np.array(self.margins)
        self._cover(most)
        count = model.model.njoints
        carried = np.array([[j in ancestors(model, body) for j in range(count)] for body in self.bodies], dtype=float)
        first, second = np.array(self.pairs, dtype=int).reshape(-1, 2).T
        self._between = np.zeros((len(self.pairs), model.model.nv))
        for j in range(1, count):
            self._between[:, model.model.idx_vs[j]] = (carried[first] - carried[second])[:, j]
        objects = list(self._geometry.geometryObjects)
        self._joints = np.array([each.parentJoint for each in objects], dtype=int)
        boxes = [body.shape.aabb_local for body in self.bodies]
        low = np.array([box.min_ for box in boxes]).reshape(-1, 3).clip(-ENDLESS, ENDLESS)
        high = np.array([box.max_ for box in boxes]).reshape(-1, 3).clip(-ENDLESS, ENDLESS)
        self._at = np.array([each.placement.homogeneous for each in objects]).reshape(-1, 4, 4)
        self._at[:, :3, 3] += np.einsum("bij,bj->bi", self._at[:, :3, :3], 0.5 * (low + high))
        half = 0.5 * (high - low)
        radius = np.linalg.norm(half, axis=1)
        # The sphere of the smaller body of a pair, and the box of the larger one.
        swapped = radius[first] > radius[second]
        self._ball, self._box = np.where(swapped, second, first), np.where(swapped, first, second)
        self._half, self._radius = half[self._box], radius[self._ball]

    def _cover(self, most: Array) -> None:
        """Take speeds that hold while |theta| is at most `most` (n,)."""
        self._most = most
        self.speeds = pair_speeds(self._model, self.bodies, self.pairs, most)
        self._fastest = self.speeds.max(axis=0, initial=0.0)

    def near(self, theta: Array, reach: Array) -> Near:
        """The pairs at theta (n,) that are nearer than margin and LOOK, and what they may lose over `reach` (n,).

        Lower bounds from a configuration nearby, kept for each thread, leave far pairs out.
        """
        far = np.abs(theta) + reach
        if (far > self._most).any():
            self._cover(np.maximum(2.0 * far, self._most))
        seen = getattr(self._local, "seen", None)
        if seen is None or self._fastest @ np.abs(theta - seen[0]) > LOOK:
            seen = self._local.seen = (theta, self._gaps(theta) - self.least - LOOK)
        maybe = np.flatnonzero(seen[1] < self.speeds @ (np.abs(theta - seen[0]) + reach))
        if not len(maybe):
            return Near(maybe, np.empty(0), np.empty((0, len(theta))))
        found = self.measured(theta, maybe)
        close = found.distances < self.least[maybe] + LOOK + self.speeds[maybe] @ reach
        return found if close.all() else Near(maybe[close], found.distances[close], found.approach[close])

    def _gaps(self, theta: Array) -> Array:
        """Lower bounds (pairs,) of the distances [m] at theta (n,): from a sphere to a box, and measured where near."""
        data = self._placed(theta)
        at = np.array([data.oMi[j].homogeneous for j in range(self._model.model.njoints)])[self._joints] @ self._at
        way = at[self._ball, :3, 3] - at[self._box, :3, 3]
        beyond = np.abs(np.einsum("pij,pi->pj", at[self._box, :3, :3], way)) - self._half
        gaps: Array = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=1)) - self._radius
        close = np.flatnonzero(gaps < self.least + 4.0 * LOOK)
        gaps[close] = self._measured(data, close).distances
        return gaps

    def measured(self, theta: Array, pairs: Indices) -> Near:
        """These pairs (k,) at theta (n,)."""
        return self._measured(self._placed(theta), pairs)

    def distances_of(self, theta: Array, pairs: Indices) -> list[float]:
        """The distances [m] of these pairs (k,) at theta (n,), without their directions.

        Args:
            theta: The configuration (n,).
            pairs: Which pairs.
        """
        geometry, pin = self._own()[1], self._pin
        pin.updateGeometryPlacements(
            self._model.model, self._model.data, self._geometry, geometry, self._model.q(theta)
        )
        return [pin.computeDistance(self._geometry, geometry, k).min_distance for k in pairs.tolist()]

    def _placed(self, theta: Array) -> Any:
        """Pinocchio's data at theta, with the Jacobians and all bodies in their places."""
        data, geometry, _ = self._own()
        self._pin.computeJointJacobians(self._model.model, data, self._model.q(theta))
        self._pin.updateGeometryPlacements(self._model.model, data, self._geometry, geometry)
        return data

    def _measured(self, data: Any, pairs: Indices) -> Near:
        geometry, distances, wrenches = self._own()[1], [], []
        for k in pairs.tolist():
            found = self._pin.computeDistance(self._geometry, geometry, k)
            (a, b, c), (x, y, z) = found.normal.tolist(), found.getNearestPoint1().tolist()
            distances.append(found.min_distance)
            wrench = (a, b, c, y * c - z * b, z * a - x * c, x * b - y * a)
            # Overlapping triangles have no depth and no direction.
            wrenches.append(wrench if isfinite(sum(wrench)) else (0.0,) * 6)
        approach = (np.array(wrenches).reshape(-1, 6) @ data.J * self._between[pairs]) @ self._model.dq_dtheta
        return Near(pairs, np.array(distances), approach)
