"""The configuration of least cost in round numbers, in which no links overlap: a search from seeded configurations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import combinations, islice

import numpy as np

from ...description.tree import Description
from ...support.checks import Array
from ..bodies import Body, Pair, Shapes, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import PinocchioModel, import_pinocchio
from .merit import FORBIDDEN, Mechanism, Merit

Rows = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

STEPS = {"rad": np.radians([15.0, 5.0, 1.0, 0.5, 0.1]), "m": np.array([0.05, 0.01, 0.005, 0.001])}
"""Steps between values [rad, m]. A coordinate takes the first step that gives it `FEW` values."""

FEW = 5

WINDOW = {"rad": np.pi, "m": 1.0}
"""The largest distance of a value from the middle of the range, or from 0."""

MARGIN, COMFORT = 0.1, 0.25
"""Least distance from a bound, and the distance below which nearness costs, as shares of the range."""

BENT, NEAR = 0.25, 1.0
"""Costs of a coordinate that is not at rest, and of a value at `MARGIN`."""

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
    arm: Mechanism, bounds: tuple[Array, Array], overlapping: Callable[[Array], frozenset[Pair]] | None
) -> Array:
    """A configuration (n,) off the bounds, well conditioned, above the base plane with the tool in front.

    It is singular only if all others are that the search meets. `overlapping` gives the pairs of links that overlap at
    theta (n,). Pairs that nearly always overlap do not count. `bounds` are finite lower and upper (n,). Products of
    exponentials in NumPy make the result independent of the engine.
    """
    grid = Grid.of(bounds, arm.units)
    moving = [i for i in range(len(arm.units)) if grid.first[i] < grid.last[i] and not _is_base_turn(arm, grid, i)]
    rows = np.tile(grid.rest, (SAMPLES, 1))
    resting, share = np.random.default_rng(0).random((2, *rows.shape))
    bent = grid.first + (share * (grid.last - grid.first + 1)).astype(np.intp)
    rows[1:, moving] = np.where(resting < RESTING, rows, bent)[1:, moving]
    merit = Merit(arm, grid.theta(rows[:KNOWING]))
    is_free = _free(grid, rows[:KNOWING], overlapping)
    kept = rows[:0]
    for _ in range(ROUNDS):
        costs = grid.costs(rows) + merit.costs(grid.theta(rows))
        rows = rows[np.argsort(costs, kind="stable")]
        regular = int((costs < FORBIDDEN).sum()) or len(rows)
        better = np.array([*islice((row for row in rows[:regular] if is_free(tuple(row))), KEPT)] or rows[:1])
        if np.array_equal(better, kept):
            break
        kept = better
        rows = np.unique(np.concatenate([_neighbours(grid, moving, row) for row in kept]), axis=0)[::-1]
    return grid.theta(kept[0])


@dataclass(frozen=True)
class Grid:
    """Coordinate i takes the values offset + k step with first ≤ k ≤ last, and rests at k = rest. All are (n,).

    A configuration is a row of n numbers k. At rest a coordinate is 0 if that is off its bounds, else near the middle
    of its range.
    """

    bounds: tuple[Array, Array]
    offset: Array
    step: Array
    first: Rows
    last: Rows
    rest: Rows

    @classmethod
    def of(cls, bounds: tuple[Array, Array], units: tuple[str, ...]) -> Grid:
        """The round values inside finite bounds, lower and upper (n,)."""
        columns = []
        for lower, upper, unit in zip(*bounds, units, strict=True):
            low, high = lower + MARGIN * (upper - lower), upper - MARGIN * (upper - lower)
            middle = 0.0 if low <= 0.0 <= high else 0.5 * (low + high)
            column = middle, 0.0, 0, 0, 0
            for step in STEPS[unit]:
                first = int(np.ceil(max(low, middle - WINDOW[unit]) / step - 1e-9))
                last = int(np.floor(min(high, middle + WINDOW[unit]) / step + 1e-9))
                if last - first + 1 >= FEW:
                    column = 0.0, step, first, last, round(middle / step)
                    break
            columns.append(column)
        return cls(bounds, *map(np.array, zip(*columns, strict=True)))

    def theta(self, rows: Rows) -> Array:
        """Configurations (..., n) of rows (..., n)."""
        return np.clip(self.offset + rows * self.step, *self.bounds)

    def costs(self, rows: Rows) -> Array:
        """The costs of rows (..., n) that are not at rest or near a bound, (...)."""
        lower, upper = self.bounds
        theta, span = self.theta(rows), np.where(upper > lower, upper - lower, 1.0)
        short = np.maximum(0.0, COMFORT - np.minimum(theta - lower, upper - theta) / span)
        return np.asarray(np.sum(BENT * (rows != self.rest) + NEAR / (COMFORT - MARGIN) * short, axis=-1))


def _free(
    grid: Grid, rows: Rows, overlapping: Callable[[Array], frozenset[Pair]] | None
) -> Callable[[tuple[int, ...]], bool]:
    """Whether a row (n,) has only overlaps that most of `rows` have."""
    if overlapping is None:
        return lambda row: True
    counts = Counter(pair for row in rows for pair in overlapping(grid.theta(row)))
    usual = {pair for pair, count in counts.items() if count >= USUALLY * len(rows)}
    return cache(lambda row: overlapping(grid.theta(np.array(row))) <= usual)


def _is_base_turn(arm: Mechanism, grid: Grid, i: int) -> bool:
    """Whether a coordinate is the first turn, about a vertical axis. Its 0 defines the front."""
    axis = arm.screws[3:] @ arm.A[:, i]
    first = "rad" in arm.units and arm.units.index("rad") == i
    return first and grid.theta(grid.rest)[i] == 0.0 and abs(axis[2]) > VERTICAL * float(np.linalg.norm(axis))


def _neighbours(grid: Grid, moving: list[int], row: Rows) -> Rows:
    """`row` (n,), and rows (N, n) inside the grid with one coordinate of `moving` some steps away, or at rest."""
    rows = [row]
    for i in moving:
        for value in (*(row[i] + stride for stride in STRIDES), grid.rest[i]):
            if grid.first[i] <= value <= grid.last[i]:
                moved = row.copy()
                moved[i] = value
                rows.append(moved)
    return np.array(rows)


MOST_SHAPES, MOST_PAIRS = 500, 2_000
"""The most shapes and pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"


