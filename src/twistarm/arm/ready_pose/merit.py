"""The merit of a configuration: a sum of penalties, 0 at best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...support.checks import Array
from ...theory import poe
from ...theory.manipulability import scaled_jacobian
from ...theory.rotations import cross
from .grid import Grid, Rows
from .stance import Sketch, Stance, sketched

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
    ratios: Array = np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))
    return ratios
