"""Explanations of a wiring log: calibration whose starts are signs, ratios, zeros and swaps of motors, or the base."""

from __future__ import annotations

from collections.abc import Iterable
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
from ..theory.screws import exp
from .geometry import BASE, Geometry
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


@dataclass(frozen=True, eq=False)
class Explanation:
    """A kind for each motor, perhaps two that are swapped, perhaps a base that stands elsewhere; and their fit.

    The fit is the unknowns q (Q,) and the sum of squares. Before it, q is where the fit starts.
    """

    kinds: tuple[str, ...]
    swap: tuple[int, ...]
    elsewhere: bool
    q: Array
    total: float = np.inf

    @property
    def claims(self) -> float:
        """How much is claimed of the motors: two swapped ones are one claim."""
        return sum(KINDS[kind].claims for kind in self.kinds) + len(self.swap) / 2

    @property
    def zeros(self) -> Array:
        """What is added to the motors' readings (k,) [rad, m]."""
        return self.q[-2 * len(self.kinds) : -len(self.kinds)]

    @property
    def scales(self) -> Array:
        """What the motors' readings are multiplied by (k,)."""
        return np.asarray(1.0 + self.q[-len(self.kinds) :])

    def with_kind(self, i: int, kind: str) -> Explanation:
        """The same with another kind for motor i."""
        return replace(self, kinds=(*self.kinds[:i], kind, *self.kinds[i + 1 :]))


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
        prior = np.zeros(len(geometry.parameters))
        prior[BASE] = [1.0 / std if std else 0.0 for std in np.repeat(self.elsewhere, 3)]
        surplus = (np.eye(k) - motors.G @ P) / self.unit[:, None] / SLACK if k > self.arm.n else None
        problems = {}
        for swap in ((), *combinations(range(k), 2)):
            order = np.arange(k)
            order[list(swap)] = swap[::-1]
            readings = motors.from_counts(self.log.theta[:, order]) - motors.offset
            log = replace(self.log, theta=readings)
            problems[swap] = Problem(geometry, log, self.noise, prior, contradiction=surplus)
        return problems

    def sound(self, *, elsewhere: bool = False) -> Explanation:
        """What the arm.toml says."""
        unknowns = np.zeros(self.problems[()].P)
        return self.fit(Explanation((SOUND,) * self.k, (), elsewhere, unknowns))

    @property
    def freedom(self) -> int:
        """Numbers beyond the parameters of all motors, at least 1."""
        return max(self.problems[()].numbers - 2 * self.k, 1)

    def explains(self, one: Explanation) -> bool:
        """Whether what is left is no more than noise."""
        return one.total <= UNEXPLAINED * self.freedom

    def free(self, one: Explanation) -> Bools:
        """The unknowns (Q,) that an explanation fits."""
        kinds = [KINDS[kind] for kind in one.kinds]
        base = np.repeat(np.array(self.elsewhere if one.elsewhere else self.base) > 0.0, 3)
        return np.r_[base, np.zeros(6, dtype=bool), [kind.zero for kind in kinds], [kind.scale for kind in kinds]]

    def fit(self, start: Explanation) -> Explanation:
        """The explanation, fitted from its unknowns."""
        one = replace(start, q=start.q * self.free(start))
        one.q[BASE] = 0.0  # a wrong explanation drags the base far away, and from there the right one is not found
        signs = [0.0 if KINDS[kind].scale else KINDS[kind].sign - 1.0 for kind in one.kinds]
        one.q[-self.k :] += signs
        problem = self.problems[one.swap]
        q, weights = descend(problem, one.q, self.free(one), robust=False)
        r = problem.residual(q, weights)
        return replace(one, q=q, total=float(r @ r))

    def squares(self, swap: tuple[int, ...], starts: Array, rows: int = FEW_ROWS) -> Array:
        """The sums of squares (M,) of unknowns (M, Q) with the same base, over some rows."""
        problem, k, P = self.problems[swap], self.k, self.motors.P
        at = np.unique(np.linspace(0, len(problem.log.theta) - 1, rows).astype(int))
        driven = problem.log.theta[at] * (1.0 + starts[:, None, -k:]) + starts[:, None, -2 * k : -k]
        g = exp(starts[0, BASE]) @ self.arm.fk(driven @ P.T)
        parts = [(g[..., :3, 3] - problem.log.position[at]) / problem.sigma[at, None]]
        if problem.measured[0, 3]:
            parts.append(log_of(np.swapaxes(problem.log.rotation[at], 1, 2) @ g[..., :3, :3]) / self.noise[1])
        if problem.contradiction is not None:
            parts.append(driven @ problem.contradiction.T)
        return np.asarray(sum((part * part).sum(axis=(1, 2)) for part in parts))

    def with_kinds(self, one: Explanation, i: int, kinds: Iterable[str]) -> list[Explanation]:
        """Each of these kinds for motor i, from the best of its `STARTS`. The result is not fitted yet."""
        starts, k = np.tile(one.q, (len(STARTS), 1)), self.k
        starts[:, BASE] = 0.0
        starts[:, i - k], starts[:, i - 2 * k] = STARTS[:, 0] - 1.0, STARTS[:, 1] * self.unit[i]
        totals = self.squares(one.swap, starts)
        candidates = []
        for name in kinds:
            kind, q = KINDS[name], one.q
            if kind.scale or kind.zero:
                allowed = (kind.scale | (STARTS[:, 0] == kind.sign)) & (kind.zero | (STARTS[:, 1] == 0.0))
                q = starts[np.where(allowed, totals, np.inf).argmin()]
            candidates.append(replace(one.with_kind(i, name), q=q))
        return candidates

    def with_swaps(self, one: Explanation) -> list[Explanation]:
        """Each two motors exchanged, or the exchanged ones put right. The result is not fitted yet."""
        return [replace(one, swap=swap) for swap in ([()] if one.swap else combinations(range(self.k), 2))]

    def with_other_motors(self, one: Explanation) -> list[Explanation]:
        """Less said of one faulty motor, and as much more of another. The result is not fitted yet."""
        claims, candidates = {name: kind.claims for name, kind in KINDS.items()}, list[Explanation]()
        for i, kind in enumerate(one.kinds):
            for less in (name for name in KINDS if claims[name] < claims[kind]):
                relieved = self.fit(one.with_kind(i, less))
                for j in (j for j in range(self.k) if j != i):
                    least, most = claims[one.kinds[j]], claims[one.kinds[j]] + claims[kind] - claims[less]
                    more = [name for name in KINDS if least < claims[name] <= most]
                    candidates += self.with_kinds(relieved, j, more)
        return candidates


