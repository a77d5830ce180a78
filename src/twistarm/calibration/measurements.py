"""What was measured for a calibration: positions, poses, resting points, planes and wires."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..support.checks import Array, as_reals, frozen, require_names
from ..support.csv_lines import Row, csv_lines, csv_rows
from ..support.display import Brief
from ..support.errors import InputError, closest, listed
from ..support.files import as_path
from ..theory.rotations import from_xyzw
from .log import BOUNDS, POSITION, ROTATION, UNIT_LENGTH_TOL

Bools = NDArray[np.bool_]
Rows = NDArray[np.intp]

NAMES = ("point", "plane", "wire")
UNITS = {"rad": {"rad": 1.0, "deg": np.pi / 180}, "m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}, "1": {}}


@dataclass(frozen=True, eq=False, repr=False)
class Measurements(Brief):
    """K rows: commanded `theta` (K, n) [rad, m], and what was measured of the tool's origin at each.

    `position` (K, 3) [m] and `rotation` (K, 3, 3) are seen from the measuring device. A row of NaN: not measured.
    `point`, `plane` and `wire` (K,) name a point that the tool rested on, a plane that it touched, or the anchor of a
    wire of `length` (K,) [m]; "": none. Their places are unknown. `noise` (K,) [m] is the standard deviation of each
    row; NaN: the default of `calibrate`. Raises InputError for other shapes, or a row without a measurement.
    """

    theta: Array
    position: Array | None = None
    rotation: Array | None = None
    point: Sequence[str] = ()
    plane: Sequence[str] = ()
    wire: Sequence[str] = ()
    length: Array | None = None
    noise: Array | None = None

    def __post_init__(self) -> None:
        theta = as_reals(self.theta, "theta")
        if theta.ndim != 2 or not np.isfinite(theta).all():
            raise InputError(f"theta must be finite numbers (K, n); got shape {theta.shape}")
        K = len(theta)
        object.__setattr__(self, "theta", frozen(theta))
        for name, shape in (("position", (K, 3)), ("rotation", (K, 3, 3)), ("length", (K,)), ("noise", (K,))):
            value = getattr(self, name)
            array = np.full(shape, np.nan) if value is None else as_reals(value, name)
            if array.shape != shape:
                raise InputError(f"{name} must have shape {shape}, a row for each of theta; got {array.shape}")
            object.__setattr__(self, name, frozen(array))
        for name in NAMES:
            names = require_names(getattr(self, name), name) or ("",) * K
            if len(names) != K:
                raise InputError(f"{name} must hold {K} names, one for each row; got {len(names)}")
            object.__setattr__(self, name, names)
        self._require_something()

    def _require_something(self) -> None:
        wired = np.array(self.wire, dtype=bool)
        if (wired & ~np.isfinite(self.lengths)).any():
            raise InputError(f"row {int(np.argmax(wired & ~np.isfinite(self.lengths))) + 1}: a wire needs its length")
        kinds = np.stack([self.located, *(np.array(getattr(self, name), dtype=bool) for name in NAMES)])
        odd = kinds.sum(axis=0) != 1
        if odd.any():
            row = int(odd.argmax()) + 1
            raise InputError(f"row {row} must hold one measurement: x, y, z, or one of {', '.join(NAMES)}")

    @property
    def located(self) -> Bools:
        """Whether each row holds a position (K,)."""
        return np.asarray(np.isfinite(self.positions).all(axis=1))

    @property
    def positions(self) -> Array:
        """`position`, NaN where it was not measured."""
        assert self.position is not None
        return self.position

    @property
    def rotations(self) -> Array:
        """`rotation`, NaN where it was not measured."""
        assert self.rotation is not None
        return self.rotation

    @property
    def lengths(self) -> Array:
        """`length`, NaN where there is no wire."""
        assert self.length is not None
        return self.length

    def of_rows(self, rows: Rows) -> Measurements:
        """Only these rows."""
        parts: dict[str, Any] = {name: tuple(np.array(getattr(self, name))[rows].tolist()) for name in NAMES}
        for name in ("theta", "position", "rotation", "length", "noise"):
            parts[name] = getattr(self, name)[rows]
        return Measurements(**parts)


def read_measurements(path: str | os.PathLike[str], arm: Arm) -> Measurements:
    """Read measurements from CSV. The first line names the columns, in any order.

    The joints' names [rad, m]; x, y, z and qx, qy, qz, qw; point, plane, wire and length; noise. A unit may follow in
    brackets, as `elbow [deg]` or `x [mm]`. An empty cell is not measured. Lines with # are comments. Raises InputError
    with the line for an unknown, missing or invalid column or cell.
    """
    file = as_path(path)
    rows = list(csv_rows(csv_lines(file, BOUNDS), str(file)))
    if len(rows) < 2:
        raise InputError(f"{file}: no rows; the first line names the columns: {', '.join(arm.joint_names)}, x, y, z")
    header, *rest = rows
    columns = _header(header, arm, str(file))
    missing = [name for name in arm.joint_names if name not in columns]
    if missing:
        raise InputError(f"{file}: no column of joint {listed(missing)}; every joint needs one")
    theta = _numbers(rest, columns, arm.joint_names, str(file))
    measured: dict[str, Any] = {name: [row.cells[columns[name][0]].strip() for row in rest] for name in NAMES
                                if name in columns}  # fmt: skip
    for name, parts in (("position", POSITION), ("length", ("length",)), ("noise", ("noise",))):
        if any(part in columns for part in parts):
            values = _numbers(rest, columns, parts, str(file), empty=True)
            measured[name] = values if len(parts) > 1 else values[:, 0]
    if any(part in columns for part in ROTATION):
        measured["rotation"] = _rotations(_numbers(rest, columns, ROTATION, str(file), empty=True), str(file))
    return Measurements(theta, **measured)


def _header(header: Row, arm: Arm, file: str) -> Mapping[str, tuple[int, float]]:
    """{name: (column, factor to SI)}."""
    kinds = dict.fromkeys((*POSITION, "length", "noise"), "m") | dict.fromkeys((*ROTATION, *NAMES), "1")
    kinds |= dict(zip(arm.joint_names, arm.units, strict=True))
    columns: dict[str, tuple[int, float]] = {}
    for i, cell in enumerate(header.cells):
        name, bracket, unit = (part.strip() for part in cell.partition("["))
        place = f"{file}, line {header.line}"
        if name not in kinds or name in columns:
            why = "stands there twice" if name in columns else f"is unknown{closest(name, kinds)}"
            raise InputError(f"{place}: column {name!r} {why}; the columns are {', '.join(kinds)}")
        units = UNITS[kinds[name]]
        if bracket and unit.removesuffix("]") not in units:
            raise InputError(f"{place}: column {name!r} may be in {', '.join(units) or 'no unit'}; got [{unit}")
        columns[name] = i, units[unit.removesuffix("]")] if bracket else 1.0
    return columns


def _numbers(
    rows: Sequence[Row], columns: Mapping[str, tuple[int, float]], names: Sequence[str], file: str, empty: bool = False
) -> Array:
    """The columns `names` (K, len(names)) in SI units; NaN for rows where all are empty, if they may be."""
    missing = [name for name in names if name not in columns]
    if missing:
        raise InputError(f"{file}: no column {listed(missing)}; {', '.join(names)} belong together")
    at, factors = [columns[name][0] for name in names], [columns[name][1] for name in names]
    values = np.full((len(rows), len(names)), np.nan)
    for k, row in enumerate(rows):
        blank = len(row.cells) == len(columns) and not "".join(row.cells[i].strip() for i in at)
        if not (empty and blank):
            values[k] = row.numbers(at, len(columns), file)
    scaled: Array = values * factors
    return scaled


def _rotations(quaternions: Array, file: str) -> Array:
    rotations, some = np.full((len(quaternions), 3, 3), np.nan), np.isfinite(quaternions).all(axis=1)
    off = np.abs(np.linalg.norm(quaternions[some], axis=1) - 1.0)
    if (off > UNIT_LENGTH_TOL).any():
        raise InputError(f"{file}: qx qy qz qw must be of length 1; one is off by {off.max():.3g}")
    rotations[some] = from_xyzw(quaternions[some])
    return rotations
