"""A strictly convex quadratic within bounds: least ½ xᵀ H x − rᵀ x over lower ≤ x ≤ upper."""

from __future__ import annotations

import numpy as np

from twistarm.support.checks import Array

ROUNDING = 1e-10
"""Of the slope: a smaller pull off a bound is rounding."""


def least_in_box(H: Array, r: Array, lower: Array, upper: Array, x: Array, at: Array) -> tuple[Array, Array]:
    """The least x (n,), and which bound each of its numbers stands at: −1 the lower, 1 the upper, 0 neither.

    H (n, n) is positive definite; x and `at` are where the search starts, within the bounds. The active-set method:
    J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §16.5.
    """
    x, at = x.copy(), at.copy()
    for _ in range(8 * len(x)):
        free = at == 0
        y = x.copy()
        if free.any():
            y[free] = np.linalg.solve(H[np.ix_(free, free)], r[free] - H[np.ix_(free, ~free)] @ x[~free])
        outside = free & ((y > upper) | (y < lower))
        if outside.any():
            end = np.where(y > upper, upper, lower)
            share = np.full(len(x), np.inf)
            share[outside] = np.maximum((end - x)[outside] / (y - x)[outside], 0.0)
            met = int(np.argmin(share))
            x[free] = np.clip(x + share[met] * (y - x), lower, upper)[free]
            at[met], x[met] = (1 if y[met] > upper[met] else -1), end[met]
            continue
        x = y
        slope = H @ x - r
        pull = np.where(free, 0.0, np.where(at < 0, -slope, slope) - ROUNDING * np.abs(r))
        released = int(np.argmax(pull))
        if pull[released] <= 0.0:
            break
        at[released] = 0
    return x, at
