"""`check_wiring`: from a log to a verdict on every motor."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from ..arm.arm import Arm, require_arm
from ..limits.actuators import Actuators
from ..support.checks import Array, as_not_negative, as_positive, require_callback
from ..support.errors import InputError
from .faults import moved
from .fit import best_fit
from .hypotheses import fewest_faults, freedom
from .log import WiringLog, read_log
from .model import USUAL, Wiring
from .report import Residual, WiringReport
from .search import Found, Progress, as_sound, readings, search, swapped
from .verdicts import judged, unjudged, unmoved

MOST_ROWS = 200
"""Most moments to fit, evenly from the log. Neighbouring moments of a camera have the same errors and add nothing."""

LOUDEST = 0.02
"""Greatest noise [m] of usable positions."""

UNITS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "kilometres": 1000.0}
"""Possible units of logged positions, in metres."""

SIMILAR = 3.0
"""Greatest ratio of the mean distances from the base in two logs of one arm."""

CONFIGURATIONS = 200


def check_wiring(
    arm: Arm,
    log: WiringLog | str | os.PathLike[str],
    *,
    position_noise: float = 0.002,
    orientation_noise: float = float(np.radians(1.0)),
    base_position_noise: float | None = None,
    base_orientation_noise: float | None = None,
    progress: Progress | None = None,
) -> WiringReport:
    """Check the motors' signs, ratios and zeros against a log of counts and measured tool poses.

    The check fits theta = G⁻¹ (s y + e) to the poses. y are the motors' readings from their configured zeros. Faults
    are the fewest deviations from s = 1, e = 0 that explain the log. They are clear from the noise and larger than 1°,
    5 mm or 2 %. If others explain the log as well, all are named and none is corrected.

    The verdict is "cannot tell" if the log does not show a motor's sign, scale, offset, or a swap. It comes with what
    to move or measure. A fault that the base's pose explains as well is "possible". An offset of the first joint is an
    example (law: `model.BaseError`). A log that nothing explains takes seconds.

    Args:
        arm: The arm, with actuators.
        log: A `WiringLog`, or the path of a CSV file of counts and measured tool poses.
        position_noise: Standard deviation of the measured position [m].
        orientation_noise: Standard deviation of the measured orientation [rad].
        base_position_noise: Standard deviation of the base's position [m]. By default 0; that of a tape measure if
            the log is not sound with 0.
        base_orientation_noise: The same for the base's orientation [rad].
        progress: Called with the fraction done, or None.

    Returns:
        The `WiringReport`: a verdict on each motor and one on the whole arm.

    Raises:
        InputError: The arm has no actuators, they do not determine its joints, or the log is unusable.
    """
    motors = require_arm(arm).actuators
    require_callback(progress, "progress", "(fraction)")
    if motors is None:
        raise InputError(f"{arm.name} has no actuators: describe its motors as [actuators.NAME] in its arm.toml")
    said = {"base_position_noise": base_position_noise, "base_orientation_noise": base_orientation_noise}
    base = [None if value is None else as_not_negative(value, name) for name, value in said.items()]
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    logged = log if isinstance(log, WiringLog) else read_log(log, motors)
    counts = logged.of(motors)
    if not len(counts):
        raise InputError("the log holds no moment: give a row of counts and the tool's position for each")
    report_progress = progress or (lambda _: None)
    as_said = _wiring(arm, motors, counts, logged.measured, noise)
    as_said = replace(as_said, base=(base[0] or 0.0, base[1] or 0.0))
    doubted = USUAL[0] if base[0] is None else base[0], USUAL[1] if base[1] is None else base[1]
    unit, as_said, found = _explained(as_said, motors, doubted, _part(report_progress, 0, 2))
    as_said = replace(as_said, base=found.wiring.base)
    wiring, p = swapped(as_said, motors, found.swapped), found.explanation.p
    if _is_motionless(wiring):
        verdict, what, each = unmoved(found, motors)
    elif found.fits:
        verdict, what, each = judged(found, motors)
    else:
        why_not = _why_not(found, motors, doubted, _part(report_progress, 1, 2))
        verdict, what, each = "unexplained", why_not, unjudged(motors)
    if unit:
        verdict, what = "unexplained", f"the positions look like {unit}: log x, y, z in metres; read so, {what}"
    base_offset, wiring = wiring.base_offset(p), wiring.with_base_moved(p)
    before, after = _residual(as_said, as_said.sound), _residual(wiring, p)
    return WiringReport(
        arm.name, verdict, what, each, len(counts), before, after, _worst_row(wiring, p) + 1, base_offset
    )


def _wiring(arm: Arm, motors: Actuators, counts: Array, measured: Array, noise: tuple[float, float]) -> Wiring:
    poses = measured.ndim == 3
    P = motors.velocity_to_theta(np.eye(len(motors.names))).T
    more = len(motors.names) > arm.n
    return Wiring(
        arm=arm,
        y=readings(motors, counts),
        position=measured[:, :3, 3] if poses else measured,
        rotation=measured[:, :3, :3] if poses else None,
        noise=noise,
        P=P,
        unit=1.0 / np.abs(P).max(axis=0),
        surplus=np.eye(len(motors.names)) - motors.G @ P if more else None,
    )


def _explained(
    wiring: Wiring, motors: Actuators, doubted: tuple[float, float], progress: Progress
) -> tuple[str, Wiring, Found]:
    """The unit of the logged positions (empty for metres), the wiring in metres, and the findings."""
    if _is_motionless(wiring):
        return "", wiring, as_sound(_thinned(wiring))
    units = _plausible_units(wiring)
    for done, unit in enumerate(units):
        metres = replace(wiring, position=UNITS[unit] * wiring.position)
        found = search(_thinned(metres), motors, doubted, _part(progress, done, len(units) + 1))
        if found.fits:
            return unit, metres, found
    return "", wiring, search(_thinned(wiring), motors, doubted, _part(progress, len(units), len(units) + 1))


def _plausible_units(wiring: Wiring) -> list[str]:
    """The `UNITS` in which the measured distances match the arm's; none for metres.

    The arm's distances are those of random configurations, because the motors' readings may be wrong.
    """
    usual = _mean_distance(wiring.arm.fk(wiring.arm.random_theta(0, CONFIGURATIONS))[:, :3, 3])
    measured = _mean_distance(wiring.position)
    if not usual or not measured or 1 / SIMILAR < measured / usual < SIMILAR:
        return []
    return [unit for unit, metres in UNITS.items() if 1 / SIMILAR < metres * measured / usual < SIMILAR]


def _mean_distance(position: Array) -> float:
    return float(np.sqrt((position * position).sum(axis=-1).mean()))


def _part(progress: Progress, done: int, parts: int) -> Progress:
    """The progress of one part of several that take about as long."""
    return lambda fraction: progress((done + fraction) / parts)


def _is_motionless(wiring: Wiring) -> bool:
    return not any(moved(wiring, i) for i in range(wiring.k))


def _thinned(wiring: Wiring) -> Wiring:
    K = len(wiring.y)
    return wiring if K <= MOST_ROWS else wiring.of_rows(np.linspace(0, K - 1, MOST_ROWS).astype(int))


def _why_not(found: Found, motors: Actuators, base: tuple[float, float], progress: Progress) -> str:
    """The outlying row, or the noise that explains the log, in words."""
    wiring = found.wiring
    K, odd = len(wiring.y), _worst_row(wiring, found.explanation.p)
    if 3 < K <= MOST_ROWS:
        rest = wiring.of_rows(np.delete(np.arange(K), odd))
        if fewest_faults(rest, *best_fit(rest, _part(progress, 0, 2))).fits(rest):
            return f"row {odd + 1} of the log does not fit the others: measure it again, or leave it out"
    louder = float(np.sqrt(found.explanation.total / freedom(wiring, 2 * wiring.k)))  # which explains what is left
    position, orientation = louder * wiring.noise[0], louder * wiring.noise[1]
    if position <= LOUDEST:
        loud = replace(swapped(wiring, motors, found.swapped), noise=(position, orientation), base=base)
        heard = search(loud, motors, base, _part(progress, 1, 2))
        if heard.fits:
            turned = "" if wiring.rotation is None else f" --orientation-noise {np.degrees(orientation):.2g}"
            return (
                "measured less well than was said, or something else is wrong; with "
                f"--position-noise {position:.2g}{turned} the log reads: {judged(heard, motors)[1]}"
            )
    return (
        "no sign, ratio or zero of single motors explains the log: check that the tool was measured in the axes of "
        f"{wiring.arm.base} and at {wiring.arm.tip}, in metres, while the arm stood still, and the lengths of the arm"
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
