"""A trajectory, its motors and labels too, as CSV: for people, plots and spreadsheets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ...limits.actuators import Actuators
from ...support.checks import Array, as_flag
from ...support.csv_lines import csv_text as lines_of
from .columns import COUNTS, JOINTS, LABEL, MOTORS, TIME, columns
from .motor_values import motor_values, motors_of, require_motors

if TYPE_CHECKING:
    from ..trajectory import Trajectory

SAME_INSTANT = 1e-3
"""A row nearer to a label than this part of `dt` is the same instant."""


def csv_text(trajectory: Trajectory, dt: float, actuators: Actuators | None = None, *, counts: bool = False) -> str:
    """What `Trajectory.to_csv` writes."""
    t = _instants(trajectory, dt)
    tables = list(_tables(trajectory, t, motors_of(trajectory, actuators), as_flag(counts, "counts")))
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
    """Names and values of the columns: positions, rates and so on of the joints, then of the motors."""
    if counts:
        motors = require_motors(motors)
    else:
        names = columns(JOINTS, trajectory.joint_names, trajectory.units)
        yield names, [trajectory(t, order) for order in range(len(names))]
    if motors is not None:
        names, first = columns(COUNTS, motors.names, motors.units), 2 if counts else 0
        names = names if counts else [*columns(MOTORS, motors.names, motors.motor_units), *names]
        yield names, motor_values(trajectory, motors, t)[first:]


def _instants(trajectory: Trajectory, dt: float) -> Array:
    """The times of the rows: 0, every `dt`, the end; and those of labels, in place of rows at the same instant."""
    t, same = trajectory.sample(dt).t, SAME_INSTANT * dt
    labelled = [0.0]
    for time, _ in trajectory.labels:
        if time - labelled[-1] > same and trajectory.duration - time > same:
            labelled.append(time)
    others = np.abs(t[1:-1, None] - labelled).min(axis=1, initial=np.inf) > same
    return np.unique(np.concatenate([t[1:-1][others], labelled, t[-1:]]))


def _label_columns(trajectory: Trajectory, t: Array) -> list[dict[int, str]]:
    """The labels by row: one column, or as many as there are labels at one instant."""
    columns: list[dict[int, str]] = []
    for time, text in trajectory.labels:
        row = int(np.abs(t - time).argmin())
        free = next((column for column in columns if row not in column), None)
        if free is None:
            columns.append(free := {})
        free[row] = text
    return columns
