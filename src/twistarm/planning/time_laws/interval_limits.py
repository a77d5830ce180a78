"""Limits on the intervals of a grid along a path, linear in x = ṡ² at both ends.

On an interval of length h where x is linear in s from x0 to x1, s̈ = (x1 − x0)/(2 h) is constant. A row p = C q, a
polynomial of degree d in s, has the acceleration p' s̈ + p'' x and the velocity p' ṡ. The acceleration has degree d −
1. The square of the velocity, p'² x, has degree 2 d − 1. Their Bernstein coefficients are linear in x0 and x1. If all
of them keep a limit, so do the polynomials on the whole interval.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import comb, factorial

import numpy as np

from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import derivative, evaluate
from ..spans import MARGIN
from .bounds import PathBounds

LEAST_DEGREE = 2
"""A straight line counts as a parabola: its curvature is a polynomial too."""


@dataclass(frozen=True, eq=False)
class LimitedPath:
    """A path for its limits: the rows C q of joints and motors, (d + 1, m, r), d ≥ 2, and their limits.

    `velocity` and `acceleration` are (r,), `ceiling` of ṡ (m,); all less by what rounding may add.
    """

    breakpoints: Array
    coefficients: Array
    velocity: Array
    acceleration: Array
    ceiling: Array

    @classmethod
    def of(cls, path: JointPath, bounds: PathBounds) -> LimitedPath:
        """The path with its bounds."""
        coefficients = path.coefficients @ bounds.C.T
        missing = max(0, LEAST_DEGREE + 1 - len(coefficients))
        padded = np.concatenate([np.zeros((missing, *coefficients.shape[1:])), coefficients])
        less = 1.0 - MARGIN
        return cls(
            path.breakpoints,
            np.ascontiguousarray(padded),
            less * bounds.velocity,
            less * bounds.acceleration,
            less * bounds.ceiling_of(path),
        )


def derivatives(path: LimitedPath, grid: Array) -> tuple[Array, Array, Array]:
    """Bernstein coefficients of p' (d, N, r) and p'' (d − 1, N, r) per interval, and the ceiling (N,)."""
    starts, steps = grid[:-1], np.diff(grid)
    piece = np.searchsorted(path.breakpoints[1:-1], starts + 0.5 * steps, side="right")
    sigma = (starts - path.breakpoints[piece])[:, None]
    coefficients = path.coefficients[:, piece]
    degree = len(coefficients) - 1
    here = np.stack([evaluate(derivative(coefficients, k), sigma) / factorial(k) for k in range(degree, -1, -1)])
    return bernstein(derivative(here), steps), bernstein(derivative(here, 2), steps), path.ceiling[piece]


def rows(path: LimitedPath, tangent: Array, bend: Array, ceiling: Array, steps: Array) -> tuple[Array, Array]:
    """A and B (N, w): A x0 + B x1 ≤ 1 keeps every limit on each of N intervals of lengths `steps`."""
    d = len(tangent) - 1
    speeding, bending = tangent / (2.0 * steps[:, None] * path.acceleration), bend / path.acceleration
    squared = _squared(tangent / path.velocity)
    e = len(squared) - 1
    before = [-speeding[k] + (bending[k] * (d - k) / d if k < d else 0.0) for k in range(d + 1)]
    after = [speeding[k] + (bending[k - 1] * k / d if k else 0.0) for k in range(d + 1)]
    nothing, cap = np.zeros_like(tangent[0]), (1.0 / ceiling**2)[:, None]
    fast_before = [squared[k] * (e + 1 - k) / (e + 1) if k <= e else nothing for k in range(e + 2)]
    fast_after = [squared[k - 1] * k / (e + 1) if k else nothing for k in range(e + 2)]
    A = [*before, *(-row for row in before), *fast_before, cap, np.zeros_like(cap)]
    B = [*after, *(-row for row in after), *fast_after, np.zeros_like(cap), cap]
    return np.concatenate(A, axis=1), np.concatenate(B, axis=1)


def used(path: LimitedPath, tangent: Array, bend: Array, ceiling: Array, steps: Array, x: Array) -> Array:
    """How far each interval uses its tightest limit, (N,), 1 for up to it."""
    s_ddot = (np.diff(x) / (2.0 * steps))[:, None]
    velocity, acceleration, tool = np.zeros_like(bend[0]), np.zeros_like(bend[0]), np.zeros_like(s_ddot)
    for end, here in ((0, x[:-1, None]), (-1, x[1:, None])):
        velocity += 0.5 * (tangent[end] / path.velocity) ** 2 * here
        acceleration += 0.5 * np.abs(tangent[end] * s_ddot + bend[end] * here) / path.acceleration
        tool += 0.5 * here / ceiling[:, None] ** 2
    share: Array = np.concatenate([velocity, acceleration, tool], axis=1).max(axis=1)
    return share


def _squared(polynomial: Array) -> Array:
    """Bernstein coefficients (2 d + 1, ...) of the square of a polynomial (d + 1, ...)."""
    d = len(polynomial) - 1
    return np.stack(
        [
            sum(
                comb(d, i) * comb(d, k - i) / comb(2 * d, k) * polynomial[i] * polynomial[k - i]
                for i in range(max(0, k - d), min(d, k) + 1)
            )
            for k in range(2 * d + 1)
        ]
    )
