"""`check_wiring`: calibration whose starts are signs, ratios, zeros and swaps of motors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from itertools import combinations
from typing import NamedTuple

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
    """What is said of a motor: its sign (0: any), whether scale and zero are fitted, and how many claims that is."""

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

CLEAR, AS_GOOD = 25.0, 9.0
"""A claim must lower the sum of squares by five standard deviations; accounts within three are equally good."""

UNEXPLAINED = 9.0
"""A greater mean square residual [standard deviations²] is not noise."""

SCALES = (1.0, 0.1, 0.25, 0.5, 0.75, 1.5, 2.0, 4.0, 10.0)
OFFSETS = np.radians([0.0, 30.0, -30.0, 75.0, -75.0, 120.0, -120.0, 180.0])
STARTS = np.array([(sign * s, e) for s in SCALES for sign in (1.0, -1.0) for e in OFFSETS])
"""Where the fit of one motor may start: its scale, and what its zero adds to the joint [rad, m]."""

MOST_CLAIMS = 6.0
"""More is not claimed by and by: two motors of which anything is wrong, or six reversed ones."""

MOST_SIGNS, PATTERNS = 8, 4
"""Motors up to which every pattern of signs is tried, and how many patterns are followed."""

MOST_ROWS, FEW_ROWS = 200, 30
"""Moments of a fit and of a search for starts: neighbouring moments of a camera have the same errors."""

SLACK = float(np.radians(1.0))
"""Allowed contradiction of motors that share a joint [joint rad]: backlash and belts."""

USUAL_BASE = (0.01, float(np.radians(2.0)))
"""One standard deviation [m, rad] of a base measured by tape, for logs that need it."""

Swap = tuple[int, ...]
Candidates = Iterator[tuple[float, Callable[[], "Account"]]]
"""Accounts that may be fitted, after what they claim."""


@dataclass(frozen=True, eq=False)
class Account:
    """A kind for each motor, perhaps two that are swapped, and the fit: unknowns q (Q,) and the sum of squares."""

    kinds: tuple[str, ...]
    swap: Swap
    q: Array
    total: float

    @property
    def claims(self) -> float:
        """How much is claimed: two swapped motors are one claim."""
        return sum(KINDS[kind].claims for kind in self.kinds) + len(self.swap) / 2

    def with_kind(self, i: int, kind: str) -> tuple[str, ...]:
        """The kinds with another one for motor i."""
        return (*self.kinds[:i], kind, *self.kinds[i + 1 :])


@dataclass(frozen=True, eq=False)
class Wiring:
    """A log of counts (K, k) as a problem of calibration. `base` is the standard deviation of the base's pose [m, rad].

    The unknowns are the base, the tool (held), the motors' zeros e [rad, m] and scales s − 1. Sound motors have s = 1,
    e = 0, and a reversed one s = −1.
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
    def problems(self) -> dict[Swap, Problem]:
        """The problem as the log is, and with the counts of each two motors exchanged."""
        motors, k, P = self.motors, self.k, self.motors.P
        geometry = Geometry(self.arm, np.eye(4), np.eye(4), scales=True, axes=False, drive=P)
        base = [1.0 / std if std else 0.0 for std in np.repeat(self.base, 3)]
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

    @property
    def sound(self) -> Account:
        """What the arm.toml says."""
        return self.fit((SOUND,) * self.k, (), np.zeros(12 + 2 * self.k))

    @property
    def freedom(self) -> int:
        """Numbers beyond the parameters of all motors, at least 1."""
        return max(self.problems[()].numbers - 2 * self.k, 1)

    def scale(self, total: float) -> float:
        """The variance of the best fit's residual, at least 1. What is no noise at all does not count as noise."""
        return float(np.clip(total / self.freedom, 1.0, UNEXPLAINED))

    def explains(self, account: Account) -> bool:
        """Whether what is left is no more than noise."""
        return account.total <= UNEXPLAINED * self.freedom

    def free(self, kinds: Sequence[str]) -> Bools:
        """The unknowns (Q,) that these kinds fit."""
        fitted = [KINDS[kind] for kind in kinds]
        base = np.repeat(np.array(self.base) > 0.0, 3)
        return np.r_[base, np.zeros(6, dtype=bool), [each.zero for each in fitted], [each.scale for each in fitted]]

    def fit(self, kinds: tuple[str, ...], swap: Swap, near: Array) -> Account:
        """The account by these kinds, fitted from the unknowns (Q,) near it."""
        q, free = near.copy(), self.free(kinds)
        q[:6] = 0.0  # a wrong account drags the base far away, and from there the right one is not found
        q[12:] *= free[12:]
        for i, kind in enumerate(kinds):
            q[12 + self.k + i] += 0.0 if KINDS[kind].scale else KINDS[kind].sign - 1.0
        problem, ones = self.problems[swap], np.ones(len(self.log.theta))
        q, _ = descend(problem, q, free, robust=False)
        r = problem.residual(q, ones)
        return Account(kinds, swap, q, float(r @ r))

    def squares(self, swap: Swap, starts: Array, rows: int = FEW_ROWS) -> Array:
        """The sums of squares (M,) of unknowns (M, Q) with the same base, over some rows."""
        problem, k, P = self.problems[swap], self.k, self.motors.P
        at = np.unique(np.linspace(0, len(problem.log.theta) - 1, rows).astype(int))
        driven = problem.log.theta[at] * (1.0 + starts[:, None, 12 + k :]) + starts[:, None, 12 : 12 + k]
        g = exp(starts[0, :6]) @ self.arm.fk(driven @ P.T)
        off = (g[..., :3, 3] - problem.log.position[at]) / problem.sigma[at, None]
        total = (off * off).sum(axis=(1, 2))
        if problem.measured[0, 3]:
            turned = log_of(np.swapaxes(problem.log.rotation[at], 1, 2) @ g[..., :3, :3]) / self.noise[1]
            total += (turned * turned).sum(axis=(1, 2))
        if problem.contradiction is not None:
            contradiction = driven @ problem.contradiction.T
            total += (contradiction * contradiction).sum(axis=(1, 2))
        return np.asarray(total)

    def starts(self, account: Account, i: int) -> tuple[Array, Array]:
        """The unknowns (M, Q) of the account with each of `STARTS` for motor i, and their sums of squares (M,)."""
        starts = np.tile(account.q, (len(STARTS), 1))
        starts[:, :6] = 0.0
        starts[:, 12 + self.k + i], starts[:, 12 + i] = STARTS[:, 0] - 1.0, STARTS[:, 1] * self.unit[i]
        return starts, self.squares(account.swap, starts)

    def changed(self, account: Account, i: int, kind: str, starts: tuple[Array, Array] | None) -> Account:
        """The account with another kind for motor i, fitted from the best of its starts."""
        near = account.q
        sign, scale, zero, _ = KINDS[kind]
        if starts is not None and (scale or zero):
            allowed = (scale | (STARTS[:, 0] == sign)) & (zero | (STARTS[:, 1] == 0.0))
            near = starts[0][np.where(allowed, starts[1], np.inf).argmin()]
        return self.fit(account.with_kind(i, kind), account.swap, near)

    def with_kinds(self, account: Account, i: int, kinds: Sequence[str]) -> Candidates:
        """The account with each of these kinds for motor i."""
        starts = cache(lambda: self.starts(account, i))
        for kind in kinds:
            claims = account.claims - KINDS[account.kinds[i]].claims + KINDS[kind].claims
            yield claims, lambda kind=kind: self.changed(account, i, kind, starts())  # type: ignore[misc]

    def with_swaps(self, account: Account) -> Candidates:
        """The account with each two motors exchanged, or with the exchanged ones put right."""
        for swap in [()] if account.swap else combinations(range(self.k), 2):
            claims = account.claims - len(account.swap) / 2 + len(swap) / 2
            yield claims, partial(self.fit, account.kinds, swap, account.q)

    def with_other_motors(self, account: Account) -> Candidates:
        """The account with less said of one faulty motor, and as much more of another."""
        for i, kind in enumerate(account.kinds):
            for less in (name for name in KINDS if KINDS[name].claims < KINDS[kind].claims):
                relieved = self.fit(account.with_kind(i, less), account.swap, account.q)
                for j in (j for j in range(self.k) if j != i):
                    most = KINDS[account.kinds[j]].claims + KINDS[kind].claims - KINDS[less].claims
                    more = [name for name in KINDS if KINDS[account.kinds[j]].claims < KINDS[name].claims <= most]
                    yield from self.with_kinds(relieved, j, more)


