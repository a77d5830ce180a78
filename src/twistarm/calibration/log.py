"""The log of a wiring check: counts of each drive with the measured tool."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array, as_floats, as_pose, frozen, require
from ..support.csv_lines import Bounds, csv_lines, csv_rows
from ..support.display import Brief
from ..support.errors import InputError, closest, listed
from ..support.files import as_path
from ..theory.rotations import from_xyzw

BOUNDS = Bounds(bytes=10_000_000, lines=100_000)
"""A row has some 150 bytes; a camera's half hour at 30 Hz is 8 MB."""

POSITION, ROTATION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")

UNIT_LENGTH_TOL = 0.01
"""A logged quaternion is rounded to a few digits; one that is further from length 1 holds something else."""


@dataclass(frozen=True, eq=False, repr=False)
class WiringLog(Brief):
    """K moments: `counts` (K, k) of the drives `names`, `measured` of the tool in base coordinates.

    `measured` (K, 3) are positions of the tool's origin [m], or (K, 4, 4) poses. Raises InputError for anything else.
    """

    names: tuple[str, ...]
    counts: Array
    measured: Array

    def __post_init__(self) -> None:
        counts, measured = as_floats(self.counts, "counts"), as_floats(self.measured, "measured")
        if counts.ndim != 2 or counts.shape[1] != len(self.names):
            raise InputError(
                f"counts of {len(self.names)} motors must have shape (K, {len(self.names)}); got {counts.shape}"
            )
        if len(set(self.names)) != len(self.names):
            raise InputError(f"a motor is named twice in {list(self.names)}")
        K = len(counts)
        if measured.shape not in ((K, 3), (K, 4, 4)):
            raise InputError(f"measured must be {K} positions ({K}, 3) or poses ({K}, 4, 4); got {measured.shape}")
        object.__setattr__(self, "counts", frozen(counts))
        object.__setattr__(self, "measured", frozen(measured if measured.ndim == 2 else as_pose(measured, "measured")))

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    def of(self, motors: Actuators) -> Array:
        """The counts (K, k) in the order of `motors`. Raises InputError for a missing or unknown motor."""
        for name in self.names:
            if name not in motors.names:
                raise InputError(
                    f"the log has a motor {name!r}; the arm's are {listed(motors.names)}{closest(name, motors.names)}"
                )
        missing = [name for name in motors.names if name not in self.names]
        if missing:
            raise InputError(f"the log has no counts of motor {listed(missing)}: log every motor")
        return self.counts[:, [self.names.index(name) for name in motors.names]]


def read_log(path: str | os.PathLike[str], motors: Actuators) -> WiringLog:
    """Read a log from CSV: a column per motor, x, y, z [m], and optionally qx, qy, qz, qw.

    The first line names the columns, in any order. A unit may follow in brackets, as in `left [tick]`. It must be the
    unit that the motor's drive counts in. A line that begins with # is a comment. Raises InputError with the line
    number for an invalid, missing or surplus value.
    """
    file = as_path(path)
    require(motors, Actuators, "motors", "as arm.actuators is")
    rows = list(csv_rows(csv_lines(file, BOUNDS), str(file)))
    if not rows:
        raise InputError(f"{file}: no line but comments; the first names the columns: {_wanted(motors)}")
    header, *rest = rows
    names = _columns([cell.strip() for cell in header.cells], motors, f"{file}, line {header.line}")
    every = range(len(names))
    values = np.array([row.numbers(every, len(names), str(file)) for row in rest]).reshape(-1, len(names))
    column = {name: values[:, i] for i, name in enumerate(names)}
    counts = np.stack([column[name] for name in motors.names], axis=-1)
    position = np.stack([column[name] for name in POSITION], axis=-1)
    if ROTATION[0] not in column:
        return WiringLog(motors.names, counts, position)
    quaternions = np.stack([column[name] for name in ROTATION], axis=-1)
    for row, length in zip(rest, np.linalg.norm(quaternions, axis=-1), strict=True):
        if abs(length - 1.0) > UNIT_LENGTH_TOL:
            raise InputError(f"{file}, line {row.line}: qx qy qz qw must be of length 1; got {length:.3g}")
    return WiringLog(motors.names, counts, _poses(position, quaternions))


def _poses(position: Array, quaternions: Array) -> Array:
    g = np.tile(np.eye(4), (len(position), 1, 1))
    g[:, :3, :3], g[:, :3, 3] = from_xyzw(quaternions), position
    return g


def _columns(header: Sequence[str], motors: Actuators, place: str) -> tuple[str, ...]:
    """The column names with checked units: motors, x, y, z, and optionally the whole quaternion."""
    units = (
        dict(zip(motors.names, motors.units, strict=True)) | dict.fromkeys(POSITION, "m") | dict.fromkeys(ROTATION, "1")
    )
    names = []
    for cell in header:
        name, bracket, unit = (part.strip() for part in cell.partition("["))
        if name not in units:
            raise InputError(f"{place}: unknown column {name!r}{closest(name, units)}; {_wanted(motors)}")
        if bracket and unit != f"{units[name]}]":
            raise InputError(f"{place}: column {name!r} is in [{units[name]}]; got [{unit}")
        if name in names:
            raise InputError(f"{place}: column {name!r} stands there twice")
        names.append(name)
    turned = [name for name in ROTATION if name in names]
    missing = [name for name in (*motors.names, *POSITION, *(ROTATION if turned else ())) if name not in names]
    if missing:
        raise InputError(f"{place}: no column {listed(missing)}; {_wanted(motors)}")
    return tuple(names)


def _wanted(motors: Actuators) -> str:
    return f"the columns are {', '.join((*motors.names, *POSITION))}, and qx, qy, qz, qw where they were measured"
