"""Task space: the components that a target constrains, as errors and Jacobian rows, and the distance that remains."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from ..support.checks import Array

Rows = tuple[Array, Array]
"""(error (k,), rows (k, n))."""


@dataclass(frozen=True)
class Tolerances:
    """What counts as met: position [m] and orientation [rad]."""

    position: float
    orientation: float

    @property
    def keywords(self) -> dict[str, Any]:
        """As `solve_ik` and its like take them."""
        return {"position_tol": self.position, "orientation_tol": self.orientation}

    def met(self, position_error: float, orientation_error: float) -> bool:
        """Whether both errors are within the tolerances."""
        return position_error <= self.position and orientation_error <= self.orientation

    def or_rounding(self, rounding: tuple[float, float]) -> Tolerances:
        """These, or what the rounding of an arm's axes may make it miss a target by, whichever is more."""
        return Tolerances(max(self.position, rounding[0]), max(self.orientation, rounding[1]))


class Target(Protocol):
    """A target reduced to the components it constrains.

    From the tool's pose g (4, 4) and its body Jacobian J_b (6, n), neither checked, come an error (k,) and rows (k, n),
    with d error = rows · dθ for the position, and with rowsᵀ error the gradient of a function that grows with the angle
    for the rotation. What is free has no row, so nothing that is free makes a matrix singular.
    """

    @property
    def _position_tolerance(self) -> Array:
        """How far each row of the position error [m] may be from 0 beside the solver's tolerance."""

    @property
    def _rotation_tolerance(self) -> Array:
        """How far each row of the rotation error [rad] may be from 0 beside the solver's tolerance."""

    def _position_rows(self, g: Array, J_b: Array) -> Rows:
        """Error [m] of the constrained components of the position, and its derivative."""

    def _rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """Error of the constrained components of the rotation, and its rows."""

    def position_error(self, g: Array) -> float:
        """Distance [m] from what is asked, counting only what is constrained."""

    def orientation_error(self, g: Array) -> float:
        """Angle [rad] from what is asked, counting only what is constrained."""

    def at(self, g: Array) -> Target:
        """The target of the same kind that the pose g meets."""

    def describe(self) -> str:
        """The target in words."""


def excess(error: Array, tolerance: Array) -> Array:
    """What of each component lies beyond its tolerance, with its sign."""
    beyond: Array = error - np.clip(error, -tolerance, tolerance)
    return beyond


def excess_rows(rows: Rows, tolerance: Array) -> Rows:
    """`excess` of the error, and its derivative: a component inside its tolerance no longer pulls."""
    error, J = rows
    if not tolerance.any():
        return rows
    beyond = excess(error, tolerance)
    return beyond, np.where(((beyond != 0) | (tolerance == 0))[:, None], J, 0.0)


def offset_rows(p: Array, g: Array, J_b: Array) -> Rows:
    """Offset of the tool's origin from p [m] and its derivative, both in tool axes, where J_b needs no turning.

    Turning both sides changes no least-squares step and no gradient.
    """
    return g[:3, :3].T @ (g[:3, 3] - p), J_b[:3]
