"""Searches from several starts, raced in rounds of eight, and the rule that says which of them wins."""

from __future__ import annotations

from dataclasses import dataclass

from ..arm import Arm
from ..checks import Array
from .damped import MAX_ITERATIONS, Search, Tolerances, search
from .deadline import Deadline
from .ranges import JointRanges
from .starts import random_start
from .task_space import Target

LANES = 8
"""Searches in a round. They run one after the other here; a faster solver runs them side by side."""


@dataclass(frozen=True, eq=False)
class Race:
    """How a race ended: the winner, if any converged, and every search that was run, in order."""

    winner: Search | None
    searches: tuple[Search, ...]


def race(
    arm: Arm,
    target: Target,
    first: Array,
    ranges: JointRanges,
    tolerances: Tolerances,
    *,
    restarts: int,
    seed: int,
    deadline: Deadline,
) -> Race:
    """At most `restarts` searches, the first from `first` (n,), search k from `random_start(ranges, seed, k)`.

    The winner: the first search, if it converges; else, in the first round of `LANES` in which any converges, the one
    with the fewest iterations, and among those the lowest k. So the answer does not depend on which search ends first
    on the clock.
    """
    bounds = ranges.search_lower, ranges.search_upper
    searches: list[Search] = []
    winner: Search | None = None
    for k in range(restarts):
        if (k % LANES == 0 and winner is not None) or (k > 0 and deadline.passed):
            break
        # Whoever does not need fewer iterations than the best of the round cannot win any more.
        patience = MAX_ITERATIONS if winner is None else winner.iterations - 1
        if patience < 0:
            break
        start = first if k == 0 else random_start(ranges, seed, k)
        searches.append(search(arm, target, start, bounds, tolerances, patience))
        if searches[-1].converged:
            winner = searches[-1]
            if k == 0:
                break
    return Race(winner, tuple(searches))
