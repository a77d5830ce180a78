"""The merit of configurations: a sum of penalties, 0 at best, for a singularity, the bounds, and the stance.

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
from .grid import Grid, Rows

CLEAR, LIFTED, HANGING, AHEAD, ARCHED = 0.05, 0.15, 0.2, 0.3, 0.1
"""Shares of the arm's size: corners above the base plane, the tool above it, the tool at most below the shoulder, the
tool before the first axis, the elbow above the line from shoulder to tool. A lower share has a cost."""

SINKING, DROOPING, CLOSE, TURNED, SIDEWAYS, SAGGING = 8.0, 6.0, 5.0, 0.5, 2.0, 6.0
"""Costs per arm's size that is missing in these shares, and of facing away from x."""

TOOL_UP, TOOL_BACK, TOOL_ASKEW = 1.0, 1.5, 0.6
"""Costs of a hand that points straight up, straight back, and neither level nor straight down."""

SLOWED = 1.5
"""Cost of each doubling of the condition number."""

SINGULAR, FORBIDDEN = 0.01, 1e3
"""The least σ_k/σ_1 of a regular configuration, and the cost of a singular one, larger than all other costs."""

LOST, HOPELESS = 1e-3, 1e-6
"""The least σ_k/σ_1 that counts towards the rank, because exports round axes, and the least that is told from 0."""

RANK_SAMPLES = 16
"""Random configurations that show the rank of an arm. Almost every one has it."""

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
        motions = self.motions(np.vstack([theta, samples]))
        ratios = self.conditioning(motions, self.placed(motions)[:, -1])
        return all(bool((each[0] > SINGULAR).sum() >= (each[1:] > SINGULAR).sum(1).max()) for each in ratios)

    def motions(self, theta: Array) -> Array:
        """Displacements (N, m + 1, 4, 4) of base and moving joints at theta (N, n)."""
        still = np.broadcast_to(np.eye(4), (len(theta), 1, 4, 4))
        return np.concatenate([still, poe.motions(self.screws, theta @ self.A.T)], axis=1)

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

    @cached_property
    def first(self) -> int:
        """The corner of the first revolute joint. The corners before it are the mount."""
        return 1 + int(np.argmax(np.sum(self.screws[3:] ** 2, axis=0) > 0.5))

    @cached_property
    def size(self) -> float:
        """Length of the stretched arm from its first axis to the tool [m]; 1 m for an arm without length."""
        return float(np.linalg.norm(np.diff(self.corners[self.first :], axis=0), axis=1).sum()) or 1.0

    def placed(self, motions: Array) -> Array:
        """The corners (N, m + 2, 3) in base axes."""
        moved = np.concatenate([motions, motions[:, -1:]], axis=1)
        return np.einsum("nkij,kj->nki", moved[..., :3, :3], self.corners) + moved[..., :3, 3]

    def conditioning(self, motions: Array, tool: Array) -> tuple[Array, ...]:
        """σ_k/σ_1 (N, k), descending, of the Jacobian of a tool at (N, 3), scaled by the reach.

        Below six joints also of its linear half, because a stretched arm of three still turns in three ways.
        """
        J = poe.columns(motions[:, 1:], self.screws) @ self.A
        J[:, :3] += np.swapaxes(cross(np.swapaxes(J[:, 3:], 1, 2), tool[:, None]), 1, 2)
        J = scaled_jacobian(J, np.array(self.units) == "m", self.reach)
        return (_ratios(J),) if J.shape[2] >= 6 else (_ratios(J), _ratios(J[:, :3]))


def _ratios(J: Array) -> Array:
    """σ_k/σ_1 of matrices (N, r, n), (N, min(r, n)), none below `HOPELESS`."""
    transposed = np.swapaxes(J, 1, 2)
    squares = np.linalg.eigvalsh(J @ transposed if J.shape[2] >= J.shape[1] else transposed @ J)[:, ::-1]
    return np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))


