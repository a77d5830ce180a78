"""The search for what explains a log: sound motors, two of them swapped, or the fewest faults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..actuators import Actuators
from ..checks import Array
from .fit import best_fit, from_sound
from .hypotheses import AS_GOOD, CLEAR, UNEXPLAINED, Explanation, explained_by, fewest_faults
from .model import Wiring


@dataclass(frozen=True, eq=False)
class Found:
    """An explanation of a log, and the two motors (or none) that have to be swapped for it.

    `wiring` has them swapped already. `as_good` are others, which claim as many faults and fit as well.
    """

    wiring: Wiring
    explanation: Explanation
    swapped: tuple[int, ...] = ()
    as_good: tuple[Found, ...] = ()

    @property
    def fits(self) -> bool:
        """Whether what is left is no more than noise."""
        return self.explanation.fits(self.wiring)

    @property
    def claims(self) -> int:
        """How many faults are claimed: swapped motors are one, which looks like several."""
        return self.explanation.claims + len(self.swapped) // 2

    @property
    def cost(self) -> float:
        """What is to be least."""
        return self.explanation.cost + CLEAR * (len(self.swapped) // 2)

    def as_well(self, total: float) -> bool:
        """Whether what leaves this sum of squares explains the log as well."""
        return total < self.explanation.total + AS_GOOD * self.explanation.scale


def readings(motors: Actuators, counts: Array) -> Array:
    """What the motors read from their zeros (K, k) [rad or m]."""
    return motors.from_counts(counts) - motors.offset


def swapped(wiring: Wiring, motors: Actuators, pair: tuple[int, ...]) -> Wiring:
    """The same with the counts of two motors swapped, or of none."""
    if not pair:
        return wiring
    order = np.arange(wiring.k)
    order[list(pair)] = pair[::-1]
    counts = motors.to_counts(wiring.y + motors.offset)
    return replace(wiring, y=readings(motors, counts[:, order]))


def as_sound(wiring: Wiring) -> Found:
    """The arm as its arm.toml says, whether it fits or not."""
    return Found(wiring, explained_by(wiring, wiring.sound, ("sound",) * wiring.k, 1.0))


def search(wiring: Wiring, motors: Actuators, progress: Callable[[float], object]) -> Found:
    """What explains the log, or comes nearest to it; `progress(fraction)` is called where that takes long."""
    plain = _near(wiring, ())
    if plain.explanation.sound:
        return plain
    swaps = [(swapped(wiring, motors, pair), pair) for pair in combinations(range(wiring.k), 2)]
    close = [_near(other, pair) for other, pair in swaps if may_fit(other, other.sound)]
    near = [*([plain] if plain.fits else []), *(found for found in close if found.explanation.sound)]
    if near:
        best = min(near, key=lambda found: found.cost)
        as_good = [one for one in near if one.claims == best.claims and best.as_well(one.explanation.total)]
        return replace(best, as_good=tuple(one for one in as_good if one is not best))
    far = Found(wiring, fewest_faults(wiring, *best_fit(wiring, progress)))
    if far.fits:
        return far
    return min([far, *(_near(other, pair) for other, pair in swaps)], key=lambda found: found.explanation.total)


def _near(wiring: Wiring, pair: tuple[int, ...]) -> Found:
    return Found(wiring, fewest_faults(wiring, *from_sound(wiring)), pair)


def may_fit(wiring: Wiring, p: Array) -> bool:
    """Whether a look at the residual near p leaves it open that the log is explained; a fit takes much longer."""
    r = wiring.residual(p)
    return float(r @ r) <= UNEXPLAINED * (len(r) + CLEAR)