class Found(NamedTuple):
    """The explanation with the fewest claims, others that were fitted, and the variance of what is left, at least 1.

    A rival claims no more of the motors than the best and fits as well, or has the base elsewhere.
    """

    best: Explanation
    others: list[Explanation]
    variance: float
    rivals: tuple[Explanation, ...] = ()

    def cost(self, one: Explanation) -> float:
        """What is to be least: −2 ln of the likelihood, and the price of each claim."""
        return one.total / self.variance + CLEAR * one.claims

    def as_good(self, one: Explanation) -> bool:
        """Whether an explanation fits as well."""
        return one.total < self.best.total + AS_GOOD * self.variance


def explained(wiring: Wiring) -> Found:
    """The likelier explanation: with the base as given, or with one that stands elsewhere; and its rivals.

    Costs of these two are −2 ln of the marginal likelihood, with ln det of the base's random effect (Laird, Ware 1982).
    A claim of the base costs as much as one of a motor.
    """
    movable = wiring.base != wiring.elsewhere
    # A base that explains the log leaves only one motor to compare it with.
    alone = movable and wiring.explains(wiring.sound(elsewhere=True))
    found = _search(wiring, False, KINDS[ANYTHING].claims if alone else MOST_CLAIMS)
    known, elsewhere = wiring.explains(found.best), list[Explanation]()
    if movable and not (known and not found.best.claims):
        near = [wiring.sound(elsewhere=True), wiring.fit(replace(found.best, elsewhere=True))]
        other = _climbed(wiring, min(near, key=found.cost)) if known else _search(wiring, True)
        if wiring.explains(other.best):
            problem, weights = wiring.problems[other.best.swap], np.ones(len(wiring.log.theta))
            A = problem.slopes(other.best.q, weights, prior=False)[:, BASE] * np.repeat(wiring.elsewhere, 3)
            price = float(np.linalg.slogdet(np.eye(6) + A.T @ A)[1]) + CLEAR
            if not known or other.cost(other.best) + price < other.cost(found.best):
                found = other
            else:
                elsewhere = [other.best]
    as_good = (rival for rival in found.others if rival.claims <= found.best.claims and found.as_good(rival))
    return found._replace(rivals=(*as_good, *elsewhere))


def _search(wiring: Wiring, elsewhere: bool, most: float = MOST_CLAIMS) -> Found:
    """The explanation with the fewest faults: from the sound arm, else from the likeliest pattern of signs.

    At most `most` is claimed on the way, beside these signs.
    """
    sound = wiring.sound(elsewhere=elsewhere)
    found = _climbed(wiring, sound, most)
    if wiring.explains(found.best) or most < MOST_CLAIMS:
        return found
    patterns = sign_patterns(wiring.k)
    starts = np.zeros((len(patterns), len(sound.q)))
    starts[:, -wiring.k :] = patterns - 1.0
    likeliest = patterns[wiring.squares((), starts).argmin()]
    signs = wiring.fit(replace(sound, kinds=tuple("reversed" if sign < 0 else SOUND for sign in likeliest)))
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
        loose = wiring.fit(replace(one, kinds=(ANYTHING,) * wiring.k))
        found = _found(wiring, one, [], loose)
        wanting = one.total - loose.total > CLEAR * found.variance or not wiring.explains(one)
        # Whether a log shows a swap matters even where none is claimed.
        others = [] if wanting else list(map(wiring.fit, wiring.with_swaps(one)))
        candidates = wiring.with_swaps(one) if wanting else wiring.with_other_motors(one)
        for i, kind in enumerate(one.kinds):
            candidates += wiring.with_kinds(one, i, [name for name in KINDS if name != kind])
        best, allowed = one, most if wanting else one.claims
        for candidate in sorted(candidates, key=attrgetter("claims")):
            least = wiring.freedom + CLEAR * candidate.claims
            if candidate.claims <= allowed and (candidate.claims <= best.claims or least < found.cost(best)):
                others.append(wiring.fit(candidate))
                best = min([best, others[-1]], key=found.cost)
        found = _found(wiring, one, others, loose)
        best = min([one, *others], key=found.cost)
        if found.cost(best) > found.cost(one) - 1e-6:
            return found
        one = best


def _found(wiring: Wiring, best: Explanation, others: list[Explanation], loose: Explanation) -> Found:
    """With the variance of the best fit's residual, at least 1. What is no noise at all does not count as noise."""
    total = min(one.total for one in (loose, best, *others))
    return Found(best, others, float(np.clip(total / wiring.freedom, 1.0, UNEXPLAINED)))
