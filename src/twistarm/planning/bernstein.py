"""Bernstein coefficients of piecewise polynomials, which bound them between their ends without samples.

p(σ) = Σ b_k C(d, k) σ^k (1 − σ)^(d−k) on σ in [0, 1] lies between the least and the largest b_k. It starts at b_0 and
ends at b_d. Source: Farin, Curves and Surfaces for CAGD, chapters 4 and 5.
"""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np

from ..support.checks import Array, frozen
from .piecewise import rescaled

PRECISION = 1e-10
"""How near, relatively, a bound comes to the largest magnitude that it bounds."""


def bernstein(coefficients: Array, durations: Array) -> Array:
    """Return Bernstein coefficients (d + 1, k, ...) of polynomials (d + 1, k, ...) on k pieces of durations (k,)."""
    return np.tensordot(_from_powers(len(coefficients) - 1), rescaled(coefficients, durations), 1)


def largest(coefficients: Array, durations: Array) -> float:
    """Return an upper bound of max |p(σ)| of polynomials (d + 1, k, r) on k pieces.

    Branch and bound halves pieces (de Casteljau) with coefficients above the largest value seen. It ends when the bound
    is within 1e-10 of a value.
    """
    b = np.moveaxis(bernstein(coefficients, durations), 0, -1).reshape(-1, len(coefficients))
    taken = 0.0
    while True:
        taken = max(taken, float(np.abs(b[:, [0, -1]]).max()))
        above = np.abs(b).max(-1) > taken * (1.0 + PRECISION)
        if not above.any():
            return taken * (1.0 + PRECISION)
        b = (b[above] @ _halving(b.shape[1] - 1)).reshape(-1, b.shape[1])


@cache
def _halving(degree: int) -> Array:
    """Return (d + 1, 2 d + 2): the coefficients on the first half, then on the second (de Casteljau)."""
    left = [[comb(i, j) / 2**i if j <= i else 0.0 for i in range(degree + 1)] for j in range(degree + 1)]
    return frozen(np.hstack([left, np.array(left)[::-1, ::-1]]))


@cache
def _from_powers(degree: int) -> Array:
    """Return (d + 1, d + 1): from coefficients of powers, highest first, to Bernstein coefficients."""
    return frozen(
        [[comb(k, i) / comb(degree, i) if i <= k else 0.0 for i in range(degree, -1, -1)] for k in range(degree + 1)]
    )
