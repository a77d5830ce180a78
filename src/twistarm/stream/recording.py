"""A recorded motion: the CSV that `Trajectory.to_csv` and `twistarm plan -o` write, read strictly."""

from __future__ import annotations

import csv
import os
from array import array
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from ..model.arm import Arm
from ..support.checks import Array, as_floats, frozen
from ..support.csv_lines import Bounds, csv_lines, name_in
from ..support.display import Brief
from ..support.errors import InputError, LimitError, closest, listed
from ..support.files import as_path

TIME = "time [s]"

BOUNDS = Bounds(bytes=200_000_000, lines=500_000)
"""83 minutes at 100 Hz."""

MOST_NUMBERS = 10_000_000
"""That are kept of a recording: the time, and of each joint position and velocity, of every line."""

BEYOND_LIMIT = 1e-6
"""Beyond a position limit by less [rad, m] is rounding of the file."""


@dataclass(frozen=True, eq=False, repr=False)
class Recording(Brief):
    """theta (k, n) and theta_dot (k, n) at the times t (k,) [s], which increase from 0, at least two of them."""

    t: Array
    theta: Array
    theta_dot: Array

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.t[-1])

    def __call__(self, time: float) -> Array:
        """theta (n,) at `time` [s]: the cubic of each interval with the recorded positions and rates at its ends
        (Hermite), the ends held outside.
        """
        k = int(np.clip(np.searchsorted(self.t, time, side="right") - 1, 0, len(self.t) - 2))
        h = self.t[k + 1] - self.t[k]
        s = min(max((time - self.t[k]) / h, 0.0), 1.0)
        a, b = self.theta[k], self.theta[k + 1]
        value: Array = (
            (1 + 2 * s) * (1 - s) ** 2 * a
            + s**2 * (3 - 2 * s) * b
            + h * s * (1 - s) * ((1 - s) * self.theta_dot[k] - s * self.theta_dot[k + 1])
        )
        return value


def read_recording(arm: Arm, path: str | os.PathLike[str]) -> Recording:
    """The motion of `arm` in a CSV file.

    Columns: `time [s]`, and of each joint `<joint>.position [rad]` and `<joint>.velocity [rad/s]` (m, m/s for slides),
    in any order; others are passed over.

    Args:
        arm: The arm.
        path: The CSV file.

    Returns:
        The `Recording`.

    Raises:
        InputError: A value is not a finite number, or a time does not increase; the message gives the line.
        LimitError: A position lies outside the arm's limits.
    """
    file = as_path(path)
    try:
        return _recording(arm, csv.reader(csv_lines(file, BOUNDS)), str(file))
    except csv.Error as error:
        raise InputError(f"{file} is no CSV text: {error}") from error


def _recording(arm: Arm, reader: Iterable[list[str]], file: str) -> Recording:
    rows = iter(reader)
    header = list(map(name_in, next(rows, [])))
    columns = _columns(arm, header, file)
    lines, values = array("q"), array("d")
    for line, row in enumerate(rows, 2):
        if row:
            lines.append(line)
            values.extend(_numbers(row, header, columns, f"{file}, line {line}"))
        if len(values) > MOST_NUMBERS:
            raise InputError(f"{file} has more than {MOST_NUMBERS:,} numbers; split it, or record at a lower rate")
    if len(lines) < 2:
        raise InputError(f"{file}: a recording needs two lines of numbers at least; got {len(lines)}")
    table = np.frombuffer(values).reshape(len(lines), len(columns))
    t = table[:, 0] - table[0, 0]
    if not (np.diff(t) > 0.0).all():
        k = int(np.argmin(np.diff(t) > 0.0)) + 1
        raise InputError(f"{file}, line {lines[k]}: time must increase; got {table[k, 0]:g} after {table[k - 1, 0]:g}")
    theta = table[:, 1 : 1 + arm.n]
    _require_within(arm, theta, lines, file)
    return Recording(frozen(t), frozen(theta), frozen(table[:, 1 + arm.n :]))


def _columns(arm: Arm, header: list[str], file: str) -> list[int]:
    """Where time, the n positions and the n velocities stand."""
    joints = list(zip(arm.joint_names, arm.units, strict=True))
    wanted = [
        TIME,
        *(f"{name}.position [{unit}]" for name, unit in joints),
        *(f"{name}.velocity [{unit}/s]" for name, unit in joints),
    ]
    for name in wanted:
        if header.count(name) != 1:
            what = "twice" if name in header else f"not{closest(name, header)}"
            raise InputError(f"{file}, line 1: a recording of {arm.name} has {listed([name])} once; here it is {what}")
    return [header.index(name) for name in wanted]


def _numbers(row: list[str], header: list[str], columns: list[int], place: str) -> list[float]:
    if len(row) != len(header):
        raise InputError(f"{place}: {len(header)} numbers are needed, as in the header; got {len(row)}")
    try:
        values = [float(row[k]) for k in columns]
        if not all(map(isfinite, values)):
            as_floats(values, "every number")
    except ValueError as error:  # InputError is one
        raise InputError(f"{place}: {error}") from error
    return values


def _require_within(arm: Arm, theta: Array, lines: Sequence[int], file: str) -> None:
    beyond = np.maximum(arm.limits.lower - theta, theta - arm.limits.upper)
    k, j = (int(index) for index in np.unravel_index(np.argmax(beyond), beyond.shape))
    if beyond[k, j] > BEYOND_LIMIT:
        raise LimitError(
            f"{file}, line {lines[k]}: joint {arm.joint_names[j]!r} at {theta[k, j]:g} {arm.units[j]} is "
            f"{beyond[k, j]:.3g} {arm.units[j]} beyond its limit; record a motion within the limits"
        )
