"""A computed configuration to start from: round numbers of least cost at which no links overlap.

A table of costs judges configurations, for a singularity and for the stance of the arm. The stance is the arm drawn as
a line from axis to axis: above its base plane, tool in front, elbow up.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations, islice

import numpy as np

from ..description.tree import Description, Pair, sorted_pair
from ..support.checks import Array
from ..theory import poe
from ..theory.manipulability import scaled_jacobian
from ..theory.rotations import cross
from .bodies import Body, Shapes, adjacent_pairs
from .checker import Checker
from .pinocchio_model import PinocchioModel, import_pinocchio

WANTED = {
    "agility": (0.0, 1.5),
    "facing": (1.0, 0.5),
    "distance": (0.3, 5.0),
    "flatness": (0.0, 2.0),
    "hand down": (0.0, 1.0),
    "hand forward": (0.0, 1.5),
    "hand square": (0.0, 0.6),
    "clearance": (0.05, 8.0),
    "height": (0.0, 6.0),
    "arch": (0.1, 6.0),
    "sag": (0.0, 6.0),
}
"""The least value of each measure that costs nothing, and the cost of each unit less. Lengths are shares of the arm's
size. Agility is log₂ σ_k/σ_1, facing the cosine between the tool's direction and x, distance that of the tool from the
first axis. Flatness is minus the largest distance of a corner from the vertical plane through both. The hand is the
last stroke, a unit vector, square if level or vertical. Clearance is the lowest corner above the base plane, height
that of the tool above `LIFTED` and above `HANGING` below the shoulder. Arch and sag are the highest and the lowest
corner above the line from shoulder to tool."""

# Shares of the arm's size: the tool above the base plane, the tool below the shoulder, and the distance from the
# first axis below which a tool faces nowhere.
LIFTED, HANGING, NEAR_AXIS = 0.15, 0.2, 0.05
# The least σ_k/σ_1 of a regular configuration, and the cost of a singular one, larger than all other costs.
SINGULAR, FORBIDDEN = 0.01, 1e3
# The least σ_k/σ_1 that counts towards the rank, because exports round axes, and the least that differs from 0.
LOST, HOPELESS = 1e-3, 1e-6
DECIMALS = 6  # Decimals of compared costs, so that rounding does not choose between equal configurations.


@dataclass(frozen=True)
class Mechanism:
    """The numbers of an arm that a ready pose depends on: screws (6, m), coupling A (m, n), origin of the tool (3,)."""

    screws: Array
    A: Array
    tool: Array
    units: tuple[str, ...]
    reach: float

    def regular(self, theta: Array, samples: Array) -> bool:
        """Whether the tool moves in as many directions at theta (n,) as at some of `samples` (N, n)."""
        ranks = [(ratios > SINGULAR).sum(1) for ratios in self.look(np.vstack([theta, samples]))[1]]
        return all(bool(rank[0] >= rank[1:].max()) for rank in ranks)

    @cached_property
    def corners(self) -> Array:
        """Base, joints and tool at theta = 0, (m + 2, 3).

        A revolute joint's corner is the point of its axis nearest to the corner before. A slide repeats that corner.
        """
        corners = [np.zeros(3)]
        for v, w in self.screws.T.reshape(-1, 2, 3):
            corner = corners[-1]
            if w @ w > 0.5:
                on_axis = np.cross(w, v) / (w @ w)
                corner = on_axis + w * ((corner - on_axis) @ w) / (w @ w)
            corners.append(corner)
        return np.array([*corners, self.tool])

    def look(self, theta: Array) -> tuple[Array, list[Array]]:
        """The corners (N, m + 2, 3) in base axes at theta (N, n), and σ_k/σ_1, descending, of the tool's Jacobian.

        Metres are measured in the reach. Below six joints the ratios of the linear half follow, because a stretched
        arm of three still turns in three ways.
        """
        moved = poe.motions(self.screws, theta @ self.A.T)
        still = np.broadcast_to(np.eye(4), (len(theta), 1, 4, 4))
        poses = np.concatenate([still, moved, moved[:, -1:]], axis=1)
        corners = np.einsum("nkij,kj->nki", poses[..., :3, :3], self.corners) + poses[..., :3, 3]
        J = poe.columns(moved, self.screws) @ self.A
        J[:, :3] += np.swapaxes(cross(np.swapaxes(J[:, 3:], 1, 2), corners[:, -1:]), 1, 2)
        J = scaled_jacobian(J, np.array(self.units) == "m", self.reach)
        return corners, [_ratios(rows) for rows in ([J] if J.shape[2] >= 6 else [J, J[:, :3]])]


def _ratios(J: Array) -> Array:
    """σ_k/σ_1 of matrices (N, r, n), (N, r), none below `HOPELESS`."""
    squares = np.linalg.eigvalsh(J @ np.swapaxes(J, 1, 2))[:, ::-1]
    return np.sqrt(np.maximum(squares / np.maximum(squares[:, :1], 1e-300), HOPELESS**2))  # 1e-300: where J is 0


class Merit:
    """The costs of an arm's configurations. Some `samples` (N, n) show its rank and which corners it lifts."""

    def __init__(self, arm: Mechanism, samples: Array) -> None:
        self._arm = arm
        corners, ratios = arm.look(samples)
        self._ranks = [int((half > LOST).sum(1).max()) for half in ratios]
        # The corners before the first revolute joint are the mount.
        self._first = 1 + int(np.argmax(np.sum(arm.screws[3:] ** 2, axis=0) > 0.5))
        strokes = np.diff(arm.corners[self._first :], axis=0)
        self._size = float(np.linalg.norm(strokes, axis=1).sum()) or 1.0
        self._rising = np.ptp(corners[..., 2], axis=0) > 1e-3 * self._size
        self._shoulder = max(0, int(np.argmax(self._rising)) - 1)
        # A nearer corner is the tool's mount: the direction of so short a stroke says nothing of the hand.
        far = np.linalg.norm(arm.corners - arm.tool, axis=-1) > 0.03 * self._size
        self._wrist = int(np.flatnonzero(far)[-1]) if far.any() else 0

    def costs(self, theta: Array) -> Array:
        """Costs (N,) of theta (N, n)."""
        corners, ratios = self._arm.look(theta)
        least = np.min([half[:, rank - 1] for half, rank in zip(ratios, self._ranks, strict=True)], axis=0)
        measures = {
            "agility": np.log2(least),
            **self._front(corners / self._size),
            **self._heights(corners / self._size),
        }
        cost = np.where(least < SINGULAR, FORBIDDEN, 0.0)
        for name, measure in measures.items():
            wanted, price = WANTED[name]
            cost = cost + price * np.maximum(0.0, wanted - measure)
        return np.asarray(cost.round(DECIMALS))

    def _front(self, corners: Array) -> dict[str, Array]:
        """The measures seen from above, and those of the hand."""
        out = (corners - corners[:, self._first, None])[..., :2]
        distance = np.linalg.norm(out[:, -1], axis=-1)
        ahead = out[:, -1] / np.maximum(distance, 1e-12)[:, None]  # no division by 0; such rows are replaced next
        ahead[distance < NEAR_AXIS] = 1.0, 0.0
        aside = out[:, self._first :, 1] * ahead[:, None, 0] - out[:, self._first :, 0] * ahead[:, None, 1]
        hand = corners[:, -1] - corners[:, self._wrist]
        hand = hand / np.maximum(np.linalg.norm(hand, axis=-1, keepdims=True), 1e-12)
        level = np.linalg.norm(hand[:, :2], axis=-1)
        return {
            "facing": ahead[:, 0],
            "distance": distance,
            "flatness": -np.abs(aside).max(-1),
            "hand down": -hand[:, 2],
            "hand forward": np.sum(hand[:, :2] * ahead, axis=-1),
            "hand square": -np.minimum(np.abs(hand[:, 2]), level),
        }

    def _heights(self, corners: Array) -> dict[str, Array]:
        """The measures of corners and tool above the base plane, and above the line from shoulder to tool."""
        z, shoulder = corners[..., 2], corners[:, self._shoulder]
        measures = {}
        if self._rising.any():
            measures["clearance"] = z[:, self._rising].min(-1)
            measures["height"] = z[:, -1] - np.maximum(LIFTED, shoulder[:, 2] - HANGING)
        if self._rising.any() and corners.shape[1] > self._shoulder + 2:
            way = corners[:, -1] - shoulder
            between = corners[:, self._shoulder + 1 : -1] - shoulder[:, None]
            share = np.sum(between * way[:, None], axis=-1) / np.maximum(np.sum(way * way, axis=-1), 1e-12)[:, None]
            above = between[..., 2] - np.clip(share, 0.0, 1.0) * way[:, None, 2]
            measures |= {"arch": above.max(-1), "sag": above.min(-1)}
        return measures


