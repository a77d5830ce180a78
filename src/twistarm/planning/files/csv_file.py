"""CSV of a motion, written and read: joints, motors and labels."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from ...arm.arm import Arm
from ...limits.actuators import Actuators
from ...support.checks import Array
from ...support.csv_lines import Bounds, csv_lines, csv_rows
from ...support.csv_lines import csv_text as lines_of
from ...support.errors import InputError, closest, listed
from ..trajectory import Points, Trajectory, Writing, motor_values, motors_of, require_joint_of, require_motors

TIME = "time [s]"
LABEL = "label"

JOINTS = {"position": "", "velocity": "/s", "acceleration": "/s^2"}
MOTORS = {"motor_position": "", "motor_velocity": "/s"}
# Rates and what follows their unit. The names are ASCII because spreadsheets guess at anything else.
COUNTS = {"counts": "", "counts_rate": "/s"}
SAME_INSTANT = 1e-3  # A row nearer to a label than this part of `dt` is the same instant.
BOUNDS = Bounds(bytes=200_000_000, lines=500_000)  # 83 minutes at 100 Hz.
MOST_NUMBERS = 15_000_000  # The most numbers kept of one file: times, positions, rates and accelerations.


def csv_text(trajectory: Trajectory, how: Writing) -> str:
    """Return the text that `save_trajectory` writes."""
    t = _instants(trajectory, how.dt)
    tables = list(_tables(trajectory, t, motors_of(trajectory, how.actuators), how.counts))
    header = [TIME, *(name for groups, _ in tables for names in zip(*groups, strict=True) for name in names)]
    values = [np.stack(rates, axis=-1).reshape(len(t), -1) for _, rates in tables]
    labels = _label_columns(trajectory, t)
    rows = [
        row + [column.get(i, "") for column in labels] for i, row in enumerate(np.column_stack([t, *values]).tolist())
    ]
    return lines_of(header + [LABEL] * len(labels), rows)


def _tables(
    trajectory: Trajectory, t: Array, motors: Actuators | None, counts: bool
) -> Iterator[tuple[list[list[str]], list[Array]]]:
    """Yield column names and values: positions and rates of the joints, then of the motors."""
    if counts:
        motors = require_motors(motors)
    else:
        names = _columns(JOINTS, trajectory.joint_names, trajectory.units)
        yield names, [trajectory(t, order) for order in range(len(names))]
    if motors is not None:
        names, first = _columns(COUNTS, motors.names, motors.units), 2 if counts else 0
        names = names if counts else [*_columns(MOTORS, motors.names, motors.motor_units), *names]
        yield names, motor_values(trajectory, motors, t)[first:]


def _columns(rates: Mapping[str, str], names: Sequence[str], units: Sequence[str]) -> list[list[str]]:
    """Return the column names: first every position, then every velocity, and so on."""
    return [
        [f"{name}.{rate} [{unit}{per}]" for name, unit in zip(names, units, strict=True)] for rate, per in rates.items()
    ]


def _instants(trajectory: Trajectory, dt: float) -> Array:
    """Return the times of the rows: every `dt` and the end. A label's time replaces a row at the same instant."""
    t, same = trajectory.sample(dt).t, SAME_INSTANT * dt
    labelled = np.unique([0.0, *(time for time, _ in trajectory.labels if trajectory.duration - time > same)])
    labelled = labelled[np.diff(labelled, prepend=-np.inf) > same]
    others = np.abs(t[1:-1, None] - labelled).min(axis=1, initial=np.inf) > same
    return np.unique(np.concatenate([t[1:-1][others], labelled, t[-1:]]))


def _label_columns(trajectory: Trajectory, t: Array) -> list[dict[int, str]]:
    """Return the labels by row, in as many columns as one instant has labels."""
    columns: list[dict[int, str]] = []
    for time, text in trajectory.labels:
        row = int(np.abs(t - time).argmin())
        free = next((column for column in columns if row not in column), None)
        if free is None:
            columns.append(free := {})
        free[row] = text
    return columns


def read_csv(arm: Arm, path: Path) -> Points:
    """Read the points of `arm` from a CSV file. Raises InputError, with the line."""
    file = str(path)
    rows = csv_rows(csv_lines(path, BOUNDS), file)
    header = [cell.strip() for row in islice(rows, 1) for cell in row.cells]
    groups, counted = _groups(arm, header, file)
    places = [header.index(name) for name in (TIME, *(name for group in groups for name in group))]
    labelled = [k for k, name in enumerate(header) if name == LABEL]
    lines, values, labels = array("q"), array("d"), list[tuple[float, str]]()
    for row in rows:
        values.extend(numbers := row.numbers(places, len(header), file))
        lines.append(row.line)
        labels.extend((numbers[0], row.cells[k]) for k in labelled if row.cells[k])
        if len(values) > MOST_NUMBERS:
            raise InputError(f"{file} has more than {MOST_NUMBERS:,} numbers; split it, or record at a lower rate")
    table = np.frombuffer(values).reshape(len(lines), len(places))
    ends = np.cumsum([1, *map(len, groups)]).tolist()
    states = [table[:, start:end] for start, end in pairwise(ends)]
    if counted and arm.actuators is not None:
        motor, motor_dot = map(arm.actuators.from_counts, states)
        states = [arm.actuators.to_theta(motor), arm.actuators.velocity_to_theta(motor_dot)]
    return Points(table[:, 0], labels, lambda k: f"{file}, line {lines[k]}", *states)


def _groups(arm: Arm, header: list[str], file: str) -> tuple[list[list[str]], bool]:
    """Return the columns of positions, rates and any accelerations. Tell whether they are a drive's counts.

    Raises InputError unless the joints' or the motors' columns are all present, each once.
    """
    *needed, accelerations = _columns(JOINTS, arm.joint_names, arm.units)
    motors = arm.actuators
    if motors is not None and not _has_columns(needed, header):
        counts = _columns(COUNTS, motors.names, motors.units)
        if _has_columns(counts, header):
            return counts, True
    require_joint_of(arm, [column.partition(".position")[0] for column in header if ".position [" in column], file)
    for name in (TIME, *needed[0], *needed[1]):
        if header.count(name) != 1:
            others = [column for column in header if column not in (*needed[0], *needed[1])]
            what = f"twice: {listed([name])}" if name in header else f"no {listed([name])}{closest(name, others)}"
            raise InputError(f"{file}, line 1: it has {what}; a motion of {arm.name} has each column once")
    return [*needed, accelerations] if _has_columns([accelerations], header) else needed, False


def _has_columns(groups: list[list[str]], header: list[str]) -> bool:
    return all(header.count(name) == 1 for group in groups for name in group)
