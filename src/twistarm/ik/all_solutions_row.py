"""All configurations of one target as a row of numbers, whoever found them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..support.checks import Array
from .closed_form.roots import Root
from .targets import AnyTarget, numbers_of_kind

INSIDE, COUNT, TRIES, HITS, KIND, LEFT, FAMILIES = range(7)
"""Where each single number stands in what was found: how many are inside the limits and how many in all, searches or
values that were tried and how many of them had an answer, the target's kind, how many of a continuous family stand
outside the limits, whose members inside are left to look for, and how many are of any such family, some of which may
be one; core/bindings/closed_form.cpp writes the same."""

FIRST = 7
"""Behind them stand theta0 (n), the target's numbers, and for each configuration theta (n) and which of its joints may
move (n) as 0 and 1: those inside first."""


def found_row(target: AnyTarget, theta0: Array, inside: Array, outside: Array, tries: tuple[int, int]) -> Array:
    """What was found, as one read-only row of numbers: `inside` and `outside` (…, 2 n) are theta beside what moves."""
    single = [len(inside), len(inside) + len(outside), *tries, target.kind, 0, 0]
    row = np.concatenate([single, theta0, target.numbers.ravel(), inside.ravel(), outside.ravel()])
    row.flags.writeable = False
    return row


def configurations_in(row: Array, n: int) -> tuple[Array, Array]:
    """Those inside the limits and those outside, (…, 2 n)."""
    rows = row[FIRST + n + numbers_of_kind(int(row[KIND])) :].reshape(-1, 2 * n)
    return rows[: int(row[INSIDE])], rows[int(row[INSIDE]) :]


def roots_in(row: Array, n: int) -> Iterator[Root]:
    """The same as roots."""
    for each in np.concatenate(configurations_in(row, n)):
        yield Root(each[:n], tuple(np.flatnonzero(each[n:]).tolist()))
