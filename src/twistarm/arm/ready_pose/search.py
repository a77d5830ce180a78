"""The configuration of least cost: the best of seeded configurations, improved step by step."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

import numpy as np

from ...support.checks import Array
from .grid import Grid, Rows, grid_of
from .merit import Merit, merit_of
from .overlaps import overlapping_links

if TYPE_CHECKING:
    from ..arm import Arm

SAMPLES, KNOWING = 192, 24
"""Number of first configurations, and how many of them give the ranks."""

BEST, ROUNDS = 3, 10
"""How many of them are improved, and in at most how many rounds."""

TRIES = 8
"""The most neighbours to check for overlapping links, the best first."""

RESTING = 0.45
"""The share of coordinates that rest in the first configurations."""

STRIDES = (-1, 1, -3, 3, -6, 6)
"""Steps of a coordinate."""

VERTICAL = 0.999
"""The least |z| of the axis of a base turn, a unit vector."""

USUALLY = 0.9
"""Links that overlap in this share of configurations overlap by their drawing."""

_Found = dict[bytes, tuple[Rows, float]]
"""Rows (n,) and their costs, no row twice."""


def computed_ready(arm: Arm) -> Array:
    """A computed configuration (n,) off the bounds, well conditioned, above the base plane with the tool in front.

    Pairs of links that nearly always overlap do not count. Products of exponentials in NumPy make the result
    independent of the engine.
    """
    grid = grid_of(arm.limits, arm.sampling_bounds, arm.units)
    moving = np.flatnonzero((grid.count > 1) & ~_base_turn(arm, grid))
    rows = _first(grid, moving)
    search = _Search(merit_of(arm, grid, rows[:KNOWING]), moving, _free(arm, grid, rows[:KNOWING]))
    return grid.theta(search.best(rows))


def _free(arm: Arm, grid: Grid, rows: Rows) -> Callable[[Rows], bool]:
    """Whether a row (n,) has only overlaps that most of `rows` have."""
    overlapping = overlapping_links(arm)
    if overlapping is None:
        return lambda row: True
    every = [overlapping(grid.theta(row)) for row in rows]
    counts = Counter(pair for pairs in every for pair in pairs)
    usual = {pair for pair, count in counts.items() if count >= USUALLY * len(rows)}
    return lambda row: overlapping(grid.theta(row)) <= usual


def _base_turn(arm: Arm, grid: Grid) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Marks (n,) the coordinate that turns the whole arm about a vertical axis. Its 0 defines the front."""
    marks = np.zeros(arm.n, dtype=bool)
    first = next((i for i, unit in enumerate(arm.units) if unit == "rad"), None)
    if first is not None and grid.theta(grid.rest)[first] == 0.0:
        axis = arm.screws[3:] @ arm.coupling.A[:, first]
        marks[first] = abs(axis[2]) > VERTICAL * float(np.linalg.norm(axis))
    return marks


def _first(grid: Grid, moving: Rows) -> Rows:
    """Rest, and seeded rows (N, n) around it."""
    numbers = np.random.default_rng(0).random((2, SAMPLES, len(grid.count)))
    rows = np.where(numbers[0] < RESTING, grid.rest, (numbers[1] * grid.count).astype(np.intp))
    fixed = np.setdiff1d(np.arange(len(grid.count)), moving)
    rows[:, fixed] = grid.rest[fixed]
    rows[0] = grid.rest
    return rows


@dataclass(frozen=True)
class _Search:
    """Downhill over the coordinates `moving`, from free rows to free rows."""

    merit: Merit
    moving: Rows
    free: Callable[[Rows], bool]

    def best(self, rows: Rows) -> Rows:
        """The cheapest row that is found from the best of `rows`."""
        costs = self.merit.costs(rows)
        order = np.argsort(costs, kind="stable")
        kept = list(islice((k for k in order if self.free(rows[k])), BEST)) or [order[0]]
        found: _Found = {rows[k].tobytes(): (rows[k], costs[k]) for k in kept}
        for _ in range(ROUNDS):
            better = self._step(*map(np.array, zip(*found.values(), strict=True)))
            if better.keys() == found.keys():
                break
            found = better
        row, _ = min(found.values(), key=lambda pair: pair[1])
        return row

    def _step(self, rows: Rows, costs: Array) -> _Found:
        """Each row, or the best of its free neighbours if that is better."""
        moved, mine = _neighbours(self.merit.grid, self.moving, rows)
        found = self.merit.costs(moved)
        better: _Found = {}
        for k in range(len(rows)):
            own = np.flatnonzero((mine == k) & (found < costs[k]))
            order = own[np.argsort(found[own], kind="stable")][:TRIES]
            best = next(((moved[j], found[j]) for j in order if self.free(moved[j])), (rows[k], costs[k]))
            better.setdefault(best[0].tobytes(), best)
        return better


def _neighbours(grid: Grid, moving: Rows, rows: Rows) -> tuple[Rows, Rows]:
    """Rows with one coordinate of `moving` some steps away or at rest, and the index of the row of each."""
    n = len(grid.count)
    steps = np.concatenate([stride * np.eye(n, dtype=np.intp)[moving] for stride in STRIDES])
    resting = np.repeat(rows[:, None], len(moving), axis=1)
    resting[:, np.arange(len(moving)), moving] = grid.rest[moving]
    moved = np.concatenate([rows[:, None] + steps, resting], axis=1)
    mine = np.repeat(np.arange(len(rows)), moved.shape[1])
    moved = moved.reshape(-1, n)
    inside = ((moved >= 0) & (moved < grid.count)).all(-1) & (moved != rows[mine]).any(-1)
    return moved[inside], mine[inside]
