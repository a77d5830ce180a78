"""Joint coordinates to motors and back, motor = G theta + o: geared, belted and differential joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import Array, as_floats, as_theta, frozen
from .errors import InputError, listed

UNITS = {"rad": 1.0, "deg": 180.0 / np.pi, "turn": 0.5 / np.pi, "tick": np.nan, "m": 1.0, "mm": 1000.0}
"""What a motor's drive may count in, and how many of them are one rad (or one m); for ticks see `ticks_per_turn`."""

LINEAR_UNITS = ("m", "mm")
"""Units of a drive that pushes instead of turning."""

RANK_TOL = 1e-9
"""Relative to the equilibrated G: gear ratios are typed to a few digits, their differences are not smaller."""


@dataclass(frozen=True, eq=False)
class Actuators:
    """k motors that drive n joint coordinates: motor = G theta + o, both sides in rad, or m where they slide.

    `G` (k, n) holds motor rad per joint rad (rad per m for a slide), `offset` (k,) the motors at theta = 0. A motor on
    one joint has one entry in its row; the two motors of a differential wrist have two each. `units` says what each
    drive counts in (`UNITS`) and `ticks_per_turn` (k,) how fine, NaN where that was not given: see `to_counts`.

    Raises InputError for shapes that do not fit, numbers that are not finite, an unknown unit, ticks that are not
    positive, or a unit of ticks without them.
    """

    names: tuple[str, ...]
    joint_names: tuple[str, ...]
    G: Array
    offset: Array
    units: tuple[str, ...]
    ticks_per_turn: Array

    def __post_init__(self) -> None:
        k, n = len(self.names), len(self.joint_names)
        for name, shape in {"G": (k, n), "offset": (k,)}.items():
            values = as_floats(getattr(self, name), name)
            if values.shape != shape:
                raise InputError(f"{name} of {k} actuators and {n} joints must have shape {shape}; got {values.shape}")
            object.__setattr__(self, name, frozen(values))
        ticks = frozen(self.ticks_per_turn)
        if ticks.shape != (k,) or len(self.units) != k:
            raise InputError(f"{k} actuators need {k} units and ticks_per_turn; got {len(self.units)}, {ticks.shape}")
        object.__setattr__(self, "ticks_per_turn", ticks)
        for name, unit, count in zip(self.names, self.units, ticks, strict=True):
            _require_countable(name, unit, count)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    @property
    def undriven(self) -> tuple[str, ...]:
        """Joints that the motors do not determine: those with a share in the null space of G."""
        scaled = self.G * _factors(self.G, axis=1)
        scaled = scaled * _factors(scaled, axis=0)
        _, values, Vt = np.linalg.svd(scaled)
        null = Vt[int((values > RANK_TOL * max(values.max(initial=0.0), 1.0)).sum()) :]
        free = np.abs(null).max(axis=0, initial=0.0) > RANK_TOL
        return tuple(name for name, loose in zip(self.joint_names, free, strict=True) if loose)

    def to_motor(self, theta: ArrayLike) -> Array:
        """motor = G theta + o: theta (..., n) to motors (..., k) [rad or m]."""
        motor: Array = as_theta(theta, len(self.joint_names), names=self.joint_names) @ self.G.T + self.offset
        return motor

    def to_theta(self, motor: ArrayLike) -> Array:
        """theta (..., n) with G theta + o = motor, from motors (..., k) [rad or m].

        With more motors than joints the least squares: the theta that least |G theta + o − motor| [rad, m] leaves.
        Raises InputError naming the joints that the motors do not determine (G has not full column rank).
        """
        x = as_theta(motor, len(self.names), "motor", self.names)
        if self.undriven:
            raise InputError(
                f"the motors {listed(self.names)} do not determine joint {listed(self.undriven)}: "
                "G must have full column rank; describe the motors that drive them"
            )
        # A square G has one solution, however its rows are scaled; least squares would be weighed by that.
        rows = _factors(self.G, axis=1) if len(self.names) == len(self.joint_names) else np.ones((len(self.names), 1))
        columns = _factors(self.G * rows, axis=0)
        scaled = (x - self.offset) * rows[:, 0]
        theta: Array = scaled @ np.linalg.pinv(self.G * rows * columns).T * columns[0]
        return theta

    def to_counts(self, motor: ArrayLike) -> Array:
        """Motors (..., k) [rad or m] in what each drive counts, `units`; ticks are not rounded."""
        counts: Array = as_theta(motor, len(self.names), "motor", self.names) * self._per_radian
        return counts

    def from_counts(self, counts: ArrayLike) -> Array:
        """Motors (..., k) [rad or m] from what the drives count: the inverse of `to_counts`."""
        motor: Array = as_theta(counts, len(self.names), "counts", self.names) / self._per_radian
        return motor

    @property
    def _per_radian(self) -> Array:
        ticks = self.ticks_per_turn / (2 * np.pi)
        return np.array([t if unit == "tick" else UNITS[unit] for unit, t in zip(self.units, ticks, strict=True)])


def _require_countable(name: str, unit: str, ticks: float) -> None:
    if unit not in UNITS:
        raise InputError(f"actuator {name!r} counts in {unit!r}; allowed: {', '.join(UNITS)}")
    if not (np.isnan(ticks) or 0 < ticks < np.inf):
        raise InputError(f"actuator {name!r}: ticks_per_turn must be positive; got {ticks:g}")
    if unit == "tick" and np.isnan(ticks):
        raise InputError(f"actuator {name!r} counts in ticks: give its ticks_per_turn")
    if unit in LINEAR_UNITS and not np.isnan(ticks):
        raise InputError(f"actuator {name!r} counts in {unit} and makes no turns: leave out its ticks_per_turn")


def _factors(G: Array, axis: int) -> Array:
    """What makes rows (axis 1) or columns (axis 0) of G unit vectors: rad and m stand side by side in it."""
    size = np.linalg.norm(G, axis=axis, keepdims=True)
    factors: Array = 1.0 / np.where(size == 0, 1.0, size)
    return factors
