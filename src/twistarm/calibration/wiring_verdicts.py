"""`check_wiring`: from a log to a verdict on every motor, with what to correct or to log."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations, compress

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array, as_number, as_positive, as_theta
from ..support.display import Brief
from ..support.errors import ComparisonError, InputError, listed
from ..theory.screws import exp, inverse_of
from .geometry import BASE
from .measurements import LITTLE, Bools, Measurements, read_measurements, require_metres, require_motors
from .problem import OUTLIER
from .wiring import ANYTHING, CLEAR, MOST_ROWS, REVERSED_ZERO, ZERO, Explanation, Found, Wiring, explained

# Normal errors of a scale, or of an offset by the joint's unit. They are no faults, even if the log shows them.
NORMAL = {"1": 0.02, "rad": float(np.radians(1.0)), "m": 0.005}
VISIBLE = 2.0  # Normal errors that the standard deviation of a visible scale or offset is at most.
AS_GOOD = 9.0  # Explanations whose squares differ by less, three standard deviations, are equally good.
SURE = 4.0  # A scale or offset so many standard deviations off is a fault, even if the log hardly shows how large.
FAULTS = "swapped", "flipped sign", "wrong ratio", "zero offset"  # Of a motor.
SOUND, CANNOT_TELL, FAULT = VERDICTS = "sound", "cannot tell", "fault"  # The gravest last.
TINY = 1e-9  # A smaller share of a motor's largest ratio, or of what a log shows, is rounding.

BASE_KNOWN = (
    "measure the base anew, by the tool in several configurations; --base-position-noise (metres) and "
    "--base-orientation-noise (degrees) say how well it is known, 0 and 0 exactly"
)


@dataclass(frozen=True)
class MotorVerdict:
    """The log's verdict on one motor: "sound", "fault" or "cannot tell".

    `faults` of a faulty motor are from "swapped", "flipped sign", "wrong ratio" and "zero offset". `ratio` and `zero`
    are the right entries of arm.toml for the present wiring. None: the log cannot tell. `what` and `remedy` say it in
    words.
    """

    name: str
    verdict: str
    faults: tuple[str, ...] = ()
    ratio: Mapping[str, float] | None = None
    zero: float | None = None
    what: str = ""
    remedy: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class WiringReport(Brief):
    """The verdict on the whole arm ("sound", "fault", "cannot tell"), and on each motor.

    `before` is the root mean square [m] of measured against computed positions with the values of arm.toml, `after`
    that with the found ones, over `rows` moments. `base` (4, 4) is where the base seems to stand, seen from its
    measured place, if the log needs that. None: as measured.
    """

    arm: str
    verdict: str
    what: str
    motors: tuple[MotorVerdict, ...]
    rows: int
    before: float
    after: float
    base: Array | None = None

    @property
    def ok(self) -> bool:
        """Every motor is sound, and the log says so."""
        return self.verdict == SOUND

    def require(self) -> WiringReport:
        """Itself, or ComparisonError with what was found."""
        if not self.ok:
            found = [f"{motor.name}: {motor.what}" for motor in self.motors if motor.what]
            raise ComparisonError(f"the wiring of {self.arm}: {'; '.join([f'{self.verdict}: {self.what}', *found])}")
        return self


def check_wiring(
    arm: Arm,
    log: Measurements | str | os.PathLike[str],
    *,
    position_noise: float = 0.002,
    orientation_noise: float = float(np.radians(1.0)),
    base_position_noise: float = 0.01,
    base_orientation_noise: float = float(np.radians(2.0)),
) -> WiringReport:
    """Check the motors' signs, ratios and zeros against a log of counts and measured tool poses.

    The check fits theta = G⁻¹ (s y + e) to the poses. y are the motors' readings from their configured zeros. Faults
    are the fewest deviations from s = 1, e = 0 that explain the log. They are clear from the noise and larger than 1°,
    5 mm or 2 %.

    The verdict is "cannot tell" if the log does not show a motor's sign, scale, offset, or a swap, or if other faults
    explain it as well. It comes with what to move or measure. An offset of the first joint looks like a turned base. A
    log that nothing explains takes seconds.

    Args:
        arm: The arm, with actuators.
        log: `Measurements` of positions or poses with the motors' counts, in base coordinates, or the path of a CSV
            file of them (`read_measurements`).
        position_noise: Standard deviation of the measured position [m].
        orientation_noise: Standard deviation of the measured orientation [rad].
        base_position_noise: Standard deviation of the base's position [m], by default 1 cm.
        base_orientation_noise: Standard deviation of the base's orientation [rad], by default 2°.

    Returns:
        The `WiringReport`: a verdict on each motor and one on the whole arm.

    Raises:
        InputError: The arm has no actuators, they do not determine its joints, or the log is unusable.
    """
    motors, whole = require_motors(arm), _readable(log, arm)
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    base = (
        as_number(base_position_noise, "base_position_noise", 0.0),
        as_number(base_orientation_noise, "base_orientation_noise", 0.0),
    )
    rows = np.unique(np.linspace(0, len(whole.theta) - 1, MOST_ROWS).astype(int))
    wiring, found = explained(Wiring(arm, motors, whole.of_rows(rows), noise, base))
    # A base that may as well stand where it was measured hides no zero of a motor.
    held = replace(wiring, base=(0.0, 0.0))
    there = held.fit(found.best)
    gain = there.total - found.best.total
    if held.explains(there) and (not there.claims or gain < CLEAR * found.variance):
        wiring, found = held, found._replace(best=there)
    q, (before, after) = found.best.q, (replace(wiring, log=whole).problems[swap] for swap in ((), found.best.swap))
    if wiring.explains(found.best):
        verdicts = tuple(map(Evidence(wiring, found).verdict, range(wiring.k)))
        verdict = max((motor.verdict for motor in verdicts), key=VERDICTS.index)
        gravest = ", ".join(motor.name for motor in verdicts if motor.verdict == verdict)
        what = "signs, ratios and zeros fit the log" if verdict == SOUND else gravest
    else:
        verdict, verdicts = CANNOT_TELL, tuple(MotorVerdict(name, CANNOT_TELL) for name in motors.names)
        loud, remedy = after.normalised_residual(q), "check --position-noise"
        if loud.max() > OUTLIER * max(1.0, float(np.median(loud))):
            remedy = f"row {loud.argmax() + 1} fits least: measure it again, or leave it out"
        what = f"no sign, ratio or zero of single motors explains the log; {remedy}"
    stands = inverse_of(exp(q[BASE])) if q[BASE].any() else None
    off, left = (float(np.sqrt((miss**2).mean())) for miss in (before.errors(np.zeros(len(q))), after.errors(q)))
    return WiringReport(arm.name, verdict, what, verdicts, len(whole.theta), off, left, stands)


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


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a log says of each motor, if it is explained."""

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
    def explanations(self) -> list[Explanation]:
        """The best one, and those that fit as well with another sign, or with two motors swapped."""
        wiring, best = self.wiring, self.found.best
        swaps = [] if best.swap else [pair for pair in combinations(range(wiring.k), 2) if self.moved[list(pair)].any()]
        others = [replace(best, swap=pair) for pair in swaps]
        for i, kind in enumerate(best.kinds):
            q = best.q.copy()
            q[i - wiring.k] = -2.0 - q[i - wiring.k]  # the scale 1 + q with the other sign
            other = ANYTHING if kind.scale else ZERO if kind.sign < 0 else REVERSED_ZERO
            others.append(replace(best.with_kind(i, other), q=q))
        most = best.total + AS_GOOD * self.found.variance
        return [best, *(one for one in map(wiring.fit, others) if one.total < most)]

    @cached_property
    def std(self) -> Array:
        """Standard deviations (2k,) of zeros and scales with all of them fitted; huge where the log shows nothing."""
        best = replace(self.found.best, kinds=(ANYTHING,) * self.wiring.k)
        A = self.wiring.problems[best.swap].slopes(best.q, np.ones(len(self.wiring.log.theta)))
        A = A[:, self.wiring.free(best)]
        size = np.maximum(np.linalg.norm(A, axis=0), TINY)
        spread = np.linalg.inv((A / size).T @ (A / size) + TINY * np.eye(len(size)))
        return np.asarray((np.sqrt(np.diag(spread)) / size)[-2 * self.wiring.k :])

    def verdict(self, i: int) -> MotorVerdict:
        """The verdict on motor i: a fault is sure if no explanation lacks it and the log shows how large it is."""
        motors, k, best = self.wiring.motors, self.wiring.k, self.found.best
        each = np.array([self.faults(one)[i] for one in self.explanations])
        doubt = np.asarray(each.any(axis=0) & ~each.all(axis=0))
        s, e = float(best.scales[i]), float(best.zeros[i])
        visible = VISIBLE * np.array([NORMAL["1"], NORMAL[self.units[i]] * self.wiring.unit[i]])
        doubt[2:] |= self.std[[k + i, i]] > np.maximum(visible, [abs(abs(s) - 1.0) / SURE, abs(e) / SURE])
        name, faults = motors.names[i], tuple(compress(FAULTS, each[0] & ~doubt))
        partners = listed(dict.fromkeys(motors.names[j] for one in self.explanations if i in one.swap
                                        for j in one.swap if j != i))  # fmt: skip
        unseen = list(compress((f"swap with {partners}", "sign", "ratio", "zero"), doubt))
        words = [f"swapped with {partners}" if fault == "swapped" else fault for fault in faults]
        words += [f"the log does not show its {', '.join(unseen)}"] if unseen else []
        ratio = {joint: float(g / s) for joint, g in zip(motors.joint_names, motors.G[i], strict=True) if g}
        known, zero = not doubt[:3].any(), None if doubt.any() else float(motors.offset[i] - e / s)
        remedies = ["swap their plugs, or their names in the arm.toml"] * ("swapped" in faults)
        if known and set(faults) - {"swapped"}:
            entries = ", ".join(f"{joint} = {value:.7g}" for joint, value in ratio.items())
            offset = "" if zero is None else f", offset = {zero:.7g}"
            remedies.append(f"as wired, [actuators.{name}] has ratio = {{ {entries} }}{offset}")
        if unseen:
            of_base = unseen == ["zero"] and self.moved[i] and best.q[BASE].any()
            remedies.append(BASE_KNOWN if of_base else self.advice(i))
        verdict = FAULT if faults else CANNOT_TELL if unseen else SOUND
        what, remedy = "; ".join(words), "; ".join(remedies)
        return MotorVerdict(name, verdict, faults, ratio if known else None, zero, what, remedy)

    def advice(self, i: int) -> str:
        """What to log so that motor i is seen."""
        moved = np.abs(self.wiring.motors.P[:, i])
        joints = ", ".join(compress(self.wiring.motors.joint_names, moved > TINY * moved.max()))
        if not self.moved[i]:
            return f"move it: log {joints} at several places, 30° or 100 mm apart and more"
        if not self.wiring.problems[()].measured[0, 3]:
            return "measure the tool's orientation too, or a point of the tool beside its axis"
        return f"log more moments, {2 * self.wiring.k} at least, in which {joints} moves by itself"
