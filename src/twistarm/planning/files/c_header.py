"""A trajectory as a C99 and C++17 header: a table and functions that evaluate it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from ...limits.actuators import Actuators
from ...support.checks import Array
from ...support.code_text import c_number, c_string, c_strings, filled, identifier_of
from ..piecewise import derivative, evaluate, rescaled, side_by_side, through
from ..trajectory import Trajectory, Writing, motors_of, require_motors

FOLDER = Path(__file__).parent

NOTHING = 1e-15  # Share of the greatest position, velocity or acceleration that is rounding.
MOST_NUMBERS = 7500  # 60 kB in double: a longer table is refitted.
# How far [rad, m] the refitted motion may be off, and by what share of the greatest rate: the second if need be.
OFF, RATES_OFF = 5e-7, (1e-3, 1e-2)
LOOKS: Array = np.array([0.0, 0.5, 1.0])  # Where in each old piece the refitted motion is compared.


def header_text(trajectory: Trajectory, how: Writing) -> str:
    """Return the text that `save_trajectory` writes. Every name in it begins with that of the file."""
    name = identifier_of(Path(how.name).stem, "motion")
    motors = require_motors(motors_of(trajectory, how.actuators)) if how.counts else None
    planned, fit = trajectory, ""
    pieces = _pieces(trajectory)
    for most in RATES_OFF:
        if sum(piece.size for piece in pieces) > MOST_NUMBERS:
            trajectory = _refitted(planned, most)
            pieces, fit = _pieces(trajectory), _fit(planned, trajectory)
    if motors is not None:
        trajectory = _counted(trajectory, motors)
        pieces = _pieces(trajectory)
    begins = np.concatenate([[0], np.cumsum([piece.size for piece in pieces])])
    numbers = int(begins[-1]) + len(pieces)
    columns = zip(trajectory.joint_names, trajectory.units, strict=True)
    return filled(
        FOLDER / "motion.h.in",
        name=name,
        file=c_string(Path(how.name).name),
        guard=f"TWISTARM_MOTION_{name.upper()}_H",
        order=", ".join(f"{c_string(joint)} [{unit}]" for joint, unit in columns),
        n=trajectory.n,
        pieces=len(pieces),
        kilobytes=f"{(8 * numbers + 4 * len(begins)) / 1e3:.3g}",
        half=f"{(4 * numbers + 4 * len(begins)) / 1e3:.3g}",
        fit=fit,
        begins=", ".join(map(str, begins)),
        count=begins[-1],
        seconds=f"{trajectory.duration:.6g}",
        duration=c_number(trajectory.duration),
        joint_names=c_strings(trajectory.joint_names),
        units=c_strings(trajectory.units),
        breakpoints=_numbers(trajectory.breakpoints[:-1]),
        coefficients=",\n    ".join(_numbers(row) for piece in pieces for row in piece),
        labels=_labels(trajectory, name),
    )


def _pieces(trajectory: Trajectory) -> list[Array]:
    """Return the coefficients (n, degree + 1) of each piece, highest power first, without powers that do nothing.

    A power does nothing where position, velocity and acceleration of the piece change by less than rounding.
    """
    coefficients, durations = trajectory.coefficients, np.diff(trajectory.breakpoints)
    highest = np.zeros(len(durations), dtype=np.intp)
    for order in range(3):
        rows = np.abs(derivative(coefficients, order))
        terms = rescaled(rows, durations).max(axis=2)
        powers = np.arange(len(rows) - 1, -1, -1)[:, None]
        counts = terms > NOTHING * float(trajectory.peak(order).max())
        highest = np.maximum(highest, np.where(counts, powers + order, 0).max(axis=0))
    return [coefficients[-1 - degree :, i].T for i, degree in enumerate(highest)]


def _refitted(trajectory: Trajectory, most: float) -> Trajectory:
    """Return the motion in the fewest quintic pieces that meet position, velocity and acceleration at their ends.

    A quintic replaces a run of pieces if it is nowhere off by more than `OFF`. Its rates are off by at most the share
    `most` of the joint's greatest, and it has hardly more jerk. A piece that no quintic replaces stays.
    """
    t, steps, c = trajectory.breakpoints, np.diff(trajectory.breakpoints), trajectory.coefficients
    rates = [derivative(c, order) for order in range(3)]
    begin, end = [rate[-1] for rate in rates], [evaluate(rate, steps[:, None]) for rate in rates]
    looks = steps[:, None] * LOOKS
    exact = [evaluate(rate[:, :, None], looks[..., None]) for rate in rates]
    allowed, jerk = (OFF, most * trajectory.peak(1), most * trajectory.peak(2)), (1.0 + most) * trajectory.peak(3)

    @cache
    def fitted(i: int, j: int) -> Array | None:
        """The quintic that replaces the pieces i … j − 1; None without such pieces, or if it is too far off."""
        if j > len(steps):
            return None
        quintic = through(t[[i, j]], *(np.stack([b[i], e[j - 1]]) for b, e in zip(begin, end, strict=True)))
        tau = (t[i:j, None] - t[i] + looks[i:j])[..., None]
        values = (evaluate(derivative(quintic, order)[:, :, None], tau) for order in range(4))
        near = (np.abs(next(values) - at[i:j]) <= far for at, far in zip(exact, allowed, strict=True))
        return quintic if all(map(np.all, near)) and (np.abs(next(values)) <= jerk).all() else None

    first, pieces = [0], list[Array]()
    while (i := first[-1]) < len(steps):
        j, step = i, 1
        while fitted(i, j + step) is not None:
            j, step = j + step, 2 * step
        while step := step // 2:
            j += step if fitted(i, j + step) is not None else 0
        quintic = fitted(i, j) if j > i else None
        pieces.append(c[:, i : i + 1] if quintic is None else quintic)
        first.append(max(j, i + 1))
    return replace(trajectory, breakpoints=t[first], coefficients=side_by_side(pieces))


def _fit(planned: Trajectory, fitted: Trajectory) -> str:
    """Tell how far the refitted motion is off, and how its greatest rates compare with the planned ones."""
    t = (planned.breakpoints[:-1, None] + np.diff(planned.breakpoints)[:, None] * np.linspace(0.0, 1.0, 8)).ravel()
    off = float(np.abs(planned(t) - fitted(t)).max())
    shares = []
    for order in (1, 2, 3):
        peak, greatest = planned.peak(order), fitted.peak(order)
        shares.append(np.divide(greatest, peak, out=np.ones_like(peak), where=peak > 0.0).max())
    return (
        f"\n * It is fitted to {len(planned.breakpoints) - 1} planned pieces, and off by at most {off:.1e} rad or m.\n"
        " * The greatest velocities, accelerations and jerks are at most {:.4f}, {:.4f} and {:.4f} of the planned ones."
    ).format(*shares)


def _numbers(values: Array) -> str:
    return ", ".join(map(c_number, values))


def _labels(trajectory: Trajectory, name: str) -> str:
    if not trajectory.labels:
        return ""
    rows = ",\n    ".join(f"{{{c_number(time)}, {c_string(text)}}}" for time, text in trajectory.labels)
    return filled(FOLDER / "labels.h.in", name=name, count=len(trajectory.labels), rows=rows)


def _counted(trajectory: Trajectory, motors: Actuators) -> Trajectory:
    """Return the motion of the motors in what their drives count."""
    moved, scale = trajectory.to_motors(motors), motors.counts_per_unit
    waypoints, coefficients = moved.waypoints * scale, moved.coefficients * scale
    return replace(moved, units=motors.units, waypoints=waypoints, coefficients=coefficients)
