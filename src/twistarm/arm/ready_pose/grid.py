"""The round values of each coordinate of a computed configuration, with their costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED, JointLimits
from ...support.checks import Array

Rows = np.ndarray[tuple[int, ...], np.dtype[np.intp]]

STEPS = {"rad": (15.0, 5.0, 1.0, 0.5, 0.1), "m": (0.05, 0.01, 0.005, 0.001)}
"""Steps between values [°, m]. A coordinate takes the first step that gives it `FEW` values."""

FEW = 5

ROUND = {"rad": (90.0, 45.0, 30.0, 15.0, 5.0), "m": (0.5, 0.1, 0.05, 0.01)}
"""Round numbers [°, m]. A multiple of the first is the roundest."""

WINDOW = {"rad": np.pi, "m": 1.0}
"""The largest distance of a value from the middle of the range, or from 0."""

MARGIN, COMFORT = 0.1, 0.25
"""Least distance from a bound, and the distance below which nearness costs, as shares of the range."""

BENT, LESS_ROUND, NEAR = 0.25, 0.05, 1.0
"""Costs of a coordinate that is not at rest, of each step of roundness lost, and of a value at `MARGIN`."""


@dataclass(frozen=True)
class Grid:
    """Up to k values for n coordinates: `values` and `cost` (n, k), their `count` (n,) and the index of `rest` (n,).

    A configuration is a row of n indices. At rest a coordinate is 0 if that is off its bounds. Otherwise it is a round
    number near the middle of its range.
    """

    values: Array
    cost: Array
    count: Rows
    rest: Rows

    def theta(self, rows: Rows) -> Array:
        """Postures (..., n) of rows of indices (..., n)."""
        return self.values[np.arange(len(self.count)), rows]

    def costs(self, rows: Rows) -> Array:
        """The sum of the costs of each row, (...)."""
        return self.cost[np.arange(len(self.count)), rows].sum(-1)


def grid_of(limits: JointLimits, bounds: tuple[Array, Array], units: tuple[str, ...]) -> Grid:
    """The round values inside `limits`. `bounds` are the finite lower and upper (n,)."""
    span = bounds[1] - bounds[0]
    lower = np.where((limits.lower > -AS_GOOD_AS_UNBOUNDED) | (span == 0.0), bounds[0], -np.inf)
    upper = np.where((limits.upper < AS_GOOD_AS_UNBOUNDED) | (span == 0.0), bounds[1], np.inf)
    columns = [_column(*each) for each in zip(lower, upper, span, units, strict=True)]
    count = np.array([len(values) for values, _, _ in columns])
    values, cost = np.zeros((2, len(columns), count.max()))
    for i, (its_values, its_cost, _) in enumerate(columns):
        values[i, : count[i]] = np.clip(its_values, limits.lower[i], limits.upper[i])
        cost[i, : count[i]] = its_cost
    return Grid(values, cost, count, np.array([rest for _, _, rest in columns]))


def _column(lower: float, upper: float, span: float, unit: str) -> tuple[Array, Array, int]:
    """Values and costs of one coordinate, and the index of rest. Without a bound `lower` and `upper` are ∓inf."""
    low, high = lower + MARGIN * span, upper - MARGIN * span
    middle = 0.0
    if not low <= 0.0 <= high:
        middle = float(np.clip(0.5 * (low + high) if high - low < np.inf else 0.0, low, high))
    scale = np.pi / 180.0 if unit == "rad" else 1.0
    first, last = max(low, middle - WINDOW[unit]) / scale, min(high, middle + WINDOW[unit]) / scale
    for step in STEPS[unit]:
        numbers = np.round(np.arange(np.ceil(first / step - 1e-9), np.floor(last / step + 1e-9) + 1) * step, 6)
        if len(numbers) >= FEW:
            break
    else:
        return np.array([middle]), np.zeros(1), 0
    whole = numbers[:, None] / np.array(ROUND[unit])
    values, lost = numbers * scale, np.cumprod(np.abs(whole - np.round(whole)) > 1e-6, axis=1).sum(1)
    cost = BENT + LESS_ROUND * lost
    rest = int(np.argmin(np.round(cost + np.abs(values - middle) / WINDOW[unit], 9) * (values != 0.0)))
    cost[rest] = 0.0
    near = np.minimum(values - lower, upper - values) / span
    return values, cost + NEAR * np.maximum(0.0, COMFORT - near) / (COMFORT - MARGIN), rest
