"""Explanations of a wiring log: calibration whose starts are signs, ratios, zeros and swaps of motors, or the base."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..limits.actuators import Actuators
from ..support.checks import Array
from ..theory.rotations import log_of
from ..theory.screws import exp
from .geometry import Geometry
from .measurements import Bools, Measurements
from .problem import Problem, descend


class Kind(NamedTuple):
    """A claim about a motor: its sign (0: any), whether scale and zero are fitted, and how many claims that is."""

    sign: float
    scale: bool
    zero: bool
    claims: float


SOUND = "sound"
KINDS = {
    SOUND: Kind(1.0, False, False, 0.0),
    "reversed": Kind(-1.0, False, False, 1.0),
    "zero": Kind(1.0, False, True, 1.5),
    "ratio": Kind(0.0, True, False, 1.5),
    "reversed, zero": Kind(-1.0, False, True, 2.5),
    "ratio, zero": Kind(0.0, True, True, 3.0),
}
ANYTHING = "ratio, zero"

# A claim must lower the sum of squares by five standard deviations; explanations within three are equally good.
CLEAR, AS_GOOD = 25.0, 9.0
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
# Explanations that may be fitted, after what they claim.
Candidates = Iterator[tuple[float, Callable[[], "Explanation"]]]


@dataclass(frozen=True, eq=False)
class Explanation:
    """A kind for each motor, perhaps two that are swapped, perhaps a base that stands elsewhere; and their fit.

    The fit is the unknowns q (Q,) and the sum of squares.
    """

    kinds: tuple[str, ...]
    swap: tuple[int, ...]
    elsewhere: bool
    q: Array
    total: float

    @property
    def claims(self) -> float:
        """How much is claimed of the motors: two swapped ones are one claim."""
        return sum(KINDS[kind].claims for kind in self.kinds) + len(self.swap) / 2

    def with_kind(self, i: int, kind: str) -> tuple[str, ...]:
        """The kinds with another one for motor i."""
        return (*self.kinds[:i], kind, *self.kinds[i + 1 :])


@dataclass(frozen=True, eq=False)
class Wiring:
    """A log of counts (K, k) as a problem of calibration.

    The unknowns are the base, the tool (held), the motors' zeros e [rad, m] and scales s − 1. Sound motors have s = 1,
    e = 0, and a reversed one s = −1. `base` is the standard deviation [m, rad] of the base's pose in every explanation,
    0 where it is held, and `elsewhere` that of a base that stands elsewhere.
    """

    arm: Arm
    motors: Actuators
    log: Measurements
    noise: tuple[float, float]
    base: tuple[float, float]
    elsewhere: tuple[float, float]

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
        base = [1.0 / std if std else 0.0 for std in np.repeat(self.elsewhere, 3)]
        usual = np.array([*base, *[0.0] * (6 + 2 * k)])
        surplus = (np.eye(k) - motors.G @ P) / self.unit[:, None] / SLACK if k > self.arm.n else None
        problems = {}
        for swap in ((), *combinations(range(k), 2)):
            order = np.arange(k)
            order[list(swap)] = swap[::-1]
            readings = motors.from_counts(self.log.theta[:, order]) - motors.offset
            log = replace(self.log, theta=readings)
            problems[swap] = Problem(geometry, log, self.noise, usual, contradiction=surplus)
        return problems

    def sound(self, *, elsewhere: bool = False) -> Explanation:
        """What the arm.toml says."""
        return self.fit(Explanation((SOUND,) * self.k, (), elsewhere, np.zeros(12 + 2 * self.k), np.inf))

    @property
    def freedom(self) -> int:
        """Numbers beyond the parameters of all motors, at least 1."""
        return max(self.problems[()].numbers - 2 * self.k, 1)

    def scale(self, total: float) -> float:
        """The variance of the best fit's residual, at least 1. What is no noise at all does not count as noise."""
        return float(np.clip(total / self.freedom, 1.0, UNEXPLAINED))

    def explains(self, one: Explanation) -> bool:
        """Whether what is left is no more than noise."""
        return one.total <= UNEXPLAINED * self.freedom

    def free(self, one: Explanation) -> Bools:
        """The unknowns (Q,) that an explanation fits."""
        fitted = [KINDS[kind] for kind in one.kinds]
        base = np.repeat(np.array(self.elsewhere if one.elsewhere else self.base) > 0.0, 3)
        return np.r_[base, np.zeros(6, dtype=bool), [kind.zero for kind in fitted], [kind.scale for kind in fitted]]

    def fit(self, near: Explanation, **changes: Any) -> Explanation:
        """The explanation with these changes, fitted from the unknowns near it."""
        one = replace(near, **changes)
        q, free = one.q.copy(), self.free(one)
        q[:6] = 0.0  # a wrong explanation drags the base far away, and from there the right one is not found
        q[12:] *= free[12:]
        for i, kind in enumerate(one.kinds):
            q[12 + self.k + i] += 0.0 if KINDS[kind].scale else KINDS[kind].sign - 1.0
        problem = self.problems[one.swap]
        q, ones = descend(problem, q, free, robust=False)
        r = problem.residual(q, ones)
        return replace(one, q=q, total=float(r @ r))

    def squares(self, swap: tuple[int, ...], starts: Array, rows: int = FEW_ROWS) -> Array:
        """The sums of squares (M,) of unknowns (M, Q) with the same base, over some rows."""
        problem, k, P = self.problems[swap], self.k, self.motors.P
        at = np.unique(np.linspace(0, len(problem.log.theta) - 1, rows).astype(int))
        driven = problem.log.theta[at] * (1.0 + starts[:, None, 12 + k :]) + starts[:, None, 12 : 12 + k]
        g = exp(starts[0, :6]) @ self.arm.fk(driven @ P.T)
        parts = [(g[..., :3, 3] - problem.log.position[at]) / problem.sigma[at, None]]
        if problem.measured[0, 3]:
            parts.append(log_of(np.swapaxes(problem.log.rotation[at], 1, 2) @ g[..., :3, :3]) / self.noise[1])
        if problem.contradiction is not None:
            parts.append(driven @ problem.contradiction.T)
        return np.asarray(sum((part * part).sum(axis=(1, 2)) for part in parts))

    def with_kinds(self, one: Explanation, i: int, kinds: Sequence[str]) -> Candidates:
        """Each of these kinds for motor i, fitted from the best of its `STARTS`."""
        starts = np.tile(one.q, (len(STARTS), 1))
        starts[:, :6] = 0.0
        starts[:, 12 + self.k + i], starts[:, 12 + i] = STARTS[:, 0] - 1.0, STARTS[:, 1] * self.unit[i]
        totals = self.squares(one.swap, starts)
        for kind in kinds:
            sign, scale, zero, claims = KINDS[kind]
            allowed = (scale | (STARTS[:, 0] == sign)) & (zero | (STARTS[:, 1] == 0.0))
            near = starts[np.where(allowed, totals, np.inf).argmin()] if scale or zero else one.q
            more = claims - KINDS[one.kinds[i]].claims
            yield one.claims + more, partial(self.fit, one, kinds=one.with_kind(i, kind), q=near)

    def with_swaps(self, one: Explanation) -> Candidates:
        """Each two motors exchanged, or the exchanged ones put right."""
        for swap in [()] if one.swap else combinations(range(self.k), 2):
            yield one.claims - len(one.swap) / 2 + len(swap) / 2, partial(self.fit, one, swap=swap)

    def with_other_motors(self, one: Explanation) -> Candidates:
        """Less said of one faulty motor, and as much more of another."""
        for i, kind in enumerate(one.kinds):
            for less in (name for name in KINDS if KINDS[name].claims < KINDS[kind].claims):
                relieved = self.fit(one, kinds=one.with_kind(i, less))
                for j in (j for j in range(self.k) if j != i):
                    most = KINDS[one.kinds[j]].claims + KINDS[kind].claims - KINDS[less].claims
                    more = [name for name in KINDS if KINDS[one.kinds[j]].claims < KINDS[name].claims <= most]
                    yield from self.with_kinds(relieved, j, more)


