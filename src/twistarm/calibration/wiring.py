"""Explanations of a wiring log: calibration whose starts are signs, ratios, zeros and swaps of motors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..limits.actuators import Actuators
from ..support.checks import Array
from ..theory.rotations import log_of
from .geometry import BASE, Geometry
from .measurements import Bools, Measurements
from .problem import Problem, descend


class Kind(NamedTuple):
    """A claim about a motor: its sign (0: any), whether scale and zero are fitted, and how many claims that is."""

    sign: float
    scale: bool
    zero: bool
    claims: float


KINDS = SOUND, REVERSED, ZERO, RATIO, REVERSED_ZERO, ANYTHING = (
    Kind(1.0, False, False, 0.0),
    Kind(-1.0, False, False, 1.0),
    Kind(1.0, False, True, 1.5),
    Kind(0.0, True, False, 1.5),
    Kind(-1.0, False, True, 2.5),
    Kind(0.0, True, True, 3.0),
)

CLEAR = 25.0  # A claim must lower the sum of squares by five standard deviations.
UNEXPLAINED = 9.0  # A greater mean square residual [standard deviations²] is not noise.

SCALES = (1.0, 0.1, 0.25, 0.5, 0.75, 1.5, 2.0, 4.0, 10.0)
OFFSETS = np.radians([0.0, 30.0, -30.0, 75.0, -75.0, 120.0, -120.0, 180.0])
# Where the fit of one motor may start: its scale, and what its zero adds to the joint [rad, m].
STARTS = np.array([(sign * s, e) for s in SCALES for sign in (1.0, -1.0) for e in OFFSETS])
MOST_CLAIMS = 6.0  # More is not claimed by and by: two motors of which anything is wrong, or six reversed ones.
MOST_SIGNS = 8  # Motors up to which every pattern of signs is tried.
# Moments of a fit and of a search for starts: neighbouring moments of a camera have the same errors.
MOST_ROWS, FEW_ROWS = 200, 30
# Allowed contradiction of motors that share a joint [joint rad]: backlash and belts.
SLACK = float(np.radians(1.0))


@dataclass(frozen=True, eq=False)
class Explanation:
    """A kind for each motor, perhaps two that are swapped, and their fit.

    The fit is the unknowns q (Q,) and the sum of squares. Before it, q is where the fit starts.
    """

    kinds: tuple[Kind, ...]
    swap: tuple[int, ...]
    q: Array
    total: float = np.inf

    @property
    def claims(self) -> float:
        """How much is claimed of the motors: two swapped ones are one claim."""
        return sum(kind.claims for kind in self.kinds) + len(self.swap) / 2

    @property
    def zeros(self) -> Array:
        """What is added to the motors' readings (k,) [rad, m]."""
        return self.q[-2 * len(self.kinds) : -len(self.kinds)]

    @property
    def scales(self) -> Array:
        """What the motors' readings are multiplied by (k,)."""
        return np.asarray(1.0 + self.q[-len(self.kinds) :])

    def with_kind(self, i: int, kind: Kind) -> Explanation:
        """The same with another kind for motor i."""
        return replace(self, kinds=(*self.kinds[:i], kind, *self.kinds[i + 1 :]))


@dataclass(frozen=True, eq=False)
class Wiring:
    """A log of counts (K, k) as a problem of calibration.

    The unknowns are the base, the tool (held), the motors' zeros e [rad, m] and scales s − 1. Sound motors have s = 1,
    e = 0, and a reversed one s = −1. `base` is the standard deviation [m, rad] of the base's pose, 0 where it
    is held.
    """

    arm: Arm
    motors: Actuators
    log: Measurements
    noise: tuple[float, float]
    base: tuple[float, float]

    @property
    def k(self) -> int:
        """Motors."""
        return len(self.motors.names)

    @cached_property
    def unit(self) -> Array:
        """How far each motor turns (k,) for one rad (or m) of the joint that it moves most."""
        return np.asarray(1.0 / np.abs(self.motors.P).max(axis=0))

    @cached_property
    def problems(self) -> dict[tuple[int, ...], Problem]:
        """The problem as the log is, and with the counts of each two motors exchanged."""
        motors, k, P = self.motors, self.k, self.motors.P
        geometry = Geometry(self.arm, np.eye(4), np.eye(4), scales=True, axes=False, drive=P)
        prior = np.zeros(len(geometry.parameters))
        prior[BASE] = [1.0 / std if std else 0.0 for std in np.repeat(self.base, 3)]
        surplus = (np.eye(k) - motors.G @ P) / self.unit[:, None] / SLACK if k > self.arm.n else None
        problems = {}
        for swap in ((), *combinations(range(k), 2)):
            order = np.arange(k)
            order[list(swap)] = swap[::-1]
            readings = motors.from_counts(self.log.theta[:, order]) - motors.offset
            log = replace(self.log, theta=readings)
            problems[swap] = Problem(geometry, log, self.noise, prior, contradiction=surplus)
        return problems

    @property
    def freedom(self) -> int:
        """Numbers beyond the parameters of all motors, at least 1."""
        return max(self.problems[()].numbers - 2 * self.k, 1)

    def explains(self, one: Explanation) -> bool:
        """Whether what is left is no more than noise."""
        fitted = sum(kind.zero + kind.scale for kind in one.kinds)
        return one.total <= UNEXPLAINED * max(self.problems[()].numbers - fitted, 1)

    def free(self, one: Explanation) -> Bools:
        """The unknowns (Q,) that an explanation fits."""
        base, tool = np.repeat(np.array(self.base) > 0.0, 3), np.zeros(6, dtype=bool)
        return np.r_[base, tool, [kind.zero for kind in one.kinds], [kind.scale for kind in one.kinds]]

    def fit(self, start: Explanation) -> Explanation:
        """The explanation, fitted from its unknowns."""
        one = replace(start, q=start.q * self.free(start))
        one.q[BASE] = 0.0  # a wrong explanation drags the base far away, and from there the right one is not found
        one.q[-self.k :] += [0.0 if kind.scale else kind.sign - 1.0 for kind in one.kinds]
        problem = self.problems[one.swap]
        q, weights = descend(problem, one.q, self.free(one), robust=False)
        r = problem.residual(q, weights)
        return replace(one, q=q, total=float(r @ r))

    def squares(self, swap: tuple[int, ...], starts: Array) -> Array:
        """The sums of squares (M,) of unknowns (M, Q), with the base held, over a few rows."""
        problem, k, P = self.problems[swap], self.k, self.motors.P
        at = np.unique(np.linspace(0, len(problem.log.theta) - 1, FEW_ROWS).astype(int))
        driven = problem.log.theta[at] * (1.0 + starts[:, None, -k:]) + starts[:, None, -2 * k : -k]
        g = self.arm.fk(driven @ P.T)
        parts = [(g[..., :3, 3] - problem.log.position[at]) / problem.sigma[at, None]]
        if problem.measured[0, 3]:
            parts.append(log_of(np.swapaxes(problem.log.rotation[at], 1, 2) @ g[..., :3, :3]) / self.noise[1])
        if problem.contradiction is not None:
            parts.append(driven @ problem.contradiction.T)
        return np.asarray(sum((part * part).sum(axis=(1, 2)) for part in parts))

    def changes(self, one: Explanation) -> list[Explanation]:
        """Each single change, not fitted yet: another kind of a motor, from the best of its `STARTS`, or a swap."""
        k, swaps = self.k, [()] if one.swap else combinations(range(self.k), 2)
        changes = [replace(one, swap=swap) for swap in swaps]
        for i in range(k):
            starts = np.tile(one.q, (len(STARTS), 1))
            starts[:, i - k], starts[:, i - 2 * k] = STARTS[:, 0] - 1.0, STARTS[:, 1] * self.unit[i]
            totals = self.squares(one.swap, starts)
            for kind in (kind for kind in KINDS if kind != one.kinds[i]):
                allowed = (kind.scale | (STARTS[:, 0] == kind.sign)) & (kind.zero | (STARTS[:, 1] == 0.0))
                q = starts[np.where(allowed, totals, np.inf).argmin()]
                changes.append(replace(one.with_kind(i, kind), q=q))
        return changes