Rows = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

# Steps between values [rad, m]. A coordinate takes the first step that gives it `FEW` values.
STEPS = {"rad": np.radians([15.0, 5.0, 1.0, 0.5, 0.1]), "m": np.array([0.05, 0.01, 0.005, 0.001])}

FEW = 5

WINDOW = {"rad": np.pi, "m": 1.0}  # The largest distance of a value from the middle of the range, or from 0.
# Least distance from a bound, and the distance below which nearness costs, as shares of the range.
MARGIN, COMFORT = 0.1, 0.25
BENT, NEAR = 0.25, 1.0  # Costs of a coordinate that is not at rest, and of a value at `MARGIN`.
# Number of first configurations, and how many of them show the ranks and the usual overlaps.
SAMPLES, KNOWING = 192, 24
KEPT, ROUNDS = 4, 12  # How many configurations are improved, and in at most how many rounds.
RESTING = 0.45  # The share of coordinates that rest in the first configurations.
STRIDES = (-1, 1, -3, 3, -6, 6)  # Steps of a coordinate.
VERTICAL = 0.999  # The least |z| of the axis of a base turn, a unit vector.
USUALLY = 0.9  # Links that overlap in this share of configurations overlap by their drawing.


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
        free = (row for row in rows[:regular] if is_free(tuple(row)))
        better = np.array(list(islice(free, KEPT)) or rows[:1])
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
                # 1e-9: a bound that is a multiple of the step counts, whatever its rounding.
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
        bent = np.where(rows != self.rest, BENT, 0.0)
        return np.asarray(np.sum(bent + NEAR / (COMFORT - MARGIN) * short, axis=-1))


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


# The most shapes and pairs of shapes. A larger robot is a scene and is not checked.
MOST_SHAPES, MOST_PAIRS = 500, 2_000

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
