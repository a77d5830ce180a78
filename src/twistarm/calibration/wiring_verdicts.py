"""`check_wiring`: from a log to a verdict on every motor, with what to correct or to log."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array, as_not_negative, as_positive, as_theta
from ..support.display import told
from ..support.errors import ComparisonError, InputError, listed
from ..theory.screws import exp, inverse_of
from .log_checks import LITTLE_ANGLE, LITTLE_LENGTH, require_metres
from .measurements import Measurements, read_measurements, require_motors
from .problem import LOUD
from .wiring import (
    ANYTHING,
    CLEAR,
    KINDS,
    MOST_CLAIMS,
    MOST_ROWS,
    USUAL_BASE,
    Account,
    Found,
    Wiring,
    climbed,
    search,
    sign_patterns,
)

SMALL_SCALE, SMALL_ANGLE, SMALL_LENGTH = 0.02, float(np.radians(1.0)), 0.005
"""Normal errors of a scale or offset [joint rad, m]. They are no faults, even if the log shows them."""

SEEN_SCALE, SEEN_ANGLE, SEEN_LENGTH = 0.05, float(np.radians(2.0)), 0.01
"""Greatest standard deviations of a visible scale or offset [joint rad, m]."""

ONE_MOTOR = KINDS[ANYTHING].claims

ROUNDING = 1e-6
"""A smaller share of a motor's largest ratio, or of a direction that no log shows, is rounding."""

BASE_KNOWN = (
    "measure the base anew, by the tool in several configurations; --base-position-noise (metres) and "
    "--base-orientation-noise (degrees) say how well it is known, 0 and 0 exactly"
)


class Residual(NamedTuple):
    """Root mean square of measured against computed: position [m], rotation [rad] or None."""

    position: float
    rotation: float | None


@dataclass(frozen=True)
class MotorVerdict:
    """The log's verdict on one motor; by default none.

    `verdict` is "sound", "fault", "possible fault" or "cannot tell". `faults` are from "flipped sign", "wrong ratio",
    "zero offset" and "swapped". A fault is possible if the log does not separate it from another, or from a base that
    stands elsewhere. `unseen` is what the log does not show: "sign", "ratio", "zero" or "swapped with NAME".

    The fit reads the motor as `scale` y + `offset` [rad or m, motor side]. Their standard deviations hold when all
    parameters are fitted; inf if the log shows nothing. `joint_offset` is the offset of the joints [rad or m]. `ratio`
    and `zero` are the right entries of arm.toml for the present wiring. None: the log does not tell. `what` and
    `remedy` say it in words.
    """

    name: str
    verdict: str = "cannot tell"
    faults: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ("sign", "ratio", "zero")
    scale: float = 1.0
    scale_std: float = inf
    offset: float = 0.0
    offset_std: float = inf
    joint_offset: Mapping[str, float] = field(default_factory=dict)
    ratio: Mapping[str, float] | None = None
    zero: float | None = None
    what: str = ""
    remedy: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class WiringReport:
    """The verdict on the whole arm ("sound", "fault", "cannot tell", "unexplained"), and on each motor.

    `before` is the residual with the values of arm.toml, `after` that with the found scales and offsets. `rows` moments
    were logged; `worst_row`, counted from 1, fits least. `base` (4, 4) is where the base seems to stand, seen from its
    measured place, if the log needs that. None: as measured.
    """

    arm: str
    verdict: str
    what: str
    motors: tuple[MotorVerdict, ...]
    rows: int
    before: Residual
    after: Residual
    worst_row: int
    base: Array | None = None

    def __repr__(self) -> str:
        return told("WiringReport", {"arm": self.arm, "verdict": self.verdict, "what": self.what})

    @property
    def ok(self) -> bool:
        """Every motor is sound, and the log says so."""
        return self.verdict == "sound"

    def require(self) -> WiringReport:
        """Itself, or ComparisonError with what was found."""
        if not self.ok:
            faulty = [f"{motor.name}: {motor.what}" for motor in self.motors if motor.verdict != "sound" and motor.what]
            raise ComparisonError(f"the wiring of {self.arm}: {'; '.join([self.what, *faulty])}")
        return self


