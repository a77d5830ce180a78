"""A small quadratic programme: the best step on a subspace and inside a box, by a primal active set."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..checks import Array
from .ranges import Mask

RANK_TOL = 1e-9
"""Singular values below this, of rows of length 1, are rounding."""

PULL_TOL = 1e-13
"""A held joint is let go only for a pull beyond rounding, or the active set could go round in circles."""


class Step(NamedTuple):
    """The minimiser d (n,) and the multipliers y of the rows C: H d + gradient + Cᵀ y = 0 on the joints off bounds."""

    d: Array
    multipliers: Array


def least_quadratic(H: Array, gradient: Array, C: Array, lower: Array, upper: Array) -> Step:
    """argmin ½ dᵀ H d + gradientᵀ d subject to C d = 0 and lower ≤ d ≤ upper, where lower ≤ 0 ≤ upper.

    H must be positive definite on the null space of C. Starting at d = 0, the joints of the active set are held at
    their bounds and the rest is solved; a bound that is met on the way joins the set, one whose multiplier has the
    wrong sign leaves it. Source: J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §16.5.
    """
    d = np.zeros_like(gradient)
    fixed = lower == upper
    held = fixed | (lower == 0) & (gradient > 0) | (upper == 0) & (gradient < 0)
    y = np.zeros(len(C))
    for _ in range(10 * len(d)):
        slope = gradient + H @ d
        move = _newton(H, slope, C, ~held)
        reach, blocking = _first_bound(d, move, lower, upper, ~held)
        if reach < 1.0:
            d = np.clip(d + reach * move, lower, upper)
            held[blocking] = True
            continue
        d = np.clip(d + move, lower, upper)
        slope = gradient + H @ d
        y = np.linalg.lstsq(C[:, ~held].T, -slope[~held], rcond=None)[0]
        pull = slope + C.T @ y
        wrong = held & ~fixed & ((d <= lower) & (pull < -PULL_TOL) | (d >= upper) & (pull > PULL_TOL))
        if not wrong.any():
            break
        held[int(np.argmax(np.where(wrong, np.abs(pull), -1.0)))] = False
    return Step(d, y)


def null_space(C: Array) -> Array:
    """An orthonormal basis (n, k) of the d with C d = 0."""
    if not len(C):
        return np.eye(C.shape[1])
    _, singular_values, Vt = np.linalg.svd(C)
    basis: Array = Vt[int((singular_values > RANK_TOL).sum()) :].T
    return basis


def _newton(H: Array, slope: Array, C: Array, free: Mask) -> Array:
    move = np.zeros_like(slope)
    N = null_space(C[:, free])
    if N.shape[1]:
        move[free] = -N @ np.linalg.solve(N.T @ H[np.ix_(free, free)] @ N, N.T @ slope[free])
    return move


def _first_bound(d: Array, move: Array, lower: Array, upper: Array, free: Mask) -> tuple[float, int]:
    """How much of `move` fits in the box, at most 1, and the joint that stops it."""
    room = np.full_like(d, np.inf)
    down, up = free & (move < 0), free & (move > 0)
    room[down] = (lower - d)[down] / move[down]
    room[up] = (upper - d)[up] / move[up]
    blocking = int(np.argmin(room))
    return min(float(room[blocking]), 1.0), blocking
