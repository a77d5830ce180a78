"""Cycles on a fixed time grid: no drift, missed cycles counted."""

from __future__ import annotations

import time
from math import floor, inf
from typing import Any

from ...support.errors import InputError, shown

ROUNDING = 1e-6
"""Part of a period that is rounding."""

LATEST = 1e12
"""Seconds (30,000 years) beyond any clock, except one that counts nanoseconds."""


def require_time(value: Any, name: str = "now") -> float:
    """`value`, a number of seconds; a broken clock's NaN is one too."""
    if not isinstance(value, float) and not (isinstance(value, int) and abs(value) < LATEST):
        raise InputError(f"{name} must be seconds of a clock, below {LATEST:g}; got {shown(value)}")
    return float(value)


class MonotonicClock:
    """The system's clock that is never set."""

    def now(self) -> float:
        """Seconds since some fixed moment."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Return at that moment, at once where it has passed."""
        left = require_time(moment, "moment") - time.monotonic()
        if left > 0.0:
            time.sleep(left)


class Metronome:
    """The grid t₀ + k · period [s] with t₀ the first tick. `next` is the next time.

    early: the part of a period by which a tick may be early, for timers with jitter.
    """

    def __init__(self, period: float, early: float = ROUNDING) -> None:
        self.period = period
        self._early = early
        self.next = -inf
        self._origin = -inf
        self._index = 0

    def tick(self, now: float) -> int:
        """The number of periods of this cycle: 1 on time, more after a delay, 0 if early.

        −1 if time ran backwards by a period or more; the grid then restarts.

        Raises InputError for a time that is not finite or at least 1e12 s, and keeps the grid.
        """
        if not abs(require_time(now)) < LATEST:
            raise InputError(f"now must be seconds of a clock, below {LATEST:g}; got {shown(now)}")
        if self._origin == -inf:
            return self._begin(now, 1)
        phase = (now - self._origin) / self.period
        index = floor(phase + self._early)
        periods = index - self._index
        if periods < 0:
            return self._begin(now, -1)
        self._origin = min(self._origin, now - index * self.period)
        self._index = index
        self.next = self._origin + (index + 1) * self.period
        return periods

    def _begin(self, now: float, periods: int) -> int:
        self._origin, self._index, self.next = now, 0, now + self.period
        return periods