def check_wiring(
    arm: Arm,
    log: Measurements | str | os.PathLike[str],
    *,
    position_noise: float = 0.002,
    orientation_noise: float = float(np.radians(1.0)),
    base_position_noise: float | None = None,
    base_orientation_noise: float | None = None,
) -> WiringReport:
    """Check the motors' signs, ratios and zeros against a log of counts and measured tool poses.

    The check fits theta = G⁻¹ (s y + e) to the poses. y are the motors' readings from their configured zeros. Faults
    are the fewest deviations from s = 1, e = 0 that explain the log. They are clear from the noise and larger than 1°,
    5 mm or 2 %. If others explain the log as well, all are named and none is corrected.

    The verdict is "cannot tell" if the log does not show a motor's sign, scale, offset, or a swap. It comes with what
    to move or measure. A fault that the base's pose explains as well is "possible": an offset of the first joint looks
    like a turned base. A log that nothing explains takes seconds.

    Args:
        arm: The arm, with actuators.
        log: `Measurements` of positions or poses with the motors' counts, in base coordinates, or the path of a CSV
            file of them (`read_measurements`).
        position_noise: Standard deviation of the measured position [m].
        orientation_noise: Standard deviation of the measured orientation [rad].
        base_position_noise: Standard deviation of the base's position [m]. By default 0; that of a tape measure if
            the log is not sound with 0.
        base_orientation_noise: The same for the base's orientation [rad].

    Returns:
        The `WiringReport`: a verdict on each motor and one on the whole arm.

    Raises:
        InputError: The arm has no actuators, they do not determine its joints, or the log is unusable.
    """
    motors = require_motors(arm)
    noises = (base_position_noise, "base_position_noise"), (base_orientation_noise, "base_orientation_noise")
    given = [None if noise is None else as_not_negative(noise, name) for noise, name in noises]
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    whole = log if isinstance(log, Measurements) else read_measurements(log, arm, counts=True)
    as_theta(whole.theta, len(motors.names), "counts", motors.names)
    if not len(whole.theta) or not whole.located.all():
        raise InputError("the log must hold a measured position x, y, z for each row of counts, one row or more")
    turned = np.isfinite(whole.rotation).all(axis=(1, 2))
    if turned.any() and not turned.all():
        raise InputError("measure the orientation in every row of the log, or in none")
    require_metres(whole, arm)
    rows = np.unique(np.linspace(0, len(whole.theta) - 1, MOST_ROWS).astype(int))
    exact = Wiring(arm, motors, whole.of_rows(rows), noise, (given[0] or 0.0, given[1] or 0.0))
    usual = [most if std is None else std for std, most in zip(given, USUAL_BASE, strict=True)]
    found, or_base = _searched(exact, replace(exact, base=(usual[0], usual[1])))
    evidence = Evidence(found, or_base)
    everything = replace(found.wiring, log=whole)
    q, swap = found.account.q, found.account.swap
    loud = everything.problems[swap].loudness(q)
    worst = int(loud.argmax())
    verdict, what, each = evidence.judged((worst + 1) * bool(loud[worst] > LOUD * max(1.0, float(np.median(loud)))))
    before, after = _residual(everything, (), np.zeros(len(q))), _residual(everything, swap, q)
    base = inverse_of(exp(q[:6])) if q[:6].any() else None
    return WiringReport(arm.name, verdict, what, each, len(whole.theta), before, after, worst + 1, base)


