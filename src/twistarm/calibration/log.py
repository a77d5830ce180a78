"""The log of a wiring check: counts of each drive with the measured tool."""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array, as_floats, as_pose, frozen, require
from ..support.display import Brief
from ..support.errors import InputError, closest, listed
from .columns import POSITION, ROTATION, read_columns


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
    require(motors, Actuators, "motors", "as arm.actuators is")
    names = dict(zip(motors.names, motors.units, strict=True)) | dict.fromkeys(POSITION, "m")
    units = {name: {unit: 1.0} for name, unit in (names | dict.fromkeys(ROTATION, "1")).items()}
    columns = read_columns(path, units, tuple(names))
    counts, measured = columns.numbers(motors.names), columns.numbers(POSITION)
    if any(name in columns for name in ROTATION):
        columns.numbers(ROTATION)
        g = np.tile(np.eye(4), (len(measured), 1, 1))
        g[:, :3, :3], g[:, :3, 3] = columns.rotations(), measured
        measured = g
    return WiringLog(motors.names, counts, measured)
