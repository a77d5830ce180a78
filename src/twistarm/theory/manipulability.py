"""Manipulability: how well a posture moves the tool in each direction, by singular values of the body Jacobian."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import Array
from ..support.display import Brief

NO_MOTION = 1e-9
"""A singular value this small beside the largest is the rounding of 0."""


@dataclass(frozen=True, repr=False)
class Manipulability(Brief):
    """Singular values of the body Jacobian, metres and radians brought together by `length` [m].

    The linear rows are divided by `length`, the columns of prismatic joints multiplied by it, so that every number
    is rad per rad. `singular_values` (..., k), descending, k = min(6, n); `axes` (..., 6, k): the tool twists (v, w)
    they belong to, linear part again in units of `length`.
    """

    singular_values: Array
    axes: Array
    length: float

    @property
    def condition(self) -> Array:
        """σ_max / σ_min (...): 1 is isotropic, inf is singular."""
        return self.condition_in(self.singular_values.shape[-1])

    @property
    def rank(self) -> np.ndarray[tuple[int, ...], np.dtype[np.int_]]:
        """In how many directions the tool moves, (...)."""
        return np.asarray((self.singular_values > NO_MOTION * self.singular_values[..., :1]).sum(-1))

    def condition_in(self, directions: int) -> Array:
        """σ_1 / σ_directions (...): the condition with the directions that the arm lacks everywhere left out."""
        largest, smallest = self.singular_values[..., 0], self.singular_values[..., directions - 1]
        return np.divide(largest, smallest, out=np.full_like(largest, np.inf), where=smallest > 1e-15 * largest)

    @property
    def yoshikawa(self) -> Array:
        """Π σ_i (...): Yoshikawa 1985, "Manipulability of robotic mechanisms"; √det(J Jᵀ) where n ≥ 6."""
        return np.asarray(self.singular_values.prod(-1))


def scaled_jacobian(J: Array, prismatic: Array, length: float) -> Array:
    """`J` (..., 6, n) with linear rows / length and prismatic columns (a boolean (n,)) · length."""
    rows = np.array([1.0 / length] * 3 + [1.0] * 3)
    columns = np.where(prismatic, length, 1.0)
    scaled: Array = J * rows[:, None] * columns
    return scaled


def manipulability_of(J: Array, prismatic: Array, length: float) -> Manipulability:
    """The measure for body Jacobians `J` (..., 6, n)."""
    U, s, _ = np.linalg.svd(scaled_jacobian(J, prismatic, length), full_matrices=False)
    return Manipulability(s, U, length)
