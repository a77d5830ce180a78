"""The largest ṡ² along a path within limits, on a grid, in NumPy: reachability analysis in two passes.

Source: Pham & Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO
34(3), 2018.

On an interval of length h where x is linear in s from x0 to x1, s̈ = (x1 − x0)/(2 h) is constant. A row p = C q, a
polynomial of degree d in s, has the acceleration p' s̈ + p'' x and the velocity p' ṡ. The acceleration has degree d −
1. The square of the velocity, p'² x, has degree 2 d − 1. Their Bernstein coefficients are linear in x0 and x1. If all
of them keep a limit, so do the polynomials on the whole interval.
"""

from __future__ import annotations

from math import comb, factorial

import numpy as np

from twistarm.planning.piecewise import bernstein, derivative, evaluate
from twistarm.planning.time_laws.time_optimal import LimitedPath, Profile, greatest_rate
from twistarm.support.checks import Array

CORRECTIONS = 64
"""Newton's steps to a corner of a convex region; a handful are needed."""

LONGEST_STEP = 1e-10
"""Least share of the value after a step down. Less would be rounding of a start that is much too large."""

SHORTEST_STEP = 1.0 - 1e-13
"""Greatest share of the value after a step down. Newton's step for a nearly vertical row is lost in rounding."""


def in_numpy(path: LimitedPath, grid: Array) -> Profile:
    """What `path_velocity` finds."""
    tangent, bend, ceiling = derivatives(path, grid)
    steps = np.diff(grid)
    x = passes(*rows(path, tangent, bend, ceiling, steps), greatest_rate(path))
    return Profile(x, used(path, tangent, bend, ceiling, steps, x))


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


def passes(A: Array, B: Array, most: float) -> Array:
    """x (N + 1,) from 0 to 0, at most `most`, with A x_i + B x_(i+1) ≤ 1 on every interval (N, q)."""
    count = len(A)
    controllable, x = np.zeros(count + 1), np.zeros(count + 1)
    for i in range(count - 1, 0, -1):
        controllable[i] = _largest_start(A[i], B[i], controllable[i + 1], most)
    for i in range(count):
        above = B[i] > 0
        reached = ((1.0 - A[i, above] * x[i]) / B[i, above]).min(initial=controllable[i + 1])
        x[i + 1] = max(reached, 0.0)
    return x


def _largest_start(a: Array, b: Array, end: float, most: float) -> float:
    """The largest x0 ≥ 0 for which an x1 in [0, end] has a x0 + b x1 ≤ 1.

    The room for x1 is the least upper bound minus the greatest lower one. It is concave in x0 and not negative at 0.
    From too large a start, Newton's method reaches its zero along finitely many lines.
    """
    level = (b == 0) & (a > 0)
    start = (1.0 / a[level]).min(initial=most)
    uppers, lowers = b > 0, b < 0
    for _ in range(CORRECTIONS):
        upper, rise = _tightest(a[uppers], b[uppers], start, end, -1.0)
        lower, fall = _tightest(a[lowers], b[lowers], start, 0.0, 1.0)
        if upper >= lower or rise >= fall:
            break
        newton = start + (upper - lower) / (fall - rise)
        start = min(max(newton, LONGEST_STEP * start), SHORTEST_STEP * start)
    return max(float(start), 0.0)


def _tightest(a: Array, b: Array, start: float, otherwise: float, sign: float) -> tuple[float, float]:
    """The tightest bound of x1 at x0 = start, and its slope. sign −1: the least, 1: the greatest."""
    if not len(b):
        return otherwise, 0.0
    bound = (1.0 - a * start) / b
    tightest = int(np.argmax(sign * bound))
    if sign * bound[tightest] <= sign * otherwise:
        return otherwise, 0.0
    return float(bound[tightest]), float(-a[tightest] / b[tightest])
