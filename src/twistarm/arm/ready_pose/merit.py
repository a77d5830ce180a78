"""The merit of a configuration: a sum of penalties, 0 at best."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from ...theory import poe
from ...theory.manipulability import scaled_jacobian
from ...theory.rotations import cross
from .grid import Grid, Rows
from .sketch import Sketch, sketched
from .stance import Stance

DECIMALS = 6
"""Decimals of compared costs, so that rounding does not choose between equal configurations."""

SLOWED = 1.5
"""Cost of each doubling of the condition number."""

LOST = 1e-3
"""A singular value below this share of the largest counts as zero, because exports round axes."""

HOPELESS = 1e-6
"""The least σ_k/σ_1, so that other costs decide between singular configurations."""


class Mechanism(NamedTuple):
    """A chain as numbers: screws (6, m), home (4, 4), A (m, n), reach [m]; limits, bounds, units of its coordinates."""

    screws: Array
    home: Array
    A: Array
    reach: float
    limits: JointLimits
    bounds: tuple[Array, Array]
    units: tuple[str, ...]

    def motions(self, theta: Array) -> Array:
        """Displacements (N, m + 1, 4, 4) of base and moving joints at theta (N, n)."""
        still = np.broadcast_to(np.eye(4), (len(theta), 1, 4, 4))
        return np.concatenate([still, poe.motions(self.screws, theta @ self.A.T)], axis=1)

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
    ratios: Array = np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))
    return ratios


@dataclass(frozen=True)
class Merit:
    """The costs of a mechanism's configurations on a grid. `ranks` count the directions in which its tool moves."""

    mechanism: Mechanism
    grid: Grid
    sketch: Sketch
    stance: Stance
    ranks: tuple[int, ...]

    def costs(self, rows: Rows) -> Array:
        """Costs (N,) of rows (N, n)."""
        motions = self.mechanism.motions(self.grid.theta(rows))
        placed = self.sketch.at(motions)
        ratios = self.mechanism.conditioning(motions, placed[:, -1])
        least = np.min([each[:, rank - 1] for each, rank in zip(ratios, self.ranks, strict=True)], axis=0)
        costs = self.grid.costs(rows) + self.stance.cost(placed) - SLOWED * np.log2(least)
        return np.round(costs, DECIMALS)


def merit_of(mechanism: Mechanism, grid: Grid, rows: Rows) -> Merit:
    """The merit of a mechanism, with the ranks found at the configurations of some rows (N, n)."""
    sketch = sketched(mechanism.screws, mechanism.home[:3, 3])
    motions = mechanism.motions(grid.theta(rows))
    placed = sketch.at(motions)
    rising = np.ptp(placed[..., 2], axis=0) > 1e-3 * sketch.size
    ranks = (int((each > LOST).sum(1).max()) for each in mechanism.conditioning(motions, placed[:, -1]))
    return Merit(mechanism, grid, sketch, Stance(sketch, rising), tuple(ranks))
