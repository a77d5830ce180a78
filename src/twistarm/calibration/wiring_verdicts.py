"""`check_wiring`: from a log to a verdict on every motor, with what to correct or to log."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import compress
from math import inf
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array, as_number, as_positive, as_theta
from ..support.display import Brief
from ..support.errors import ComparisonError, InputError, listed
from ..theory.screws import exp, inverse_of
from .geometry import BASE
from .measurements import LITTLE, Bools, Measurements, read_measurements, require_metres, require_motors
from .problem import OUTLIER, Problem
from .wiring import ANYTHING, KINDS, MOST_ROWS, Explanation, Found, Wiring, explained, sign_patterns

# Normal errors of a scale, or of an offset by the joint's unit. They are no faults, even if the log shows them.
NORMAL = {"1": 0.02, "rad": float(np.radians(1.0)), "m": 0.005}
# Greatest standard deviations of a visible scale or offset.
VISIBLE = {"1": 0.05, "rad": float(np.radians(2.0)), "m": 0.01}
# One standard deviation [m, rad] of a base measured by tape, for logs that need it.
USUAL_BASE = (0.01, float(np.radians(2.0)))
FAULTS = "swapped", "flipped sign", "wrong ratio", "zero offset"  # Of a motor.
# On motors, the gravest first; that on the arm is the gravest of them.
VERDICTS = "fault", "possible fault", "cannot tell"
ROUNDING = 1e-6  # A smaller share of a motor's largest ratio, or of a direction that no log shows, is rounding.

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
class WiringReport(Brief):
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
    motors, whole = require_motors(arm), _readable(log, arm)
    noises = {"base_position_noise": base_position_noise, "base_orientation_noise": base_orientation_noise}
    given = [None if noise is None else as_number(noise, name, 0.0) for name, noise in noises.items()]
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    rows = np.unique(np.linspace(0, len(whole.theta) - 1, MOST_ROWS).astype(int))
    usual = [most if std is None else std for std, most in zip(given, USUAL_BASE, strict=True)]
    base, elsewhere = (given[0] or 0.0, given[1] or 0.0), (usual[0], usual[1])
    wiring = Wiring(arm, motors, whole.of_rows(rows), noise, base, elsewhere)
    found = explained(wiring)
    before, after = (replace(wiring, log=whole).problems[swap] for swap in ((), found.best.swap))
    residuals = after.normalised_residual(found.best.q)
    verdict, what, verdicts = _verdicts(Evidence(wiring, found), residuals)
    return WiringReport(
        arm.name, verdict, what, verdicts, len(residuals),
        _residual(before, np.zeros(len(found.best.q))), _residual(after, found.best.q), int(residuals.argmax()) + 1,
        inverse_of(exp(found.best.q[BASE])) if found.best.q[BASE].any() else None,
    )  # fmt: skip


def _readable(log: Measurements | str | os.PathLike[str], arm: Arm) -> Measurements:
    """The log, or InputError if its rows do not show where the motors bring the tool."""
    whole = log if isinstance(log, Measurements) else read_measurements(log, arm, counts=True)
    names = require_motors(arm).names
    as_theta(whole.theta, len(names), "counts", names)
    if not len(whole.theta) or not whole.located.all():
        raise InputError("the log must hold a measured position x, y, z for each row of counts, one row or more")
    oriented = np.isfinite(whole.rotation).all(axis=(1, 2))
    if oriented.any() and not oriented.all():
        raise InputError("measure the orientation in every row of the log, or in none")
    require_metres(whole, arm)
    return whole


def _residual(problem: Problem, q: Array) -> Residual:
    position, rotation = np.sqrt((problem.misses(q).reshape(-1, 2, 3) ** 2).sum(axis=2).mean(axis=0)).tolist()
    return Residual(position, rotation if problem.measured[0, 3] else None)


def _verdicts(evidence: Evidence, residuals: Array) -> tuple[str, str, tuple[MotorVerdict, ...]]:
    """The verdict on the arm, in words too, and that on each motor; `residuals` (K,) are those of the rows [σ]."""
    motors = range(evidence.wiring.k)
    unknown = [MotorVerdict(name) for name in evidence.wiring.motors.names]
    if not evidence.moved.any():
        advised = tuple(replace(motor, remedy=evidence.advice(i)) for i, motor in enumerate(unknown))
        return "cannot tell", "no motor was moved, so the log shows nothing of any", advised
    if not evidence.wiring.explains(evidence.found.best):
        worst, remedy = int(residuals.argmax()), "check --position-noise"
        if residuals[worst] > OUTLIER * max(1.0, float(np.median(residuals))):
            remedy = f"row {worst + 1} fits least: measure it again, or leave it out"
        return "unexplained", f"no sign, ratio or zero of single motors explains the log; {remedy}", tuple(unknown)
    verdicts = tuple(map(evidence.verdict, motors))
    named = {found: [motor.name for motor in verdicts if motor.verdict == found] for found in VERDICTS}
    named["possible fault"] += ["the base"] * evidence.of_base
    gravest = next((found for found in VERDICTS if named[found]), "sound").removeprefix("possible ")
    what = "; ".join(f"{found}: {', '.join(names)}" for found, names in named.items() if names)
    return gravest, what or "signs, ratios and zeros fit the log", verdicts


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a log says of each motor: the best explanation, and its rivals."""

    wiring: Wiring
    found: Found

    @cached_property
    def units(self) -> list[str]:
        """The unit of the joint that each motor moves most."""
        return [self.wiring.arm.units[j] for j in np.abs(self.wiring.motors.P).argmax(axis=0)]

    @cached_property
    def moved(self) -> Bools:
        """Whether each motor (k,) was moved enough for its log to say anything."""
        travel = np.ptp(self.wiring.problems[()].log.theta, axis=0) / self.wiring.unit
        return np.asarray(travel >= [LITTLE[unit] for unit in self.units])

    def faults(self, one: Explanation) -> Bools:
        """The `FAULTS` (k, 4) of each motor in an explanation that are worth a name."""
        swapped = np.isin(np.arange(self.wiring.k), one.swap)
        ratio = np.abs(np.abs(one.scales) - 1.0) > NORMAL["1"]
        zero = np.abs(one.zeros / self.wiring.unit) > [NORMAL[unit] for unit in self.units]
        return np.stack([swapped, one.scales < 0.0, ratio, zero], axis=1)

    @cached_property
    def doubts(self) -> list[tuple[Explanation, Bools, Bools]]:
        """The rivals that lack a fault of some motor, of which motors (k,) they lack one, and which they blame more."""
        ours, doubts = self.faults(self.found.best), []
        for rival in self.found.rivals:
            theirs = self.faults(rival)
            # A base that stands elsewhere stands for a fault only if it changes no other one of that motor.
            other = (ours != theirs) if rival.elsewhere else ours & ~theirs
            lacking, more = ours.any(axis=1) & other.any(axis=1), (theirs & ~ours).any(axis=1)
            if lacking.any():
                doubts.append((rival, np.asarray(lacking), np.asarray(more)))
        return doubts

    @property
    def of_base(self) -> bool:
        """Whether a base that stands elsewhere explains a fault as well."""
        return any(rival.elsewhere for rival, _, _ in self.doubts)

    @cached_property
    def std(self) -> Array:
        """Standard deviations (2k,) of zeros and scales with all of them fitted; inf where the log shows nothing."""
        best = replace(self.found.best, kinds=(ANYTHING,) * self.wiring.k)
        A = self.wiring.problems[best.swap].slopes(best.q, np.ones(len(self.wiring.log.theta)))
        A = A[:, self.wiring.free(best)]
        size = np.linalg.norm(A, axis=0)
        _, values, Vt = np.linalg.svd(A / np.where(size > 0, size, 1.0), full_matrices=False)
        kept = values > 1e-9 * values[0]
        hidden = 1.0 - (Vt[kept] ** 2).sum(axis=0) > ROUNDING
        with np.errstate(divide="ignore"):
            std = np.sqrt(((Vt[kept] / values[kept, None]) ** 2).sum(axis=0)) / size
        return np.asarray(np.where(hidden | (size == 0), np.inf, std)[-2 * self.wiring.k :])

    @cached_property
    def unseen_signs(self) -> Bools:
        """Motors (k,) that may also turn the other way: one with another zero, or several at once."""
        found, wiring, k, best = self.found, self.wiring, self.wiring.k, self.found.best
        unseen = np.zeros(k, dtype=bool)
        for i, kind in enumerate(best.kinds):
            q = best.q.copy()
            q[i - k] = -2.0 - q[i - k]  # the scale 1 + q with the other sign
            other = ANYTHING if KINDS[kind].scale else "zero" if KINDS[kind].sign < 0 else "reversed, zero"
            unseen[i] = found.as_good(wiring.fit(replace(best.with_kind(i, other), q=q)))
        patterns = sign_patterns(k)
        starts = np.tile(best.q, (len(patterns), 1))
        starts[:, -k:] = best.scales * patterns - 1.0
        totals = wiring.squares(best.swap, starts, MOST_ROWS)
        for flipped, total in zip(patterns < 0, totals.tolist(), strict=True):
            if found.as_good(replace(best, total=total)) and not (flipped & unseen).any():
                unseen |= flipped
        return unseen

    def unseen(self, i: int) -> tuple[str, ...]:
        """What the log does not show of motor i: sign, ratio, zero, or a swap of motors one of which has moved."""
        k, best = self.wiring.k, self.found.best
        hidden = {
            "sign": self.unseen_signs[i],
            "ratio": self.std[k + i] > VISIBLE["1"],
            "zero": self.std[i] > VISIBLE[self.units[i]] * self.wiring.unit[i],
        }
        partners = [
            self.wiring.motors.names[j]
            for one in self.found.others
            if one.kinds == best.kinds and i in one.swap and one.swap != best.swap
            if self.found.as_good(one) and self.moved[list(one.swap)].any()
            for j in one.swap
            if j != i
        ]
        return (*(name for name, unseen in hidden.items() if unseen), *map("swapped with {}".format, partners))

    def verdict(self, i: int) -> MotorVerdict:
        """The verdict on motor i of a log that is explained."""
        motors, k, best = self.wiring.motors, self.wiring.k, self.found.best
        faulty = self.faults(best)[i]
        blaming = (rival for rival, _, more in self.doubts if more[i])
        one = best if faulty.any() else next(blaming, best)
        faults = tuple(compress(FAULTS, self.faults(one)[i]))
        s, e, unseen = float(one.scales[i]), float(one.zeros[i]), self.unseen(i)
        joints = {motors.joint_names[j]: float(motors.P[j, i] * e) for j in self.joints(i)}
        stds = float(self.std[k + i]), float(self.std[i])
        motor = MotorVerdict(motors.names[i], "sound", faults, unseen, s, stds[0], e, stds[1], joints)
        partners = listed(motors.names[j] for j in one.swap if j != i)
        named = [f"{fault} with {partners}" if fault == "swapped" else fault for fault in faults]
        hidden = [f"the log does not show: {', '.join(unseen)}"] if unseen else []
        possible = np.any([np.zeros(k), *(lacking | more for _, lacking, more in self.doubts)], axis=0)
        if possible[i]:
            others = [f"a fault of {motors.names[j]!r}" for j in np.flatnonzero(possible) if j != i]
            what = ", or ".join([*named, *others, *["the base's place"] * self.of_base])
            remedy = BASE_KNOWN if self.of_base else self.advice(i)
            return replace(motor, verdict="possible fault", what=what, remedy=remedy)
        ratio = {joint: float(g / s) for joint, g in zip(motors.joint_names, motors.G[i], strict=True) if g}
        motor = replace(motor, ratio=ratio, zero=float(motors.offset[i] - e / s))
        if named:
            entries = ", ".join(f"{joint} = {value:.7g}" for joint, value in ratio.items())
            entries = f"as wired, [actuators.{motor.name}] has ratio = {{ {entries} }}, offset = {motor.zero:.7g}"
            plugs = "swap their plugs, or their names in the arm.toml"
            remedies = [*[plugs] * (i in one.swap), *[entries] * (faults != ("swapped",))]
            return replace(motor, verdict="fault", what="; ".join([*named, *hidden]), remedy="; ".join(remedies))
        if unseen:
            of_base = unseen == ("zero",) and bool(one.q[BASE].any())
            remedy = BASE_KNOWN if of_base else self.advice(i)
            return replace(motor, verdict="cannot tell", what="".join(hidden), remedy=remedy)
        return motor

    def joints(self, i: int) -> list[int]:
        """The joints that motor i moves, the other motors standing still."""
        moved = np.abs(self.wiring.motors.P[:, i])
        return [int(j) for j in np.flatnonzero(moved > ROUNDING * moved.max())]

    def advice(self, i: int) -> str:
        """What to log so that motor i is seen."""
        joints, k = ", ".join(self.wiring.motors.joint_names[j] for j in self.joints(i)), self.wiring.k
        if not self.moved[i]:
            far = "100 mm" if self.units[i] == "m" else "30°"
            return f"move it: log {joints} at several places, {far} apart and more"
        if len(self.wiring.log.theta) < 2 * k:
            return f"log more moments, {2 * k} at least, every joint moved by itself"
        if not self.wiring.problems[()].measured[0, 3]:
            return "measure the tool's orientation too, or a point of the tool beside its axis"
        return f"log more moments in which {joints} moves by itself"