class Found(NamedTuple):
    """The explanation with the fewest claims, others that were fitted, and the variance of what is left, at least 1."""

    best: Explanation
    others: tuple[Explanation, ...]
    scale: float

    def cost(self, one: Explanation) -> float:
        """What is to be least: −2 ln of the likelihood, and the price of each claim."""
        return one.total / self.scale + CLEAR * one.claims

    def as_good(self, one: Explanation) -> bool:
        """Whether an explanation fits as well."""
        return one.total < self.best.total + AS_GOOD * self.scale


def explained(wiring: Wiring) -> tuple[Found, list[Explanation]]:
    """The likelier explanation: with the base as given, or with one that stands elsewhere; and its rivals.

    A rival claims no more of the motors and fits as well, or has the base elsewhere. Costs of these two are −2 ln of
    the marginal likelihood, with ln det of the base's random effect (Laird, Ware 1982). A claim of the base costs as
    much as one of a motor.
    """
    movable = wiring.base != wiring.elsewhere
    # A base that explains the log leaves only one motor to compare it with.
    alone = movable and wiring.explains(wiring.sound(elsewhere=True))
    found = _search(wiring, False, KINDS[ANYTHING].claims if alone else MOST_CLAIMS)
    known = wiring.explains(found.best)
    rivals = []
    if movable and not (known and not found.best.claims):
        near = [wiring.sound(elsewhere=True), wiring.fit(found.best, elsewhere=True)]
        other = _climbed(wiring, min(near, key=found.cost)) if known else _search(wiring, True)
        if wiring.explains(other.best):
            A = wiring.problems[other.best.swap].slopes(other.best.q, np.ones(len(wiring.log.theta)))[:, :6]
            A = A[: -len(wiring.problems[()].usual)] * np.repeat(wiring.elsewhere, 3)
            price = float(np.linalg.slogdet(np.eye(6) + A.T @ A)[1]) + CLEAR
            if not known or other.cost(other.best) + price < other.cost(found.best):
                found = other
            else:
                rivals = [other.best]
    as_good = [rival for rival in found.others if rival.claims <= found.best.claims and found.as_good(rival)]
    return found, [*as_good, *rivals]


