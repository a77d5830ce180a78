"""Task space: rows of errors with their Jacobian, and tolerances of errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..support.checks import Array

Rows = tuple[Array, Array]  # (error (k,), rows (k, n)).
# What every call tolerates unless it says otherwise [m, rad]: finer than a drive, coarser than what CAD rounds.
POSITION_TOL, ORIENTATION_TOL = 1e-5, 5e-5
EXACT_TOL = 1e-6  # Greatest errors [m, rad] of an answer that counts as exact, whatever the tolerances are.


@dataclass(frozen=True)
class Tolerances:
    """The greatest errors that count as reached: position [m] and orientation [rad]."""

    position: float
    orientation: float

    @property
    def keywords(self) -> dict[str, Any]:
        """The tolerances as keyword arguments of `solve_ik` and its like."""
        return {"position_tol": self.position, "orientation_tol": self.orientation}

    def converged(self, position_error: float, orientation_error: float) -> bool:
        """Whether both errors are within the tolerances."""
        return position_error <= self.position and orientation_error <= self.orientation

    def at_most(self, error: float) -> Tolerances:
        """The smaller of these and of an error [m, rad]."""
        return Tolerances(min(self.position, error), min(self.orientation, error))


USUAL = Tolerances(POSITION_TOL, ORIENTATION_TOL)


def excess(error: Array, tolerance: Array) -> Array:
    """The part of each component beyond its tolerance, with its sign."""
    return error - np.clip(error, -tolerance, tolerance)


def excess_rows(rows: Rows, tolerance: Array) -> Rows:
    """`excess` of the error, and its derivative: a component inside its tolerance no longer pulls."""
    error, J = rows
    if not tolerance.any():
        return rows
    beyond = excess(error, tolerance)
    return beyond, np.where(((beyond != 0) | (tolerance == 0))[:, None], J, 0.0)


def offset_rows(p: Array, g: Array, J_b: Array) -> Rows:
    """Offset of the tool's origin from p [m] and its derivative, both in tool axes.

    Turning both sides changes no least-squares step and no gradient.
    """
    return g[:3, :3].T @ (g[:3, 3] - p), J_b[:3]
