"""The columns of a measured log: a CSV file whose first line names them, with units in brackets."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows
from ..support.errors import InputError, closest, listed
from ..support.files import as_path
from ..support.units import column
from ..theory.rotations import from_xyzw

BOUNDS = Bounds(bytes=10_000_000, lines=100_000)
"""A row has some 150 bytes; a camera's half hour at 30 Hz is 8 MB."""

POSITION, ROTATION = ("x", "y", "z"), ("qx", "qy", "qz", "qw")

UNIT_LENGTH_TOL = 0.01
"""A logged quaternion is rounded to a few digits; one that is further from length 1 holds something else."""

Units = Mapping[str, Mapping[str, float]]
"""The columns that a log may have, and the units of each with their factors; the first is meant without brackets."""


@dataclass(frozen=True)
class Columns:
    """The rows of a log, and where each column is with its factor to the first unit."""

    file: str
    rows: tuple[Row, ...]
    at: Mapping[str, tuple[int, float]]

    def __contains__(self, name: str) -> bool:
        return name in self.at

    def texts(self, name: str) -> tuple[str, ...]:
        """The cells of a column."""
        return tuple(row.cells[self.at[name][0]].strip() for row in self.rows)

    def numbers(self, names: Sequence[str], *, empty: bool = False) -> Array:
        """The columns `names` (K, len(names)); with `empty`, NaN for rows where all their cells are empty."""
        missing = [name for name in names if name not in self.at]
        if missing:
            raise InputError(f"{self.file}: no column {listed(missing)}; {', '.join(names)} belong together")
        at, factors = zip(*(self.at[name] for name in names), strict=True)
        values = np.full((len(self.rows), len(names)), np.nan)
        for k, row in enumerate(self.rows):
            whole = len(row.cells) == len(self.at)
            if not (empty and whole and not "".join(row.cells[i].strip() for i in at)):
                values[k] = row.numbers(at, len(self.at), self.file)
        return np.asarray(values * factors)

    def rotations(self) -> Array:
        """The rotations (K, 3, 3) of qx, qy, qz, qw; NaN where they are empty."""
        quaternions = self.numbers(ROTATION, empty=True)
        for row, length in zip(self.rows, np.linalg.norm(quaternions, axis=-1), strict=True):
            if abs(length - 1.0) > UNIT_LENGTH_TOL:
                raise InputError(f"{self.file}, line {row.line}: qx qy qz qw must be of length 1; got {length:.3g}")
        found, some = np.full((len(quaternions), 3, 3), np.nan), np.isfinite(quaternions).all(axis=1)
        found[some] = from_xyzw(quaternions[some])
        return found


def read_columns(path: str | os.PathLike[str], units: Units, needed: Sequence[str]) -> Columns:
    """Read a log. InputError with the line for an unknown, repeated or missing column, or another unit."""
    file = as_path(path)
    wanted = f"the columns are {', '.join(needed)}; these may follow: {', '.join(n for n in units if n not in needed)}"
    rows = tuple(csv_rows(csv_lines(file, BOUNDS), str(file)))
    if not rows:
        raise InputError(f"{file}: no line but comments; the first names the columns: {wanted}")
    header, *rest = rows
    place, at = f"{file}, line {header.line}", dict[str, tuple[int, float]]()
    for i, cell in enumerate(header.cells):
        name, unit = column(cell, {name: name for name in units})
        if name is None:
            said = cell.partition("[")[0].strip()
            raise InputError(f"{place}: unknown column {said!r}{closest(said, units)}; {wanted}")
        if name in at:
            raise InputError(f"{place}: column {name!r} stands there twice")
        if unit and unit not in units[name]:
            raise InputError(f"{place}: column {name!r} is in [{'], ['.join(units[name])}]; got [{unit}]")
        at[name] = i, units[name][unit] if unit else 1.0
    missing = [name for name in needed if name not in at]
    if missing:
        raise InputError(f"{place}: no column {listed(missing)}; {wanted}")
    return Columns(str(file), tuple(rest), at)
