"""The points of a motion read from CSV, line by line and within bounds."""

from __future__ import annotations

from array import array
from itertools import islice, pairwise
from pathlib import Path

import numpy as np

from ...arm.arm import Arm
from ...support.csv_lines import Bounds, csv_lines, csv_rows, name_in
from ...support.errors import InputError, closest, listed
from .columns import COUNTS, JOINTS, LABEL, TIME, columns
from .points import Points

BOUNDS = Bounds(bytes=200_000_000, lines=500_000)
"""83 minutes at 100 Hz."""

MOST_NUMBERS = 15_000_000
"""That are kept of a file: of every line the time, positions, rates and accelerations."""


def read_csv(arm: Arm, path: Path) -> Points:
    """The points of `arm` in a CSV file. Raises InputError, with the line."""
    file = str(path)
    rows = csv_rows(csv_lines(path, BOUNDS), file)
    header = [name_in(cell.strip()) for row in islice(rows, 1) for cell in row.cells]
    groups, counted = _groups(arm, header, file)
    places = [header.index(name) for name in (TIME, *(name for group in groups for name in group))]
    labelled = [k for k, name in enumerate(header) if name == LABEL]
    lines, values, labels = array("q"), array("d"), list[tuple[float, str]]()
    for row in rows:
        values.extend(numbers := row.numbers(places, len(header), file))
        lines.append(row.line)
        labels.extend((numbers[0], name_in(row.cells[k])) for k in labelled if row.cells[k])
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
    """The columns of positions, rates and, where there are such, accelerations; and whether they are a drive's counts.

    InputError where neither the joints' nor the motors' are all there, each once.
    """
    *needed, accelerations = columns(JOINTS, arm.joint_names, arm.units)
    motors = arm.actuators
    if motors is not None and not _is_there(needed, header):
        counts = columns(COUNTS, motors.names, motors.units)
        if _is_there(counts, header):
            return counts, True
    for name in (TIME, *needed[0], *needed[1]):
        if header.count(name) != 1:
            others = [each for each in header if each not in (*needed[0], *needed[1])]
            what = "twice" if name in header else f"not{closest(name, others)}"
            raise InputError(f"{file}, line 1: a motion of {arm.name} has {listed([name])} once; here it is {what}")
    return [*needed, accelerations] if _is_there([accelerations], header) else needed, False


def _is_there(groups: list[list[str]], header: list[str]) -> bool:
    return all(header.count(name) == 1 for group in groups for name in group)