class Found(NamedTuple):
    """The explanation with the fewest claims, and the variance of what is left, at least 1."""

    best: Explanation
    variance: float

    def cost(self, one: Explanation) -> float:
        """What is to be least: −2 ln of the likelihood, and the price of each claim."""
        return one.total / self.variance + CLEAR * one.claims


def explained(wiring: Wiring) -> tuple[Wiring, Found]:
    """The explanation with the fewest faults, and the problem with its noise: as stated, or as found if that is more.

    The search starts from the sound arm, else from the likeliest pattern of signs.
    """
    k = wiring.k
    sound = wiring.fit(Explanation((SOUND,) * k, (), np.zeros(wiring.problems[()].P)))
    found = _climbed(wiring, sound, MOST_CLAIMS)
    if not wiring.explains(found.best):
        # With many motors at most two are reversed.
        flips = [pair for count in range(1, k + 1 if k <= MOST_SIGNS else 3) for pair in combinations(range(k), count)]
        starts = np.zeros((len(flips), len(sound.q)))
        for start, pair in zip(starts, flips, strict=True):
            start[[i - k for i in pair]] = -2.0
        likeliest = flips[wiring.squares((), starts).argmin()]
        signs = wiring.fit(replace(sound, kinds=tuple(REVERSED if i in likeliest else SOUND for i in range(k))))
        other = _climbed(wiring, signs, MOST_CLAIMS + signs.claims)
        found = other if wiring.explains(other.best) else found
    louder = float(np.sqrt(found.variance))
    if louder > 1.0 and wiring.explains(found.best):  # more noise does not make the base less certain
        wiring = replace(wiring, noise=(wiring.noise[0] * louder, wiring.noise[1] * louder))
        found = _climbed(wiring, wiring.fit(found.best), MOST_CLAIMS)
    for i in np.flatnonzero([kind.claims for kind in found.best.kinds]):  # another motor may be to blame
        other = _climbed(wiring, wiring.fit(found.best.with_kind(int(i), SOUND)), found.best.claims)
        found = min([found, other], key=lambda each: found.cost(each.best))
    return wiring, found


def _climbed(wiring: Wiring, one: Explanation, most: float) -> Found:
    """The cheapest explanation that single changes reach: another kind of a motor, or a swap.

    At most `most` is claimed on the way. Those that claim least are fitted first. One that claims too much for what it
    could explain is left out.
    """
    while True:
        loose = wiring.fit(replace(one, kinds=(ANYTHING,) * wiring.k))
        # What is no noise at all does not count as noise.
        found = Found(one, float(np.clip(min(loose.total, one.total) / wiring.freedom, 1.0, UNEXPLAINED)))
        wanting = one.total - loose.total > CLEAR * found.variance or not wiring.explains(one)
        best, allowed = one, most if wanting else one.claims
        for candidate in sorted(wiring.changes(one), key=attrgetter("claims")):
            least = wiring.freedom + CLEAR * candidate.claims
            if candidate.claims <= allowed and (candidate.claims <= best.claims or least < found.cost(best)):
                best = min([best, wiring.fit(candidate)], key=found.cost)
        if found.cost(best) > found.cost(one) - 1e-6:
            return found
        one = best
