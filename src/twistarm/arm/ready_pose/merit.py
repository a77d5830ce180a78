"""The merit of configurations: a table of costs for a singularity and for the stance of the arm.

The stance is the arm drawn as a line from axis to axis: above its base plane, tool in front, elbow up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...support.checks import Array
from ...theory import poe
from ...theory.manipulability import scaled_jacobian
from ...theory.rotations import cross

WANTED = {
    "agility": (0.0, 1.5),
    "facing": (1.0, 0.5),
    "distance": (0.3, 5.0),
    "flatness": (0.0, 2.0),
    "hand down": (0.0, 1.0),
    "hand forward": (0.0, 1.5),
    "hand square": (0.0, 0.6),
    "clearance": (0.05, 8.0),
    "height": (0.0, 6.0),
    "arch": (0.1, 6.0),
    "sag": (0.0, 6.0),
}
"""The least value of each measure that costs nothing, and the cost of each unit less. Lengths are shares of the arm's
size. Agility is log₂ σ_k/σ_1, facing the cosine between the tool's direction and x, distance that of the tool from the
first axis. Flatness is minus the largest distance of a corner from the vertical plane through both. The hand is the
last stroke, a unit vector, square if level or vertical. Clearance is the lowest corner above the base plane, height
that of the tool above `LIFTED` and above `HANGING` below the shoulder. Arch and sag are the highest and the lowest
corner above the line from shoulder to tool."""

LIFTED, HANGING, NEAR_AXIS = 0.15, 0.2, 0.05
"""Shares of the arm's size: the tool above the base plane, the tool below the shoulder, and the distance from the first
axis below which a tool faces nowhere."""

SINGULAR, FORBIDDEN = 0.01, 1e3
"""The least σ_k/σ_1 of a regular configuration, and the cost of a singular one, larger than all other costs."""

LOST, HOPELESS = 1e-3, 1e-6
"""The least σ_k/σ_1 that counts towards the rank, because exports round axes, and the least that is told from 0."""

DECIMALS = 6
"""Decimals of compared costs, so that rounding does not choose between equal configurations."""


@dataclass(frozen=True)
class Mechanism:
    """The numbers of an arm that a ready pose depends on: screws (6, m), coupling A (m, n), origin of the tool (3,)."""

    screws: Array
    A: Array
    tool: Array
    units: tuple[str, ...]
    reach: float

    def regular(self, theta: Array, samples: Array) -> bool:
        """Whether the tool moves in as many directions at theta (n,) as at some of `samples` (N, n)."""
        ranks = [(each > SINGULAR).sum(1) for each in self.look(np.vstack([theta, samples]))[1]]
        return all(bool(rank[0] >= rank[1:].max()) for rank in ranks)

    @cached_property
    def corners(self) -> Array:
        """Base, joints and tool at theta = 0, (m + 2, 3).

        A revolute joint's corner is the point of its axis nearest to the corner before. A slide repeats that corner.
        """
        corners = [np.zeros(3)]
        for v, w in self.screws.T.reshape(-1, 2, 3):
            corner = corners[-1]
            if w @ w > 0.5:
                on_axis = np.cross(w, v) / (w @ w)
                corner = on_axis + w * ((corner - on_axis) @ w) / (w @ w)
            corners.append(corner)
        return np.array([*corners, self.tool])

    def look(self, theta: Array) -> tuple[Array, list[Array]]:
        """The corners (N, m + 2, 3) in base axes at theta (N, n), and σ_k/σ_1, descending, of the tool's Jacobian.

        Metres are measured in the reach. Below six joints the ratios of the linear half follow, because a stretched
        arm of three still turns in three ways.
        """
        moved = poe.motions(self.screws, theta @ self.A.T)
        still = np.broadcast_to(np.eye(4), (len(theta), 1, 4, 4))
        each = np.concatenate([still, moved, moved[:, -1:]], axis=1)
        placed = np.einsum("nkij,kj->nki", each[..., :3, :3], self.corners) + each[..., :3, 3]
        J = poe.columns(moved, self.screws) @ self.A
        J[:, :3] += np.swapaxes(cross(np.swapaxes(J[:, 3:], 1, 2), placed[:, -1:]), 1, 2)
        J = scaled_jacobian(J, np.array(self.units) == "m", self.reach)
        return placed, [_ratios(rows) for rows in ([J] if J.shape[2] >= 6 else [J, J[:, :3]])]


def _ratios(J: Array) -> Array:
    """σ_k/σ_1 of matrices (N, r, n), (N, r), none below `HOPELESS`."""
    squares = np.linalg.eigvalsh(J @ np.swapaxes(J, 1, 2))[:, ::-1]
    return np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))


class Merit:
    """The costs of an arm's configurations. Some `samples` (N, n) show its rank and which corners it lifts."""

    def __init__(self, arm: Mechanism, samples: Array) -> None:
        self._arm = arm
        placed, ratios = arm.look(samples)
        self._ranks = [int((each > LOST).sum(1).max()) for each in ratios]
        # The corners before the first revolute joint are the mount.
        self._first = 1 + int(np.argmax(np.sum(arm.screws[3:] ** 2, axis=0) > 0.5))
        strokes = np.diff(arm.corners[self._first :], axis=0)
        self._size = float(np.linalg.norm(strokes, axis=1).sum()) or 1.0
        self._rising = np.ptp(placed[..., 2], axis=0) > 1e-3 * self._size
        self._shoulder = max(0, int(np.argmax(self._rising)) - 1)
        far = np.linalg.norm(arm.corners - arm.tool, axis=-1) > 0.03 * self._size
        self._wrist = int(np.flatnonzero(far)[-1]) if far.any() else 0

    def costs(self, theta: Array) -> Array:
        """Costs (N,) of theta (N, n)."""
        placed, ratios = self._arm.look(theta)
        least = np.min([each[:, rank - 1] for each, rank in zip(ratios, self._ranks, strict=True)], axis=0)
        measures = {"agility": np.log2(least), **self._front(placed / self._size), **self._heights(placed / self._size)}
        cost = FORBIDDEN * (least < SINGULAR)
        for name, measure in measures.items():
            wanted, price = WANTED[name]
            cost = cost + price * np.maximum(0.0, wanted - measure)
        return np.asarray(cost.round(DECIMALS))

    def _front(self, placed: Array) -> dict[str, Array]:
        """The measures seen from above, and those of the hand."""
        out = (placed - placed[:, self._first, None])[..., :2]
        distance = np.linalg.norm(out[:, -1], axis=-1)
        ahead = out[:, -1] / np.maximum(distance, 1e-12)[:, None]
        ahead[distance < NEAR_AXIS] = 1.0, 0.0
        aside = out[:, self._first :, 1] * ahead[:, None, 0] - out[:, self._first :, 0] * ahead[:, None, 1]
        hand = placed[:, -1] - placed[:, self._wrist]
        hand = hand / np.maximum(np.linalg.norm(hand, axis=-1, keepdims=True), 1e-12)
        level = np.linalg.norm(hand[:, :2], axis=-1)
        return {
            "facing": ahead[:, 0],
            "distance": distance,
            "flatness": -np.abs(aside).max(-1),
            "hand down": -hand[:, 2],
            "hand forward": np.sum(hand[:, :2] * ahead, axis=-1),
            "hand square": -np.minimum(np.abs(hand[:, 2]), level),
        }

    def _heights(self, placed: Array) -> dict[str, Array]:
        """The measures of corners and tool above the base plane, and above the line from shoulder to tool."""
        z, shoulder = placed[..., 2], placed[:, self._shoulder]
        measures = {}
        if self._rising.any():
            measures["clearance"] = z[:, self._rising].min(-1)
            measures["height"] = z[:, -1] - np.maximum(LIFTED, shoulder[:, 2] - HANGING)
        if self._rising.any() and placed.shape[1] > self._shoulder + 2:
            way = placed[:, -1] - shoulder
            corners = placed[:, self._shoulder + 1 : -1] - shoulder[:, None]
            share = np.sum(corners * way[:, None], axis=-1) / np.maximum(np.sum(way * way, axis=-1), 1e-12)[:, None]
            above = corners[..., 2] - np.clip(share, 0.0, 1.0) * way[:, None, 2]
            measures |= {"arch": above.max(-1), "sag": above.min(-1)}
        return measures
