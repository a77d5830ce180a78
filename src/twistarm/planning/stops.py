"""Where a motion stops on its way, so that it takes least time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import pairwise

import numpy as np

from ..support.checks import Array

MOST_TRIED = 16
"""Greatest number of stops on the way, unless the motion stops after every leg."""

SHORT = 0.4
"""A leg is short if it takes less than this share of the time of either leg beside it."""


def best_stops(duration: Callable[[int, int], float], alone: Array, ends: Array) -> tuple[int, ...]:
    """Return after which of m legs to stop: none, all, or a few that save time.

    A stop may save time where both legs beside it take longer on the way than from rest to rest, and at both ends of a
    short leg. Such stops that do not help are left out one by one.

    Args:
        duration: The time [s] of legs i … j − 1 from rest to rest, without a stop between them.
        alone: The time of each leg from rest to rest (m,) [s].
        ends: When the motion without stops ends each leg (m,) [s].
    """
    count = len(alone)

    def whole(stops: Iterable[int]) -> float:
        return sum(duration(i, j) for i, j in pairwise([0, *stops, count]))

    passed = np.append(0.0, ends)
    slow = np.flatnonzero(passed[2:] - passed[:-2] > alone[1:] + alone[:-1]) + 1
    short = np.flatnonzero(alone[1:-1] < SHORT * np.minimum(alone[:-2], alone[2:])) + 1
    few = [tuple(stops.tolist()) for stops in (slow, np.union1d(short, short + 1)) if len(stops) <= MOST_TRIED]
    best = min(((), tuple(range(1, count)), *few), key=whole)
    if best in few:
        for stop in best:
            best = min(best, tuple(other for other in best if other != stop), key=whole)
    return best