def overlapping_links(
    model: PinocchioModel, description: Description, base: str, first: str, reach: float, exempt: frozenset[Pair]
) -> Callable[[Array], frozenset[Pair]] | None:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the `first` joint carries is tested against the rest and the base plane, except adjacent links and pairs that
    are `exempt`. None with more than `MOST_SHAPES` or `MOST_PAIRS`.
    """
    shapes = Shapes(import_pinocchio().coal, rough=True)
    moved = description.beyond(first)
    ground = Body(GROUND, base, shapes.half_space(), np.eye(4), "plane")
    bodies = [ground, *islice(shapes.of_links(description, reach), MOST_SHAPES)]
    joints = [model.model.frames[model.frame_id(body.carrier)].parentJoint for body in bodies]
    names = [body.name for body in bodies]
    exempt = exempt | adjacent_pairs(description, bodies)
    pairs = [
        (i, j)
        for i, j in combinations(range(len(bodies)), 2)
        if (names[i] in moved or names[j] in moved)
        and joints[i] != joints[j]
        and sorted_pair(names[i], names[j]) not in exempt
    ]
    if len(bodies) > MOST_SHAPES or len(pairs) > MOST_PAIRS:
        return None
    checker = Checker(model, bodies, pairs, [0.0] * len(pairs))

    def overlapping(theta: Array) -> frozenset[Pair]:
        hit = (checker.pairs[k] for k in checker.overlapping(model.q(theta)))
        return frozenset((names[i], names[j]) for i, j in hit)

    return overlapping
