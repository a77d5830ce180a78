"""The largest ṡ² along a path within limits, on a grid: reachability analysis in two passes.

Source: Pham & Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO
34(3), 2018. The rows of each interval are from `interval_limits`. The compiled core makes the same passes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arm import engine
from ...support.checks import Array
from ..spans import SHORTEST
from .interval_limits import LimitedPath, derivatives, rows, used

CORRECTIONS = 64
"""Newton's steps to a corner of a convex region; a handful are needed."""

LONGEST_STEP = 1e-10
"""Least share of the value after a step down. Less would be rounding of a start that is much too large."""

SHORTEST_STEP = 1.0 - 1e-13
"""Greatest share of the value after a step down. Newton's step for a nearly vertical row is lost in rounding."""


class Profile(NamedTuple):
    """x = ṡ² (N + 1,) on a grid, and how far each interval uses its tightest limit (N,)."""

    x: Array
    share: Array


def path_velocity(path: LimitedPath, grid: Array) -> Profile:
    """The profile on the grid (N + 1,) over the path's length, with every breakpoint of the path.

    Backwards: from which x the end can be reached at rest. Forwards: the largest x, interval by interval, that stays
    among those. Every interval's region of (x0, x1) is convex and holds (0, 0), so neither pass can fail.
    """
    found = engine.asked("path_velocity", *vars(path).values(), grid, _unlimited(path))
    return in_numpy(path, grid) if found is None else Profile(*found)


def in_numpy(path: LimitedPath, grid: Array) -> Profile:
    """The same profile in NumPy."""
    tangent, bend, ceiling = derivatives(path, grid)
    steps = np.diff(grid)
    x = passes(*rows(path, tangent, bend, ceiling, steps), _unlimited(path))
    return Profile(x, used(path, tangent, bend, ceiling, steps, x))


def _unlimited(path: LimitedPath) -> float:
    """The largest ṡ² where nothing else limits it."""
    return float(path.breakpoints[-1] / SHORTEST) ** 2


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
