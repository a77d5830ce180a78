"""What was measured for a calibration: positions, poses, tags in a camera, resting points, planes and wires."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm, require_arm
from ..limits.actuators import Actuators
from ..support.checks import Array, as_flag, as_reals, frozen, require_names
from ..support.csv_lines import Bounds, csv_lines, csv_rows, known_columns
from ..support.display import Brief
from ..support.errors import InputError, closest, listed
from ..support.files import as_path
from ..support.units import UNITS
from ..theory.rotations import from_xyzw

Bools = NDArray[np.bool_]
Rows = NDArray[np.intp]

# A row has some 150 bytes; a camera's half hour at 30 Hz is 8 MB.
BOUNDS = Bounds(bytes=10_000_000, lines=100_000)

POSITION, ROTATION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")
RVEC, TVEC = ("rx", "ry", "rz"), ("tx", "ty", "tz")

# A logged quaternion is rounded to a few digits; one that is further from length 1 holds something else.
UNIT_LENGTH_TOL = 0.01
LITTLE = {"rad": float(np.radians(15.0)), "m": 0.05}  # A joint that moved by less has hardly moved.

NUMBERS = {"position": (3,), "rotation": (3, 3), "rvec": (3,), "tvec": (3,), "length": (), "noise": ()}
NAMES = ("point", "plane", "wire")


@dataclass(frozen=True, eq=False, repr=False)
class Measurements(Brief):
    """K rows: commanded `theta` (K, n) [rad, m], and what was measured of the tool's origin at each.

    For `check_wiring`, `theta` (K, k) are the counts of the arm's k motors, each in its drive's unit.

    `position` (K, 3) [m] and `rotation` (K, 3, 3) are seen from the measuring device. A row of NaN: not measured.
    `rvec` (K, 3) [rad] and `tvec` (K, 3) [m] are what OpenCV's solvePnP returns: rotation vector and position of a tag
    in the camera's frame.

    `point`, `plane` and `wire` (K,) name a point that the tool rested on, a plane that it touched, or the anchor of a
    wire of `length` (K,) [m]; "": none. Their places are unknown. `noise` (K,) [m] is the standard deviation of each
    row; NaN: the default of `calibrate`. `label` (K,) names the rows in messages. Raises InputError for other shapes,
    or a row without a measurement.
    """

    theta: Array
    position: Array = field(default_factory=partial(np.empty, 0))
    rotation: Array = field(default_factory=partial(np.empty, 0))
    rvec: Array = field(default_factory=partial(np.empty, 0))
    tvec: Array = field(default_factory=partial(np.empty, 0))
    point: Sequence[str] = field(default=(), repr=False)
    plane: Sequence[str] = field(default=(), repr=False)
    wire: Sequence[str] = field(default=(), repr=False)
    length: Array = field(default_factory=partial(np.empty, 0))
    noise: Array = field(default_factory=partial(np.empty, 0))
    label: Sequence[str] = field(default=(), repr=False)

    def __post_init__(self) -> None:
        theta = as_reals(self.theta, "theta")
        if theta.ndim != 2 or not np.isfinite(theta).all():
            raise InputError(f"theta must be finite numbers (K, n); got shape {theta.shape}")
        K = len(theta)
        object.__setattr__(self, "theta", frozen(theta))
        for name, shape in NUMBERS.items():
            values = as_reals(getattr(self, name), name)
            values = values if values.size else np.full((K, *shape), np.nan)
            if values.shape != (K, *shape):
                raise InputError(f"{name} must have shape {(K, *shape)}, a row for each of theta; got {values.shape}")
            object.__setattr__(self, name, frozen(values))
        for name in (*NAMES, "label"):
            names = require_names(getattr(self, name), name)
            names = names or tuple(f"row {k + 1}" if name == "label" else "" for k in range(K))
            if len(names) != K:
                raise InputError(f"{name} must hold {K} names, one for each row; got {len(names)}")
            object.__setattr__(self, name, names)
        kinds = np.stack([self.located, self.sighted, *(np.array(getattr(self, name), dtype=bool) for name in NAMES)])
        unmeasured = kinds[-1] & ~np.isfinite(self.length)
        for odd, why in (
            (unmeasured, "has a wire and needs its length"),
            (kinds.sum(axis=0) != 1, f"must hold one measurement: xyz, rvec and tvec, or {', '.join(NAMES)}"),
        ):
            if odd.any():
                raise InputError(f"{self.label[int(odd.argmax())]} {why}")

    @property
    def located(self) -> Bools:
        """Whether each row holds a position (K,)."""
        return np.asarray(np.isfinite(self.position).all(axis=1))

    @property
    def sighted(self) -> Bools:
        """Whether each row holds a tag in a camera (K,)."""
        return np.asarray(np.isfinite(np.concatenate([self.rvec, self.tvec], axis=1)).all(axis=1))

    @property
    def place(self) -> list[tuple[str, str]]:
        """The kind and the name of each row's place; ("", "") for a position."""
        rows = zip(*(getattr(self, kind) for kind in NAMES), strict=True)
        return [next(((kind, name) for kind, name in zip(NAMES, row, strict=True) if name), ("", "")) for row in rows]

    def of_rows(self, rows: Rows) -> Measurements:
        """Only these rows."""
        return _made({name: np.asarray(getattr(self, name))[rows] for name in COLUMNS})


