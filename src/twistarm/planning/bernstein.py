"""Bernstein coefficients of piecewise polynomials: what bounds them between their ends, without samples.

p(σ) = Σ b_k C(d, k) σ^k (1 − σ)^(d−k) on σ in [0, 1] lies between the least and the largest of its b_k, and b_0, b_d
are its values at the ends. Source: Farin, Curves and Surfaces for CAGD, chapters 4 and 5.
"""

from __future__ import annotations

from functools import cache
from math import comb

import numpy as np

from ..support.checks import Array, frozen

ENOUGH = 1e-10
"""How near, relatively, a bound comes to the largest magnitude that it bounds."""


def bernstein(coefficients: Array, durations: Array) -> Array:
    """Bernstein coefficients (d + 1, k, ...) of polynomials (d + 1, k, ...) on k pieces of the durations (k,)."""
    degree = len(coefficients) - 1
    powers = np.arange(degree, -1, -1.0)
    scale = (durations ** powers[:, None]).reshape(degree + 1, -1, *[1] * (coefficients.ndim - 2))
    return np.tensordot(_from_powers(degree), coefficients * scale, 1)


def largest(coefficients: Array, durations: Array) -> float:
    """An upper bound of max abs p(σ) of polynomials (d + 1, k, r) on k pieces.

    Branch and bound: pieces whose coefficients exceed the largest value seen are halved (de Casteljau) until the bound
    is within 1e-10 of a value that is taken.
    """
    b = np.moveaxis(bernstein(coefficients, durations), 0, -1).reshape(-1, len(coefficients))
    taken = 0.0
    while True:
        taken = max(taken, float(np.abs(b[:, [0, -1]]).max()))
        above = np.abs(b).max(-1) > taken * (1.0 + ENOUGH)
        if not above.any():
            return taken * (1.0 + ENOUGH)
        b = (b[above] @ _halving(b.shape[1] - 1)).reshape(-1, b.shape[1])


@cache
def _halving(degree: int) -> Array:
    """(d + 1, 2 d + 2): by de Casteljau's algorithm, the coefficients on one half of the piece, then on the other."""
    left = [[comb(i, j) / 2**i if j <= i else 0.0 for i in range(degree + 1)] for j in range(degree + 1)]
    return frozen(np.hstack([left, np.array(left)[::-1, ::-1]]))


@cache
def _from_powers(degree: int) -> Array:
    """(d + 1, d + 1): from coefficients of powers, highest first, to those of Bernstein's polynomials."""
    return frozen(
        [[comb(k, i) / comb(degree, i) if i <= k else 0.0 for i in range(degree, -1, -1)] for k in range(degree + 1)]
    )