class Merit:
    """The costs of an arm's configurations on a grid. Some `rows` (N, n) show its rank and which corners it lifts."""

    def __init__(self, arm: Mechanism, grid: Grid, rows: Rows) -> None:
        self.arm, self.grid = arm, grid
        motions = arm.motions(grid.theta(rows))
        placed = arm.placed(motions)
        self._ranks = [int((each > LOST).sum(1).max()) for each in arm.conditioning(motions, placed[:, -1])]
        self._rising = np.ptp(placed[..., 2], axis=0) > 1e-3 * arm.size
        self._shoulder = max(0, int(np.argmax(self._rising)) - 1)
        far = np.linalg.norm(arm.corners - arm.corners[-1], axis=-1) > 0.03 * arm.size
        self._wrist = int(np.flatnonzero(far)[-1]) if far.any() else 0

    def costs(self, rows: Rows) -> Array:
        """Costs (N,) of rows (N, n)."""
        motions = self.arm.motions(self.grid.theta(rows))
        placed = self.arm.placed(motions)
        ratios = zip(self.arm.conditioning(motions, placed[:, -1]), self._ranks, strict=True)
        least = np.min([each[:, rank - 1] for each, rank in ratios], axis=0)
        cost: Array = self.grid.costs(rows) - SLOWED * np.log2(least) + FORBIDDEN * (least < SINGULAR)
        cost += self._front(placed)
        if self._rising.any():
            cost += self._heights(placed)
        return cost.round(DECIMALS)

    def _front(self, placed: Array) -> Array:
        """Costs of a tool near the first axis or beside x, of corners beside the plane of the arm, and of the hand.

        The hand is the last stroke. It should point forward, down, or between the two.
        """
        size, first = self.arm.size, self.arm.first
        out = (placed - placed[:, first, None])[..., :2]
        distance = np.linalg.norm(out[:, -1], axis=-1)
        ahead = out[:, -1] / np.maximum(distance, 1e-12)[:, None]
        ahead[distance < CLEAR * size] = 1.0, 0.0
        aside = np.abs(out[:, first:, 1] * ahead[:, None, 0] - out[:, first:, 0] * ahead[:, None, 1]).max(-1)
        cost = CLOSE * np.maximum(0.0, AHEAD - distance / size) + TURNED * (1.0 - ahead[:, 0])
        hand = placed[:, -1] - placed[:, self._wrist]
        hand = hand / np.maximum(np.linalg.norm(hand, axis=-1, keepdims=True), 1e-12)
        up, forward = hand[:, 2], np.sum(hand[:, :2] * ahead, axis=-1)
        askew = np.minimum(np.abs(up), np.linalg.norm(hand[:, :2], axis=-1))
        cost += TOOL_UP * np.maximum(0.0, up) + TOOL_BACK * np.maximum(0.0, -forward) + TOOL_ASKEW * askew
        return np.asarray(cost + SIDEWAYS * aside / size)

    def _heights(self, placed: Array) -> Array:
        """Costs of low corners, of a low tool, and of corners below the line from shoulder to tool."""
        z = placed[..., 2] / self.arm.size
        cost: Array = SINKING * np.maximum(0.0, CLEAR - z[:, self._rising].min(-1))
        if self._rising[-1]:
            cost += DROOPING * np.maximum(0.0, np.maximum(LIFTED, z[:, self._shoulder] - HANGING) - z[:, -1])
        if placed.shape[1] > self._shoulder + 2:
            start, way = placed[:, self._shoulder], placed[:, -1] - placed[:, self._shoulder]
            corners = placed[:, self._shoulder + 1 : -1] - start[:, None]
            square = np.maximum(np.sum(way * way, axis=-1), 1e-12)
            share = np.clip(np.sum(corners * way[:, None], axis=-1) / square[:, None], 0.0, 1.0)
            arch = (corners[..., 2] - share * way[:, None, 2]) / self.arm.size
            cost += SAGGING * (np.maximum(0.0, ARCHED - arch.max(-1)) + np.maximum(0.0, -arch.min(-1)))
        return cost