class Found(NamedTuple):
    """The account with the fewest claims, others that are as good, and the variance of what is left, at least 1."""

    wiring: Wiring
    account: Account
    others: tuple[Account, ...]
    scale: float

    @property
    def explained(self) -> bool:
        """Whether what is left is no more than noise."""
        return self.wiring.explains(self.account)

    def cost(self, account: Account) -> float:
        """What is to be least: −2 ln of the likelihood, and the price of each claim."""
        return account.total / self.scale + CLEAR * account.claims

    def as_good(self, account: Account) -> bool:
        """Whether an account fits as well."""
        return account.total < self.account.total + AS_GOOD * self.scale


def search(wiring: Wiring, most: float = MOST_CLAIMS) -> Found:
    """The account with the fewest faults: from the sound arm, else from a free fit of all motors.

    At most `most` is claimed on the way from the sound arm.
    """
    found = climbed(wiring, wiring.sound, most)
    if found.explained or most < MOST_CLAIMS:
        return found
    free = min((wiring.fit((ANYTHING,) * wiring.k, (), q) for q in _patterns(wiring)), key=lambda one: one.total)
    if not wiring.explains(free):
        return found
    scale = wiring.scale(free.total)
    for i in range(wiring.k):
        simpler = [wiring.fit(free.with_kind(i, kind), (), free.q) for kind in KINDS]
        free = min(simpler, key=Found(wiring, free, (), scale).cost)
    return climbed(wiring, free, most)


