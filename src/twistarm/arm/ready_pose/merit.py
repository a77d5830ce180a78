"""The merit of a configuration: a sum of penalties, 0 at best, of its stance and its conditioning.

The stance is the arm drawn as a line from axis to axis: above its base plane, tool in front, elbow up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

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

PARALLEL = 1e-9
"""The squared length of a unit twist's turn that counts as zero."""

if TYPE_CHECKING:
    from ..arm import Arm

DECIMALS = 6
"""Decimals of compared costs, so that rounding does not choose between equal configurations."""

SLOWED = 1.5
"""Cost of each doubling of the condition number."""

LOST = 1e-3
"""A singular value below this share of the largest counts as zero, because exports round axes."""

HOPELESS = 1e-6
"""The least σ_k/σ_1, so that other costs decide between singular configurations."""


@dataclass(frozen=True)
class Sketch:
    """Corners at theta = 0, (m + 2, 3): the base, one for each moving joint, the tool.

    A revolute joint's corner is the point of its axis nearest to the corner before. A slide repeats that corner.
    What is before the corner of the `first` revolute joint is the mount.
    """

    corners: Array
    first: int

    def at(self, motions: Array) -> Array:
        """The corners (..., m + 2, 3) for what each joint has undergone, (..., m + 1, 4, 4), the identity first."""
        moved = np.concatenate([motions, motions[..., -1:, :, :]], axis=-3)
        return np.einsum("...ij,...j->...i", moved[..., :3, :3], self.corners) + moved[..., :3, 3]

    @cached_property
    def size(self) -> float:
        """Length of the stretched arm from its first axis to the tool [m]; 1 m for an arm without length."""
        return float(np.linalg.norm(np.diff(self.corners[self.first :], axis=0), axis=1).sum()) or 1.0


def sketched(screws: Array, tool: Array) -> Sketch:
    """The sketch of a chain of `screws` (6, m) to a tool with origin `tool` (3,) at theta = 0."""
    corners = [np.zeros(3)]
    turning = np.sum(screws[3:] ** 2, axis=0) > PARALLEL
    for i, (v, w) in enumerate(screws.T.reshape(-1, 2, 3)):
        corner = corners[-1]
        if turning[i]:
            on_axis = np.cross(w, v) / (w @ w)
            corner = on_axis + w * ((corner - on_axis) @ w) / (w @ w)
        corners.append(corner)
    return Sketch(np.array([*corners, tool]), 1 + int(np.argmax(turning)))


@dataclass(frozen=True)
class Stance:
    """The cost of the corners' places of a sketch. `rising` (k,) marks corners that the arm can lift."""

    sketch: Sketch
    rising: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    def cost(self, placed: Array) -> Array:
        """Costs (N,), 0 at best, of corners (N, k, 3) in base axes with z up."""
        out = (placed - placed[:, self.sketch.first, None])[..., :2]
        distance = np.linalg.norm(out[:, -1], axis=-1)
        nowhere = distance < CLEAR * self.sketch.size
        ahead = np.where(nowhere[:, None], [1.0, 0.0], out[:, -1] / np.maximum(distance, 1e-12)[:, None])
        out = out[:, self.sketch.first :]
        aside = np.abs(out[..., 1] * ahead[:, None, 0] - out[..., 0] * ahead[:, None, 1]).max(-1)
        cost: Array = CLOSE * np.maximum(0.0, AHEAD - distance / self.sketch.size) + TURNED * (1.0 - ahead[:, 0])
        cost += SIDEWAYS * aside / self.sketch.size + self._hand(placed, ahead)
        if self.rising.any():
            cost += self._heights(placed)
        return cost

    def _heights(self, placed: Array) -> Array:
        """Costs of the heights of corners and tool above the base plane, and of the elbow above its line."""
        z = placed[..., 2] / self.sketch.size
        cost: Array = SINKING * np.maximum(0.0, CLEAR - z[:, self.rising].min(-1))
        if self.rising[-1]:
            floor = np.maximum(LIFTED, z[:, self._shoulder] - HANGING)
            cost += DROOPING * np.maximum(0.0, floor - z[:, -1])
        between = slice(self._shoulder + 1, -1)
        if placed.shape[1] > self._shoulder + 2:
            arch = self._arch(placed, between) / self.sketch.size
            cost += SAGGING * (np.maximum(0.0, ARCHED - arch.max(-1)) + np.maximum(0.0, -arch.min(-1)))
        return cost

    def _arch(self, placed: Array, between: slice) -> Array:
        """Heights (N, j) of corners above the straight line from shoulder to tool."""
        start, way = placed[:, self._shoulder], placed[:, -1] - placed[:, self._shoulder]
        square = np.maximum(np.sum(way * way, axis=-1), 1e-12)
        corners = placed[:, between] - start[:, None]
        share = np.clip(np.sum(corners * way[:, None], axis=-1) / square[:, None], 0.0, 1.0)
        return corners[..., 2] - share * way[:, None, 2]

    def _hand(self, placed: Array, ahead: Array) -> Array:
        """Cost of the last stroke. It should point forward, down, or between the two."""
        hand = placed[:, -1] - placed[:, self._wrist]
        hand = hand / np.maximum(np.linalg.norm(hand, axis=-1, keepdims=True), 1e-12)
        up, forward = hand[:, 2], np.sum(hand[:, :2] * ahead, axis=-1)
        askew = np.minimum(np.abs(up), np.linalg.norm(hand[:, :2], axis=-1))
        return TOOL_UP * np.maximum(0.0, up) + TOOL_BACK * np.maximum(0.0, -forward) + TOOL_ASKEW * askew

    @cached_property
    def _shoulder(self) -> int:
        """The corner before the first that rises."""
        return max(0, int(np.argmax(self.rising)) - 1)

    @cached_property
    def _wrist(self) -> int:
        """The last corner that is not at the tool."""
        far = np.linalg.norm(self.sketch.corners - self.sketch.corners[-1], axis=-1) > 0.03 * self.sketch.size
        return int(np.flatnonzero(far)[-1]) if far.any() else 0


