"""A trajectory as a C99 and C++17 header: a table and functions that evaluate it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from ...limits.actuators import Actuators
from ...support.checks import Array
from ...support.code_text import c_number, c_string, c_strings, filled, identifier_of
from ..piecewise import derivative, rescaled
from ..trajectory import Trajectory, motors_of, require_motors

FOLDER = Path(__file__).parent

NOTHING = 1e-15
"""Share of the greatest position, velocity or acceleration that is rounding."""


def header_text(trajectory: Trajectory, file: str, actuators: Actuators | None, counts: bool) -> str:
    """Return the text that `save_trajectory` writes. Every name in it begins with that of the file."""
    name = identifier_of(Path(file).stem, "motion")
    if counts:
        trajectory = _counted(trajectory, require_motors(motors_of(trajectory, actuators)))
    pieces = _pieces(trajectory)
    begins = np.concatenate([[0], np.cumsum([piece.size for piece in pieces])])
    numbers = int(begins[-1]) + len(pieces)
    columns = zip(trajectory.joint_names, trajectory.units, strict=True)
    return filled(
        FOLDER / "motion.h.in",
        name=name,
        file=c_string(Path(file).name),
        guard=f"TWISTARM_MOTION_{name.upper()}_H",
        order=", ".join(f"{c_string(joint)} [{unit}]" for joint, unit in columns),
        n=trajectory.n,
        pieces=len(pieces),
        kilobytes=f"{(8 * numbers + 4 * len(begins)) / 1e3:.3g}",
        half=f"{(4 * numbers + 4 * len(begins)) / 1e3:.3g}",
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