def _search(wiring: Wiring, elsewhere: bool, most: float = MOST_CLAIMS) -> Found:
    """The explanation with the fewest faults: from the sound arm, else from the likeliest pattern of signs.

    At most `most` is claimed on the way, beside these signs.
    """
    sound = wiring.sound(elsewhere=elsewhere)
    found = _climbed(wiring, sound, most)
    if wiring.explains(found.best) or most < MOST_CLAIMS:
        return found
    flips = sign_patterns(wiring.k)
    q = np.zeros((len(flips), len(sound.q)))
    q[:, 12 + wiring.k :] = flips - 1.0
    likely = flips[wiring.squares((), q).argmin()]
    signs = wiring.fit(sound, kinds=tuple("reversed" if sign < 0 else SOUND for sign in likely))
    other = _climbed(wiring, signs, most + signs.claims)
    return other if wiring.explains(other.best) else found


def sign_patterns(k: int) -> Array:
    """Patterns (M, k) of reversed motors, −1, fewest first. With many motors at most two are reversed."""
    counts = range(1, k + 1 if k <= MOST_SIGNS else 3)
    flips = [pair for count in counts for pair in combinations(range(k), count)]
    return np.array([[-1.0 if i in pair else 1.0 for i in range(k)] for pair in flips])


def _climbed(wiring: Wiring, one: Explanation, most: float = MOST_CLAIMS) -> Found:
    """The cheapest explanation that single changes reach: another kind of a motor, a swap, another motor to blame.

    Those that claim least are fitted first. One that claims too much for what it could explain is left out.
    """
    while True:
        loose = wiring.fit(one, kinds=(ANYTHING,) * wiring.k)
        found = Found(one, (), wiring.scale(min(loose.total, one.total)))
        wanting = one.total - loose.total > CLEAR * found.scale or not wiring.explains(one)
        # Whether a log shows a swap matters even where none is claimed.
        others = [] if wanting else [fit() for _, fit in wiring.with_swaps(one)]
        candidates = list(wiring.with_swaps(one) if wanting else wiring.with_other_motors(one))
        for i, kind in enumerate(one.kinds):
            candidates += wiring.with_kinds(one, i, [name for name in KINDS if name != kind])
        best, allowed = one, most if wanting else one.claims
        for claims, fit in sorted(candidates, key=lambda each: each[0]):
            least = wiring.freedom + CLEAR * claims
            if claims <= allowed and (claims <= best.claims or least < found.cost(best)):
                others.append(fit())
                best = min([best, others[-1]], key=found.cost)
        found = Found(one, tuple(others), wiring.scale(min(hypothesis.total for hypothesis in (loose, one, *others))))
        best = min([one, *others], key=found.cost)
        if found.cost(best) > found.cost(one) - 1e-6:
            return found
        one = best
