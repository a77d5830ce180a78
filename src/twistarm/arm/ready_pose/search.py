"""The configuration of least cost in round numbers: the best of seeded configurations, improved step by step."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import cache
from itertools import islice

import numpy as np

from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from ..bodies import Pair
from .grid import Grid, Rows, grid_of
from .merit import FORBIDDEN, Mechanism, Merit

SAMPLES, KNOWING = 192, 24
"""Number of first configurations, and how many of them show the ranks and the usual overlaps."""

KEPT, ROUNDS = 4, 12
"""How many configurations are improved, and in at most how many rounds."""

RESTING = 0.45
"""The share of coordinates that rest in the first configurations."""

STRIDES = (-1, 1, -3, 3, -6, 6)
"""Steps of a coordinate."""

VERTICAL = 0.999
"""The least |z| of the axis of a base turn, a unit vector."""

USUALLY = 0.9
"""Links that overlap in this share of configurations overlap by their drawing."""


def round_configuration(
    arm: Mechanism,
    limits: JointLimits,
    bounds: tuple[Array, Array],
    overlapping: Callable[[Array], frozenset[Pair]] | None,
) -> Array:
    """A configuration (n,) off the bounds, well conditioned, above the base plane with the tool in front.

    It is singular only if all others are that the search meets. `overlapping` gives the pairs of links that overlap at
    theta (n,). Pairs that nearly always overlap do not count. `bounds` are finite lower and upper (n,). Products of
    exponentials in NumPy make the result independent of the engine.
    """
    grid = grid_of(limits, bounds, arm.units)
    moving = np.flatnonzero((grid.count > 1) & ~_base_turn(arm, grid))
    rows = _samples(grid, moving)
    merit = Merit(arm, grid, rows[:KNOWING])
    free = _free(grid, rows[:KNOWING], overlapping)
    kept = rows[:0]
    for _ in range(ROUNDS):
        costs = merit.costs(rows)
        rows = rows[np.argsort(costs, kind="stable")]
        regular = int((costs < FORBIDDEN).sum()) or len(rows)
        better = np.array([*islice((row for row in rows[:regular] if free(tuple(row))), KEPT)] or rows[:1])
        if np.array_equal(better, kept):
            break
        kept = better
        rows = np.unique(np.concatenate([_neighbours(grid, moving, row) for row in kept]), axis=0)[::-1]
    return grid.theta(kept[0])


def _free(
    grid: Grid, rows: Rows, overlapping: Callable[[Array], frozenset[Pair]] | None
) -> Callable[[tuple[int, ...]], bool]:
    """Whether a row (n,) has only overlaps that most of `rows` have."""
    if overlapping is None:
        return lambda row: True
    counts = Counter(pair for row in rows for pair in overlapping(grid.theta(row)))
    usual = {pair for pair, count in counts.items() if count >= USUALLY * len(rows)}
    return cache(lambda row: overlapping(grid.theta(np.array(row))) <= usual)


def _base_turn(arm: Mechanism, grid: Grid) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Marks (n,) the coordinate that turns the whole arm about a vertical axis. Its 0 defines the front."""
    marks = np.zeros(len(arm.units), dtype=bool)
    if "rad" in arm.units:
        first = arm.units.index("rad")
        axis = arm.screws[3:] @ arm.A[:, first]
        at_zero = grid.theta(grid.rest)[first] == 0.0
        marks[first] = at_zero and abs(axis[2]) > VERTICAL * float(np.linalg.norm(axis))
    return marks


def _samples(grid: Grid, moving: Rows) -> Rows:
    """Rest, and seeded rows (N, n) around it that differ in the coordinates `moving`."""
    numbers = np.random.default_rng(0).random((2, SAMPLES, len(grid.count)))
    rows = np.where(numbers[0] < RESTING, grid.rest, (numbers[1] * grid.count).astype(np.intp))
    fixed = np.setdiff1d(np.arange(len(grid.count)), moving)
    rows[:, fixed] = grid.rest[fixed]
    rows[0] = grid.rest
    return rows


def _neighbours(grid: Grid, moving: Rows, row: Rows) -> Rows:
    """`row` (n,), and rows (N, n) inside the grid with one coordinate of `moving` some steps away, or at rest."""
    rows = [row]
    for i in moving:
        for value in (*(row[i] + stride for stride in STRIDES), grid.rest[i]):
            if 0 <= value < grid.count[i]:
                moved = row.copy()
                moved[i] = value
                rows.append(moved)
    return np.array(rows)
