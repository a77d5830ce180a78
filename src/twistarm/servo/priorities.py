"""Which twist an arm does that has fewer than six directions: what matters more comes first."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..checks import Array

SLIGHT = 0.3
"""A cosine between the arm's directions and what is asked below which following it is damped: it would take more than
three times as much motion in what matters less."""

NONE = 1e-3
"""A cosine below this is a right angle."""


def prior_shares(U: Array, asked: Array, levels: Sequence[tuple[int, ...]]) -> Array:
    """The shares a (k,) of k orthonormal directions U (6, k) that meet each level of `asked` (6,) after those before.

    For each level: A = U_level (I − Q Qᵀ) = X C Yᵀ, Q the shares that the levels before have used, and
    a += Σ y xᵀ(asked − U a) / c, damped for c below `SLIGHT`. Y. Nakamura, H. Hanafusa & T. Yoshikawa, Task-priority
    based redundancy control of robot manipulators, IJRR 6(2), 1987.
    """
    shares, free = np.zeros(U.shape[1]), np.eye(U.shape[1])
    for level in levels:
        rows = U[list(level)]
        left = asked[list(level)] - rows @ shares
        X, cosines, Yt = np.linalg.svd(rows @ free, full_matrices=False)
        for x, c, y in zip(X.T, cosines, Yt, strict=True):
            if c > NONE:
                shares = shares + _inverse(float(c)) * float(x @ left) * y
                free = free - np.outer(y, y)
    return shares


def _inverse(c: float) -> float:
    """1/c; below SLIGHT 4d / (SLIGHT² + 3d²), with d from 0 to SLIGHT while c goes there from NONE."""
    if c >= SLIGHT:
        return 1.0 / c
    d = SLIGHT * (c - NONE) / (SLIGHT - NONE)
    return 4.0 * d / (SLIGHT * SLIGHT + 3.0 * d * d)
