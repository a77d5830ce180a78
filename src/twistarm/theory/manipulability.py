"""Manipulability: how well a configuration moves the tool in each direction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..support.checks import Array, as_whole
from ..support.directions import nearest_axes, signed
from ..support.display import Brief

NO_MOTION = 1e-9  # A singular value this small beside the largest is the rounding of 0.
BESIDE = 1e-4  # How far beside a singular configuration one looks for the motions that it lacks [scaled rad].
POOR = 100.0  # A condition number above which some direction takes a hundred times the joint rates of another.
SEEN = 1e-3  # Of that distance: a singular value which is larger there is not the square of it.


@dataclass(frozen=True, repr=False)
class Manipulability(Brief):
    """Singular values of the body Jacobian, metres and radians brought together by `length` [m].

    The linear rows are divided by `length`, and the columns of prismatic joints are multiplied by it. Every number is
    then rad per rad. `singular_values` (..., k) descend, k = min(6, n). `axes` (..., 6, k) are their tool twists (v,
    w), the linear part again in units of `length`.

    Singular vectors are unique up to the sign, and for equal values up to a rotation. Here the largest component is
    positive. The axes of equal values are those in their span that are nearest to the tool's axes. Translations along
    x, y, z come before rotations about x, y, z. The axes of a value 0 begin with the motions that configurations beside
    this one have, to first order. Those that they lack too follow.
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
        """σ_1 / σ_directions (...): the condition without the directions that the arm lacks everywhere."""
        last = as_whole(directions, "directions", 1, self.singular_values.shape[-1]) - 1
        largest, smallest = self.singular_values[..., 0], self.singular_values[..., last]
        # A smaller value is the rounding of the singular value decomposition, and its quotient means nothing.
        return np.divide(largest, smallest, out=np.full_like(largest, np.inf), where=smallest > 1e-15 * largest)

    @property
    def yoshikawa(self) -> Array:
        """Π σ_i (...): Yoshikawa 1985, "Manipulability of robotic mechanisms"; √det(J Jᵀ) where n ≥ 6."""
        return np.asarray(self.singular_values.prod(-1))


def scaled_jacobian(J: Array, prismatic: Array, length: float) -> Array:
    """`J` (..., 6, n) with linear rows / length and prismatic columns (a boolean (n,)) · length."""
    rows = np.array([1.0 / length] * 3 + [1.0] * 3)
    columns = np.where(prismatic, length, 1.0)
    return J * rows[:, None] * columns


def manipulability_of(
    J: Array, prismatic: Array, length: float, beside: Callable[[tuple[int, ...], Array], Array]
) -> Manipulability:
    """The measure for body Jacobians `J` (..., 6, n).

    `beside` gives the body Jacobians (m, 6, n) at the configuration of an index, moved by the scaled steps (m, n).
    """
    U, s, Vt = np.linalg.svd(scaled_jacobian(J, prismatic, length), full_matrices=False)
    if s.shape[-1]:
        U = signed(U)
    equal = np.diff(s, append=0.0) >= -NO_MOTION * s[..., :1]  # to the next one
    for index in map(tuple, np.argwhere(equal.any(axis=-1))):
        first, axes = 0, U[index]
        for last in (np.flatnonzero(~equal[index]) + 1).tolist():
            axes[:, first:last] = nearest_axes(axes[:, first:last] @ axes[:, first:last].T, last - first)
            first = last
        if lost := len(s[index]) - first:
            rows = scaled_jacobian(beside(index, BESIDE * np.eye(J.shape[-1])), prismatic, length)
            axes[:, first:] = _lacking(axes[:, :first], Vt[index][:first], rows, lost)
    return Manipulability(s, U, length)


def _lacking(U: Array, Vt: Array, beside: Array, count: int) -> Array:
    """Axes (6, count) across the columns of U (6, r): first those that rows (m, 6, n) beside have across Vt (r, n)."""
    P = np.eye(6) - U @ U.T
    free = np.eye(Vt.shape[1]) - Vt.T @ Vt
    Q, size, _ = np.linalg.svd(np.hstack(list(P @ beside @ free)), full_matrices=False)
    Q = Q[:, : int((size > SEEN * BESIDE).sum())]
    seen = nearest_axes(Q @ Q.T, min(Q.shape[1], count))
    return np.hstack([seen, nearest_axes(P - Q @ Q.T, count - seen.shape[1])])
