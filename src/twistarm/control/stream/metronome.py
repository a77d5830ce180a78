"""Cycles on a fixed time grid: no drift, missed cycles counted, lateness in bounded memory."""

from __future__ import annotations

import time
from math import ceil, exp, floor, inf, log
from typing import Any

from ...support.errors import InputError, shown

ROUNDING = 1e-6
"""Part of a period that is rounding."""

LATEST = 1e12
"""Seconds (30,000 years) beyond any clock, except one that counts nanoseconds."""

FINEST = 1e-6
"""Lateness [s] below this counts as 0."""

BINS_PER_E = 100
"""Bins of the lateness within a factor e: percentiles are right to 1 %."""


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


class Lateness:
    """How long after their time cycles began: a histogram of logarithmic bins."""

    def __init__(self) -> None:
        self._bins: dict[int, int] = {}
        self._count = 0
        self.largest = 0.0

    def add(self, late: float) -> None:
        """One cycle that began `late` [s]."""
        index = ceil(log(max(late, FINEST) / FINEST) * BINS_PER_E)
        self._bins[index] = self._bins.get(index, 0) + 1
        self._count += 1
        self.largest = max(self.largest, late)

    def percentile(self, percent: float) -> float:
        """The lateness [s] that `percent` of the cycles kept within; 0 without cycles."""
        wanted, seen = self._count * percent / 100.0, 0
        for index in sorted(self._bins):
            seen += self._bins[index]
            if seen >= wanted:
                return min(self.largest, FINEST * exp(index / BINS_PER_E))
        return self.largest