def _searched(exact: Wiring, doubted: Wiring) -> tuple[Found, Found | None]:
    """The likelier account: with the base as given, or with one that may stand elsewhere; and the other one.

    Costs are −2 ln of the marginal likelihood, with ln det of the base's random effect (Laird, Ware 1982). A claim of
    the base costs as much as one of a motor.
    """
    if not any(_moved(exact, i) for i in range(exact.k)):
        return Found(exact, exact.sound, (), 1.0), None
    # A base that explains the log leaves only one motor to compare it with.
    found = search(exact, ONE_MOTOR if doubted.explains(doubted.sound) else MOST_CLAIMS)
    if exact.base == doubted.base or (found.explained and not found.account.claims):
        return found, None
    if found.explained:
        near = [doubted.sound, doubted.fit(found.account.kinds, found.account.swap, found.account.q)]
        other = climbed(doubted, min(near, key=Found(doubted, near[0], (), found.scale).cost))
    else:
        other = search(doubted)
    if not other.explained:
        return found, None
    A = doubted.problems[other.account.swap].slopes(other.account.q, np.ones(len(doubted.log.theta)))[:, :6]
    A = A[: -len(doubted.problems[()].usual)] * np.repeat(doubted.base, 3)
    base = float(np.linalg.slogdet(np.eye(6) + A.T @ A)[1]) + CLEAR
    if not found.explained or other.cost(other.account) + base < other.cost(found.account):
        return other, None
    return found, other


def _slides(wiring: Wiring, i: int) -> bool:
    """Whether the joint that motor i moves most slides."""
    return wiring.arm.units[int(np.abs(wiring.motors.P[:, i]).argmax())] == "m"


def _moved(wiring: Wiring, i: int) -> bool:
    """Whether motor i was moved enough for its log to say anything."""
    travel = float(np.ptp(wiring.problems[()].log.theta[:, i]) / wiring.unit[i])
    return travel >= (LITTLE_LENGTH if _slides(wiring, i) else LITTLE_ANGLE)


