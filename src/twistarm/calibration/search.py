"""The search for an explanation of a log: sound motors, a swap, or the fewest faults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array
from .fit import best_fit, refine
from .hypotheses import AS_GOOD, CLEAR, UNEXPLAINED, Explanation, explained_by, fewest_faults
from .model import Wiring

Progress = Callable[[float], object]


@dataclass(frozen=True, eq=False)
class Found:
    """An explanation of a log, and the swapped motors, if any.

    `wiring` has them swapped already. `as_good` are others that claim as many faults and fit as well. `or_base` is
    what remains to claim if the base may stand beside its measured place.
    """

    wiring: Wiring
    explanation: Explanation
    swapped: tuple[int, ...] = ()
    as_good: tuple[Found, ...] = ()
    or_base: Found | None = None

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


def search(wiring: Wiring, motors: Actuators, doubted: tuple[float, float], progress: Progress) -> Found:
    """The best explanation of the log. Long searches call `progress(fraction)`.

    If the log is not sound, the search repeats with a base of uncertainty `doubted` [m, rad]. With either base it looks
    near the sound arm first. If neither explains the log, it looks farther.
    """
    exact = _near_sound_arm(wiring, motors)
    if exact.fits and exact.explanation.sound and not exact.swapped:
        return exact
    loose = replace(wiring, base=doubted)
    if doubted == wiring.base:
        return exact if exact.fits else _anywhere(wiring, motors, progress)
    if exact.fits:
        return likelier(exact, _with_movable_base(exact, loose, motors))
    other = _near_sound_arm(loose, motors)
    if other.fits:
        return other
    exact = _anywhere(wiring, motors, lambda fraction: progress(fraction / 2))
    if exact.fits:
        return likelier(exact, _with_movable_base(exact, loose, motors))
    other = _anywhere(loose, motors, lambda fraction: progress((1 + fraction) / 2))
    return other if other.fits else exact


def _near_sound_arm(wiring: Wiring, motors: Actuators) -> Found:
    """The fewest faults near the sound arm, perhaps with a swap. `fits`: they explain the log."""
    plain = _near(wiring, ())
    if plain.fits and plain.explanation.sound:
        return plain
    swaps = [(swapped(wiring, motors, pair), pair) for pair in combinations(range(wiring.k), 2)]
    close = [_near(other, pair) for other, pair in swaps if may_fit(other, other.sound)]
    near = [*([plain] if plain.fits else []), *(one for one in close if one.fits and one.explanation.sound)]
    if not near:
        return plain
    best = min(near, key=lambda found: found.cost)
    as_good = [one for one in near if one.claims == best.claims and best.as_well(one.explanation.total)]
    return replace(best, as_good=tuple(one for one in as_good if one is not best))


def _anywhere(wiring: Wiring, motors: Actuators, progress: Progress) -> Found:
    """The best fit of all tries. A swap of any two motors is the last resort."""
    far = Found(wiring, fewest_faults(wiring, *best_fit(wiring, progress)))
    if far.fits:
        return far
    pairs = combinations(range(wiring.k), 2)
    swaps = [_near(swapped(wiring, motors, pair), pair) for pair in pairs]
    return min([far, *swaps], key=lambda found: found.explanation.total)


def _with_movable_base(exact: Found, loose: Wiring, motors: Actuators) -> Found:
    """The claims with a movable base: near the sound arm, or near the exact base's result."""
    other = swapped(loose, motors, exact.swapped)
    start = Found(other, fewest_faults(other, *refine(other, exact.explanation.p)), exact.swapped)
    return min([start, _near_sound_arm(loose, motors)], key=lambda found: (not found.fits, found.cost))


def likelier(exact: Found, doubted: Found) -> Found:
    """The likelier explanation: with the base as given, or with one that may stand elsewhere.

    The costs are −2 ln of the marginal likelihood. They include ln det C of the base's random effect. Each claim about
    a motor or the base costs `CLEAR`. If both explain the log, `or_base` keeps the other one.
    """
    if not doubted.fits or doubted.wiring.base_error is None:
        return exact
    scale = doubted.explanation.scale
    of_base = doubted.wiring.base_error.complexity + CLEAR
    as_said = replace(exact, explanation=replace(exact.explanation, scale=scale))
    if not exact.fits or doubted.cost + of_base < as_said.cost:
        return doubted
    return replace(exact, or_base=doubted)


def _near(wiring: Wiring, pair: tuple[int, ...]) -> Found:
    return Found(wiring, fewest_faults(wiring, *refine(wiring, wiring.sound)), pair)


def may_fit(wiring: Wiring, p: Array) -> bool:
    """Whether the residual near p may explain the log; a full fit takes much longer."""
    r = wiring.residual(p)
    return float(r @ r) <= UNEXPLAINED * (len(r) + CLEAR)