COLUMNS = ("theta", *NUMBERS, *NAMES, "label")


def _made(columns: dict[str, Array]) -> Measurements:
    parts: dict[str, Any] = columns | {name: columns[name].tolist() for name in (*NAMES, "label")}
    return Measurements(**parts)


def read_measurements(path: str | os.PathLike[str], arm: Arm, *, counts: bool = False) -> Measurements:
    """Read measurements from CSV. The first line names the columns, in any order.

    The joints' names [rad, m], or with `counts` those of the motors, in each drive's own unit; x, y, z and qx, qy, qz,
    qw; rx, ry, rz and tx, ty, tz, the rvec [rad] and tvec [m] of solvePnP; point, plane, wire and length; noise. A unit
    may follow in brackets, as `elbow [deg]` or `x [mm]`. An empty cell is not measured. Lines with # are comments.
    Raises InputError with the line for an unknown, missing or invalid column or cell.
    """
    quantities = dict(zip(require_arm(arm).joint_names, arm.units, strict=True))
    if as_flag(counts, "counts"):
        motors = require_motors(arm)
        quantities = dict(zip(motors.names, motors.units, strict=True))
    commanded = tuple(quantities)
    quantities |= dict.fromkeys((*POSITION, "length", "noise"), "m") | dict.fromkeys((*ROTATION, *NAMES), "1")
    quantities |= dict.fromkeys(RVEC, "rad") | dict.fromkeys(TVEC, "m")
    file = as_path(path)
    rows = list(csv_rows(csv_lines(file, BOUNDS), str(file)))
    if len(rows) < 2:
        raise InputError(f"{file}: no rows; the first line names the columns, {', '.join(commanded)} among them")
    header = rows.pop(0)
    place = f"{file}, line {header.line}"
    at, others = known_columns(header.cells, {name: name for name in quantities}, quantities, place)
    more = ", ".join(name for name in quantities if name not in commanded)
    for given in (head.partition("[")[0].strip() for head in others):
        allowed = f"the columns are {', '.join(commanded)}; these may follow: {more}"
        raise InputError(f"{place}: unknown column {given!r}{closest(given, quantities)}; {allowed}")
    if missing := [name for name in commanded if name not in at]:
        raise InputError(f"{place}: no column {listed(missing)}; these may follow: {more}")

    def numbers(names: Sequence[str], *, empty: bool = True) -> Array:
        """The columns (K, len(names)) in SI units; with `empty`, NaN for rows where all their cells are empty."""
        if not set(names) <= at.keys():
            raise InputError(f"{file}: the columns {', '.join(names)} belong together; give all of them, or none")
        columns, factors = zip(*(at[name] for name in names), strict=True)
        values = np.full((len(rows), len(names)), np.nan)
        for k, row in enumerate(rows):
            if not empty or len(row.cells) != len(at) or any(row.cells[i].strip() for i in columns):
                values[k] = row.numbers(columns, len(at), str(file))
        return np.asarray(values * factors)

    theta = numbers(commanded, empty=False)
    parts: dict[str, Any] = {name: [row.cells[at[name][0]].strip() for row in rows] for name in NAMES if name in at}
    parts |= {name: numbers([name])[:, 0] for name in ("length", "noise") if name in at}
    if at.keys() & set(POSITION):
        parts["position"] = numbers(POSITION)
    if at.keys() & {*RVEC, *TVEC}:
        parts["rvec"], parts["tvec"] = np.split(numbers((*RVEC, *TVEC)), 2, axis=1)
    if at.keys() & set(ROTATION):
        quaternions = numbers(ROTATION)
        lengths, parts["rotation"] = np.linalg.norm(quaternions, axis=1), np.full((len(rows), 3, 3), np.nan)
        if (odd := np.abs(lengths - 1.0) > UNIT_LENGTH_TOL).any():
            k = int(odd.argmax())
            raise InputError(f"{file}, line {rows[k].line}: qx qy qz qw must be of length 1; got {lengths[k]:.3g}")
        some = np.isfinite(lengths)
        parts["rotation"][some] = from_xyzw(quaternions[some])
    return Measurements(theta, **parts, label=[f"{file.name}:{row.line}" for row in rows])


def require_metres(log: Measurements, arm: Arm) -> None:
    """InputError for positions farther apart than the arm reaches many times over, with the likely unit."""
    spread = float(np.ptp(log.position[log.located], axis=0).max()) if log.located.any() else 0.0
    if spread > 20.0 * arm.reach:
        unit = min(UNITS["m"], key=lambda unit: abs(np.log(spread * UNITS["m"][unit] / arm.reach)))
        raise InputError(
            f"the positions lie {spread:.4g} m apart, and the arm reaches {arm.reach:.3g} m: are they in {unit}? "
            f"Name the unit in the header, as in x [{unit}]"
        )


def require_motors(arm: Arm) -> Actuators:
    """The arm's motors, or InputError without any."""
    motors = require_arm(arm).actuators
    if motors is None:
        raise InputError(f"{arm.name} has no actuators: describe its motors as [actuators.NAME] in its arm.toml")
    return motors


def joined(parts: Sequence[Measurements]) -> Measurements:
    """The rows of several measurements; a place of the same name is the same place."""
    return _made({name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS})
