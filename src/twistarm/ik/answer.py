"""One answer as a row of numbers, whoever found it: `IKSolution` reads one, `IKBatch` has one for each target.

What was found comes first, then what was asked: an array that the caller has changed since changes nothing.
"""

from __future__ import annotations

import numpy as np

from ..support.checks import Array
from .request import Request
from .targets import AnyTarget

POSITION_ERROR, ORIENTATION_ERROR, ITERATIONS, RESTARTS, STOP, FLAGS, KIND, POSITION_TOL, ORIENTATION_TOL = range(9)
"""Where each single number stands in a row; core/bindings/answer.hpp writes the same."""

FIRST = 9
"""Behind them stand theta (n), `unlimited` (n), theta0 (n) and the target's numbers."""

NEAREST, HAS_UNLIMITED, OTHER_BRANCH, START_MOVED, BY_CLOSED_FORM, CERTAIN = 1, 2, 4, 8, 16, 32
"""Flags: theta is the nearest configuration, looked for because no search met the target; `unlimited` is there; theta
is not near theta0, though the target is near theta0's pose, or cannot be met; theta0 lay outside the limits; theta
is of the closed form, after no search had met the target; the closed form shows that no configuration meets it."""

NOT_FINISHED = -1
"""In place of a reason: the time was up before the target was finished."""


def width(n: int, count: int) -> int:
    """Of a row of n coordinates and a target of `count` numbers."""
    return FIRST + 3 * n + count


def theta_in(rows: Array, n: int) -> Array:
    """(..., n) of rows (..., width)."""
    return rows[..., FIRST : FIRST + n]


def unlimited_in(rows: Array, n: int) -> Array:
    """(..., n): where limits block, an answer without them."""
    return rows[..., FIRST + n : FIRST + 2 * n]


def theta0_in(rows: Array, n: int) -> Array:
    """(..., n): where the search was to begin."""
    return rows[..., FIRST + 2 * n : FIRST + 3 * n]


def numbers_in(rows: Array, n: int, count: int) -> Array:
    """(..., count): the target's numbers."""
    return rows[..., FIRST + 3 * n : FIRST + 3 * n + count]


def row_of(
    target: AnyTarget,
    request: Request,
    theta: Array,
    *,
    stop: int,
    errors: tuple[float, float] = (np.inf, np.inf),
    iterations: int = 0,
    restarts: int = 0,
    flags: int = 0,
    unlimited: Array | None = None,
) -> Array:
    """A row, read-only, from what a solver in Python found; HAS_UNLIMITED follows from `unlimited`."""
    theta0, met = request.theta0, request.tolerances
    flags, beyond = (flags, np.zeros(len(theta))) if unlimited is None else (flags | HAS_UNLIMITED, unlimited)
    single = [*errors, iterations, restarts, stop, flags, target.kind, met.position, met.orientation]
    row = np.concatenate([single, theta, beyond, theta0, target.numbers.ravel()])
    row.flags.writeable = False
    return row
