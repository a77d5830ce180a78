"""`check_wiring`: from a log to a verdict on every motor."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import combinations

import numpy as np

from ..actuators import Actuators
from ..arm import Arm
from ..checks import Array, as_number
from ..errors import InputError
from .fit import best_fit, from_sound
from .hypotheses import Explanation, fewest_faults
from .log import WiringLog, read_log
from .model import Wiring
from .report import MotorVerdict, Residual, WiringReport
from .verdicts import verdicts

MOST_ROWS = 200
"""Moments that are fitted, evenly out of the log: a camera's neighbouring ones err alike and add nothing."""


def check_wiring(
    arm: Arm,
    log: WiringLog | str | os.PathLike[str],
    *,
    position_noise: float = 0.002,
    orientation_noise: float = float(np.radians(1.0)),
) -> WiringReport:
    """Whether the signs, ratios and zeros of the arm's motors fit a log of their counts and of measured tool poses.

    `log`: a WiringLog, or the path of a CSV (`read_log`). `position_noise` [m] and `orientation_noise` [rad] are one
    standard deviation of the measuring. theta = G⁻¹ (s y + e) is fitted to the poses, y being what the motors read
    from their configured zeros; faults are the fewest deviations from s = 1, e = 0 that explain the log, of those
    that are clear from the noise and more than 1°, 5 mm or 2 %. Where the log cannot show a motor's scale or offset,
    the verdict is "cannot tell", and what to move or measure.

    Raises InputError for an arm without actuators, joints that they do not determine, and an unusable log.
    """
    motors = arm.actuators
    if motors is None:
        raise InputError(f"{arm.name} has no actuators: describe its motors as [actuators.NAME] in its arm.toml")
    noise = _positive(position_noise, "position_noise"), _positive(orientation_noise, "orientation_noise")
    logged = log if isinstance(log, WiringLog) else read_log(log, motors)
    counts = logged.of(motors)
    if not len(counts):
        raise InputError("the log holds no moment: give a row of counts and the tool's position for each")
    as_said = _wiring(arm, motors, counts, logged.measured, noise)
    wiring, found, swapped = _explained(as_said, motors, counts)
    each = verdicts(_thinned(wiring), found, motors, swapped)
    verdict, what = _verdict(each) if found.fits(_thinned(wiring)) else ("unexplained", _why_not(wiring, found.p))
    before, after = _residual(as_said, as_said.sound), _residual(wiring, found.p)
    return WiringReport(arm.name, verdict, what, each, len(counts), before, after, _worst_row(wiring, found.p) + 1)


def _wiring(arm: Arm, motors: Actuators, counts: Array, measured: Array, noise: tuple[float, float]) -> Wiring:
    poses = measured.ndim == 3
    P = motors.velocity_to_theta(np.eye(len(motors.names))).T
    more = len(motors.names) > arm.n
    return Wiring(
        arm=arm,
        y=_readings(motors, counts),
        position=measured[:, :3, 3] if poses else measured,
        rotation=measured[:, :3, :3] if poses else None,
        noise=noise,
        P=P,
        unit=1.0 / np.abs(P).max(axis=0),
        surplus=np.eye(len(motors.names)) - motors.G @ P if more else None,
    )


def _readings(motors: Actuators, counts: Array) -> Array:
    """What the motors read from their zeros (K, k) [rad or m]."""
    return motors.from_counts(counts) - motors.offset


def _explained(wiring: Wiring, motors: Actuators, counts: Array) -> tuple[Wiring, Explanation, tuple[int, ...]]:
    """The wiring and its explanation, and which two motors have to be swapped for it.

    Swapped motors are looked for first: they are one fault, which looks like several.
    """
    few = _thinned(wiring)
    found = fewest_faults(few, *from_sound(few))
    if found.fits(few):
        return wiring, found, ()
    swaps = []
    for i, j in combinations(range(wiring.k), 2):
        order = np.arange(wiring.k)
        order[[i, j]] = j, i
        other = replace(wiring, y=_readings(motors, counts[:, order]))
        swaps.append((other, fewest_faults(_thinned(other), *from_sound(_thinned(other))), (i, j)))
        if swaps[-1][1].fits(few) and swaps[-1][1].sound:
            return swaps[-1]
    found = fewest_faults(few, *best_fit(few))
    return (wiring, found, ()) if found.fits(few) else min([(wiring, found, ()), *swaps], key=lambda one: one[1].total)


def _thinned(wiring: Wiring) -> Wiring:
    K = len(wiring.y)
    return wiring if K <= MOST_ROWS else wiring.of_rows(np.linspace(0, K - 1, MOST_ROWS).astype(int))


def _verdict(each: tuple[MotorVerdict, ...]) -> tuple[str, str]:
    if any(motor.verdict == "fault" for motor in each):
        return "fault", "the log shows what is wrong with the motors named"
    if any(motor.verdict == "cannot tell" for motor in each):
        return "cannot tell", "what the log shows is sound, but it does not show every motor"
    return "sound", "signs, ratios and zeros fit the log"


def _why_not(wiring: Wiring, p: Array) -> str:
    """The row without which the log can be explained, if there is one."""
    K, odd = len(wiring.y), _worst_row(wiring, p)
    if 3 < K <= MOST_ROWS:
        rest = wiring.of_rows(np.delete(np.arange(K), odd))
        if fewest_faults(rest, *best_fit(rest)).fits(rest):
            return f"row {odd + 1} of the log does not fit the others: measure it again, or leave it out"
    return (
        "no sign, ratio or zero of single motors explains the log: check that the tool was measured in the axes of "
        f"{wiring.arm.base} and at {wiring.arm.tip}, while the arm stood still, and the lengths of the arm"
    )


def _residual(wiring: Wiring, p: Array) -> Residual:
    position, rotation = wiring.misses(p)
    rms = [None if miss is None else float(np.sqrt((miss * miss).sum(axis=-1).mean())) for miss in (position, rotation)]
    assert rms[0] is not None
    return Residual(rms[0], rms[1])


def _worst_row(wiring: Wiring, p: Array) -> int:
    position, rotation = wiring.misses(p)
    misses = (position / wiring.noise[0]) ** 2
    if rotation is not None:
        misses = misses + (rotation / wiring.noise[1]) ** 2
    return int(misses.sum(axis=-1).argmax())


def _positive(value: float, name: str) -> float:
    number = as_number(value, name)
    if not number > 0:
        raise InputError(f"{name} must be positive; got {number:g}")
    return number