def _patterns(wiring: Wiring) -> list[Array]:
    """The unknowns (Q,) of sound motors, and of the most promising patterns of reversed ones."""
    flips = sign_patterns(wiring.k)
    q = np.zeros((len(flips), 12 + 2 * wiring.k))
    q[:, 12 + wiring.k :] = flips - 1.0
    best = np.argsort(wiring.squares((), q), kind="stable")[:PATTERNS]
    return [wiring.sound.q, *q[best]]


def sign_patterns(k: int) -> Array:
    """Patterns (M, k) of reversed motors, −1, fewest first. With many motors at most two are reversed."""
    counts = range(1, k + 1 if k <= MOST_SIGNS else 3)
    flips = [pair for count in counts for pair in combinations(range(k), count)]
    return np.array([[-1.0 if i in pair else 1.0 for i in range(k)] for pair in flips])


def climbed(wiring: Wiring, account: Account, most: float = MOST_CLAIMS) -> Found:
    """The cheapest account that single changes reach: another kind of a motor, a swap, another motor to blame.

    Those that claim least are fitted first. One that claims too much for what it could explain is left out.
    """
    while True:
        loose = wiring.fit((ANYTHING,) * wiring.k, account.swap, account.q)
        found = Found(wiring, account, (), wiring.scale(min(loose.total, account.total)))
        wanting = account.total - loose.total > CLEAR * found.scale or not found.explained
        # Whether a log shows a swap matters even where none is claimed.
        others = [] if wanting else [fit() for _, fit in wiring.with_swaps(account)]
        candidates = list(wiring.with_swaps(account) if wanting else wiring.with_other_motors(account))
        for i, kind in enumerate(account.kinds):
            candidates += wiring.with_kinds(account, i, [name for name in KINDS if name != kind])
        best, allowed = account, most if wanting else account.claims
        for claims, fit in sorted(candidates, key=lambda one: one[0]):
            least = wiring.freedom + CLEAR * claims
            if claims <= allowed and (claims <= best.claims or least < found.cost(best)):
                others.append(fit())
                best = min([best, others[-1]], key=found.cost)
        found = Found(wiring, account, tuple(others), wiring.scale(min(one.total for one in (loose, account, *others))))
        best = min([account, *others], key=found.cost)
        if found.cost(best) > found.cost(account) - 1e-6:
            return found
        account = best