@dataclass(frozen=True)
class Merit:
    """The costs of an arm's configurations on a grid. `ranks` count the directions in which its tool moves."""

    arm: Arm
    grid: Grid
    sketch: Sketch
    stance: Stance
    ranks: tuple[int, ...]

    def costs(self, rows: Rows) -> Array:
        """Costs (N,) of rows (N, n)."""
        motions = _motions(self.arm, self.grid.theta(rows))
        placed = self.sketch.at(motions)
        ratios = _conditioning(self.arm, motions, placed[:, -1])
        least = np.min([each[:, rank - 1] for each, rank in zip(ratios, self.ranks, strict=True)], axis=0)
        costs: Array = self.grid.costs(rows) + self.stance.cost(placed) - SLOWED * np.log2(least)
        return costs.round(DECIMALS)


def merit_of(arm: Arm, grid: Grid, rows: Rows) -> Merit:
    """The merit of an arm, with the ranks found at the configurations of some rows (N, n)."""
    sketch = sketched(arm.screws, arm.home[:3, 3])
    motions = _motions(arm, grid.theta(rows))
    placed = sketch.at(motions)
    rising = np.ptp(placed[..., 2], axis=0) > 1e-3 * sketch.size
    ranks = (int((each > LOST).sum(1).max()) for each in _conditioning(arm, motions, placed[:, -1]))
    return Merit(arm, grid, sketch, Stance(sketch, rising), tuple(ranks))


def _motions(arm: Arm, theta: Array) -> Array:
    """Displacements (N, m + 1, 4, 4) of base and moving joints at theta (N, n)."""
    still = np.broadcast_to(np.eye(4), (len(theta), 1, 4, 4))
    return np.concatenate([still, poe.motions(arm.screws, theta @ arm.coupling.A.T)], axis=1)


def _conditioning(arm: Arm, motions: Array, tool: Array) -> tuple[Array, ...]:
    """σ_k/σ_1 (N, k), descending, of the Jacobian of a tool at (N, 3), scaled by the reach.

    Below six joints also of its linear half, because a stretched arm of three still turns in three ways.
    """
    J = poe.columns(motions[:, 1:], arm.screws) @ arm.coupling.A
    J[:, :3] += np.swapaxes(cross(np.swapaxes(J[:, 3:], 1, 2), tool[:, None]), 1, 2)
    J = scaled_jacobian(J, np.array(arm.units) == "m", arm.reach)
    return (_ratios(J),) if J.shape[2] >= 6 else (_ratios(J), _ratios(J[:, :3]))


def _ratios(J: Array) -> Array:
    """σ_k/σ_1 of matrices (N, r, n), (N, min(r, n)), none below `HOPELESS`."""
    transposed = np.swapaxes(J, 1, 2)
    squares = np.linalg.eigvalsh(J @ transposed if J.shape[2] >= J.shape[1] else transposed @ J)[:, ::-1]
    return np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))