def _residual(wiring: Wiring, swap: tuple[int, ...], q: Array) -> Residual:
    off = wiring.problems[swap].misses(q)
    position, rotation = (float(np.sqrt((part * part).sum(axis=1).mean())) for part in (off[:, :3], off[:, 3:]))
    return Residual(position, rotation if wiring.problems[swap].measured[0, 3] else None)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a log says of all motors, from an account that explains it. `or_base`: with a base that stands elsewhere."""

    found: Found
    or_base: Found | None

    def named(self, account: Account, i: int) -> tuple[str, ...]:
        """The faults of motor i in an account that are worth a name."""
        wiring = self.found.wiring
        s, e = 1.0 + account.q[12 + wiring.k + i], account.q[12 + i] / wiring.unit[i]
        faults = {
            "swapped": i in account.swap,
            "flipped sign": s < 0,
            "wrong ratio": abs(abs(s) - 1.0) > SMALL_SCALE,
            "zero offset": abs(e) > (SMALL_LENGTH if _slides(wiring, i) else SMALL_ANGLE),
        }
        return tuple(name for name, there in faults.items() if there)

    @cached_property
    def faults(self) -> tuple[tuple[str, ...], ...]:
        """Those of each motor in the account."""
        return tuple(self.named(self.found.account, i) for i in range(self.found.wiring.k))

    @cached_property
    def rivals(self) -> list[Account]:
        """Accounts that claim no more and fit as well."""
        found = self.found
        return [one for one in found.others if one.claims <= found.account.claims and found.as_good(one)]

    def of_base(self, i: int) -> bool:
        """Whether a base that stands elsewhere explains the fault of motor i as well."""
        return self.or_base is not None and self.named(self.or_base.account, i) != self.faults[i]

    @cached_property
    def suspects(self) -> dict[int, dict[int, list[Account]]]:
        """For each fault that is not certain, by its motor: the suspected motors, and the accounts that blame them."""
        suspects = {}
        for i, faults in enumerate(self.faults):
            rivals = [one for one in self.rivals if not set(self.named(one, i)) >= set(faults)]
            rivals += [self.or_base.account] if self.or_base and self.of_base(i) else []
            if faults and rivals:
                blamed = {
                    j: [one for one in rivals if set(self.named(one, j)) - set(self.faults[j])]
                    for j in range(self.found.wiring.k)
                }
                suspects[i] = {j: accounts for j, accounts in blamed.items() if accounts or j == i}
        return suspects

    @cached_property
    def std(self) -> Array:
        """Standard deviations (2k,) of zeros and scales with all of them fitted; inf where the log shows nothing."""
        wiring, account = self.found.wiring, self.found.account
        free = wiring.free((ANYTHING,) * wiring.k)
        A = wiring.problems[account.swap].slopes(account.q, np.ones(len(wiring.log.theta)))[:, free]
        size = np.linalg.norm(A, axis=0)
        _, values, Vt = np.linalg.svd(A / np.where(size > 0, size, 1.0), full_matrices=False)
        kept = values > 1e-9 * values[0]
        hidden = 1.0 - (Vt[kept] ** 2).sum(axis=0) > ROUNDING
        with np.errstate(divide="ignore"):
            std = np.sqrt(((Vt[kept] / values[kept, None]) ** 2).sum(axis=0)) / size
        return np.asarray(np.where(hidden | (size == 0), np.inf, std)[-2 * wiring.k :])

    @cached_property
    def unseen(self) -> list[list[str]]:
        """For each motor what the log does not show: sign, ratio, zero."""
        wiring, k = self.found.wiring, self.found.wiring.k
        zero = [SEEN_LENGTH if _slides(wiring, i) else SEEN_ANGLE for i in range(k)] * wiring.unit
        signs = self._unseen_signs()
        return [
            ["sign"] * (i in signs)
            + ["ratio"] * bool(self.std[k + i] > SEEN_SCALE)
            + ["zero"] * bool(self.std[i] > zero[i])
            for i in range(k)
        ]

    def _unseen_signs(self) -> set[int]:
        """Motors that may also turn the other way: one with another zero, or several at once."""
        found, wiring, k = self.found, self.found.wiring, self.found.wiring.k
        account, unseen = found.account, set[int]()
        for i, kind in enumerate(account.kinds):
            q = account.q.copy()
            q[12 + k + i] = -2.0 - q[12 + k + i]  # the scale 1 + q with the other sign
            other = ANYTHING if KINDS[kind].scale else "zero" if KINDS[kind].sign < 0 else "reversed, zero"
            if found.as_good(wiring.fit(account.with_kind(i, other), account.swap, q)):
                unseen.add(i)
        patterns = sign_patterns(k)
        starts = np.tile(account.q, (len(patterns), 1))
        starts[:, 12 + k :] = (1.0 + starts[:, 12 + k :]) * patterns - 1.0
        totals = wiring.squares(account.swap, starts, MOST_ROWS)
        for pattern, total in zip(patterns, totals.tolist(), strict=True):
            flipped = set(np.flatnonzero(pattern < 0).tolist())
            if total < account.total + 9.0 * found.scale and not flipped & unseen:
                unseen |= flipped
        return unseen

    @cached_property
    def unseen_swaps(self) -> list[tuple[int, ...]]:
        """Pairs of motors that may also be swapped, with everything else as found; one of them has moved."""
        found, account = self.found, self.found.account
        others = [one for one in found.others if one.kinds == account.kinds and one.swap and one.swap != account.swap]
        return [one.swap for one in others if found.as_good(one) and any(_moved(found.wiring, i) for i in one.swap)]

    def judged(self, row: int) -> tuple[str, str, tuple[MotorVerdict, ...]]:
        """The verdict, its words, and the motors' verdicts. `row`, from 1, fits least; 0: none is loud."""
        wiring = self.found.wiring
        if not any(_moved(wiring, i) for i in range(wiring.k)):
            each = [MotorVerdict(wiring.motors.names[i], remedy=self._advice(i)) for i in range(wiring.k)]
            return "cannot tell", "no motor was moved, so the log shows nothing of any", tuple(each)
        if not self.found.explained:
            odd = f"row {row} fits least: measure it again, or leave it out" if row else "check --position-noise"
            what = f"no sign, ratio or zero of single motors explains the log; {odd}"
            return "unexplained", what, tuple(map(MotorVerdict, wiring.motors.names))
        each = [self._verdict(i) for i in range(wiring.k)]
        wrong, possible, hidden = (
            [motor.name for motor in each if motor.verdict == verdict]
            for verdict in ("fault", "possible fault", "cannot tell")
        )
        base = " or the base" * any(self.of_base(i) for i in self.suspects)
        parts = [f"the log shows what is wrong with {listed(wrong)}"] if wrong else []
        parts += [f"the log does not show which is wrong of {listed(possible)}{base}"] if possible else []
        if parts:
            return "fault", "; ".join(parts), tuple(each)
        if hidden:
            return "cannot tell", f"the log does not show all of {listed(hidden)}; the rest is sound", tuple(each)
        return "sound", "signs, ratios and zeros fit the log", tuple(each)

    def _verdict(self, i: int) -> MotorVerdict:
        found, motors, k = self.found, self.found.wiring.motors, self.found.wiring.k
        groups = [group for group in self.suspects.values() if i in group]
        accounts = [one for group in groups for one in group[i]]
        account = found.account if self.faults[i] or not accounts else accounts[0]
        s, e = float(1.0 + account.q[12 + k + i]), float(account.q[12 + i])
        swaps = [motors.names[j] for pair in self.unseen_swaps if i in pair for j in pair if j != i]
        unseen = (*self.unseen[i], *(f"swapped with {name}" for name in swaps))
        joints = {motors.joint_names[j]: float(motors.P[j, i] * e) for j in self._joints(i)}
        motor = MotorVerdict(
            motors.names[i], "sound", self.named(account, i), unseen, s, float(self.std[k + i]), e, float(self.std[i]),
            joints, what="sign, ratio and zero fit the log",
        )  # fmt: skip
        partners = [motors.names[j] for j in account.swap if j != i]
        faulty = ", ".join(
            f"{fault} with {listed(partners)}" if fault == "swapped" else fault for fault in motor.faults
        )
        if groups:
            of_base = any(self.of_base(j) for j, group in self.suspects.items() if i in group)
            others = sorted({motors.names[j] for group in groups for j in group if j != i})
            said = [*[faulty] * bool(faulty), *map("a fault of {!r}".format, others), *["the base's place"] * of_base]
            what = f"{', or '.join(said)}: the log does not show which"
            remedy = BASE_KNOWN if of_base else self._advice(i)
            return replace(motor, verdict="possible fault", what=what, remedy=remedy)
        ratio = {joint: float(g / s) for joint, g in zip(motors.joint_names, motors.G[i], strict=True) if g}
        motor = replace(motor, ratio=ratio, zero=float(motors.offset[i] - e / s))
        hidden = f"the log does not show: {', '.join(unseen)}"
        if self.faults[i]:
            entries = ", ".join(f"{joint} = {value:.7g}" for joint, value in ratio.items())
            remedies = ["swap their plugs, or their names in the arm.toml"] if i in account.swap else []
            if self.faults[i] != ("swapped",):
                table = f"[actuators.{motor.name}]"
                remedies.append(f"as wired, {table} has ratio = {{ {entries} }}, offset = {motor.zero:.7g}")
            what = "; ".join([faulty, *[hidden] * bool(unseen)])
            return replace(motor, verdict="fault", what=what, remedy="; ".join(remedies))
        if unseen:
            of_base = unseen == ("zero",) and bool(found.account.q[:6].any())
            remedy = BASE_KNOWN if of_base else self._advice(i)
            return replace(motor, verdict="cannot tell", what=hidden, remedy=remedy)
        return motor

    def _joints(self, i: int) -> list[int]:
        """The joints that motor i moves, the other motors standing still."""
        moved = np.abs(self.found.wiring.motors.P[:, i])
        return [int(j) for j in np.flatnonzero(moved > ROUNDING * moved.max())]

    def _advice(self, i: int) -> str:
        """What to log so that motor i is seen, and told from others."""
        wiring = self.found.wiring
        joints = ", ".join(wiring.motors.joint_names[j] for j in self._joints(i))
        if not _moved(wiring, i):
            return (
                f"move it: log {joints} at several places, {'100 mm' if _slides(wiring, i) else '30°'} apart and more"
            )
        if len(wiring.log.theta) < 2 * wiring.k:
            return f"log more moments, {2 * wiring.k} at least, every joint moved by itself"
        if not wiring.problems[()].measured[0, 3]:
            return "measure the tool's orientation too, or a point of the tool beside its axis"
        return f"log more moments in which {joints} moves by itself"
