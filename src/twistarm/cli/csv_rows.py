"""Rows of numbers in CSV, optionally with a header, separated by commas, semicolons, tabs or spaces."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, TypeVar

import numpy as np
import typer

from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows, is_comment, is_number, lines_in
from ..support.errors import InputError, listed, shown
from ..support.units import UNITS, column
from .output import note

Columns = Annotated[
    str | None, typer.Option(metavar="A,B,…", help="Names of the CSV's columns, where its header has none or others.")
]

BOUNDS = Bounds(bytes=15_000_000, lines=100_000)
"""A row of seven numbers with all their digits has 140 bytes."""

STDIN = "-"

ROWS_SHOWN = 20
"""The most rows of answers and line numbers to show."""

OURS = re.compile(r"(line|answer|position_error|orientation_error|time|.*\.velocity|.*\.acceleration)( \[.*\])?$")
"""Further columns of the files that twistarm writes. It does not read them."""

T = TypeVar("T")


@dataclass(frozen=True)
class Column:
    """The column of a quantity, and its unit in SI."""

    index: int
    factor: float


@dataclass(frozen=True)
class Sheet:
    """A CSV file; `header` is None if the first line holds numbers."""

    file: str
    header: tuple[str, ...] | None
    rows: tuple[Row, ...]

    def columns(self, known: Mapping[str, str], units: Mapping[str, str]) -> dict[str, Column]:
        """The columns of the quantities in `units` [m, rad, 1] by the header's names in `known`.

        A unit may follow a name; the default is SI. Unknown columns are ignored with a note.
        """
        assert self.header is not None, "a sheet without one was refused, or got its names"
        found: dict[str, Column] = {}
        passed_over: list[str] = []
        for index, cell in enumerate(self.header):
            name, unit = column(cell, known)
            if name is None:
                passed_over += [] if OURS.match(cell) else [cell.strip()]
                continue
            factors = UNITS[units[name]]
            if unit.casefold() not in ("", *factors):
                raise InputError(f"{self.file}: {name} is a column in {listed(factors)}; its header says {unit!r}")
            if name in found:
                raise InputError(f"{self.file}: two columns hold {name}: {listed(self.header)}")
            found[name] = Column(index, factors.get(unit.casefold(), 1.0))
        if found and passed_over:
            note(f"{self.file}: not used: {', '.join(passed_over)}")
        return found

    def numbers(self, row: Row, columns: Sequence[Column]) -> Array:
        """The row's values of `columns`, in SI. Raises InputError for a cell that is missing or not a number."""
        values = row.numbers([column.index for column in columns], len(self.header or self.rows[0].cells))
        return np.multiply(values, [column.factor for column in columns])

    def each(self, make: Callable[[Row], T]) -> list[T]:
        """The results of `make` for every row. Raises InputError with the numbers of all lines that fail."""
        made = [_attempt(make, row) for row in self.rows]
        bad = [(row.line, one) for row, one in zip(self.rows, made, strict=True) if isinstance(one, InputError)]
        if bad:
            (line, why), *others = bad
            more = f"; also bad: line {few([other for other, _ in others])}" if others else ""
            raise InputError(f"{self.file}, line {line}: {why}{more}")
        return [one for one in made if not isinstance(one, InputError)]


def _attempt(make: Callable[[Row], T], row: Row) -> T | InputError:
    try:
        return make(row)
    except InputError as error:
        return error


def few(lines: Sequence[int]) -> str:
    """The first line numbers, and how many more there are."""
    left = len(lines) - ROWS_SHOWN
    return ", ".join(map(str, lines[:ROWS_SHOWN])) + (f" and {left} more" if left > 0 else "")


def read_sheet(path: str, names: str | None) -> Sheet:
    """The sheet in a file, or on standard input for -. `names` [a,b,c] replace its header.

    Lines with # are comments, except a header of as many columns before the first row.
    """
    file = "standard input" if path == STDIN else path
    if path == STDIN and sys.stdin is None:
        raise InputError(f"there is no {file}: it is closed")
    lines = list(lines_in(sys.stdin.buffer, file, BOUNDS) if path == STDIN else csv_lines(path, BOUNDS))
    rows = list(csv_rows(lines, file))
    if not rows:
        raise InputError(f"{file} holds no rows of numbers")
    header = None if all(map(_is_number, rows[0].cells)) else tuple(cell.strip() for cell in rows[0].cells)
    if header and any(map(_is_number, header)):
        said = shown(", ".join(header))
        raise InputError(f"{file}, line {rows[0].line}: neither a header nor a row of numbers: {said}")
    rows = rows[1:] if header else rows
    if names is not None:
        header = tuple(name.strip() for name in re.split(r"[,;]", names))
        if rows and len(header) != len(rows[0].cells):
            raise InputError(f"--columns names {len(header)} columns; {file} has {len(rows[0].cells)}")
    elif header is None and rows:
        header = _commented_header(lines[: rows[0].line - 1], len(rows[0].cells))
    if not rows:
        raise InputError(f"{file} holds a header and no rows of numbers")
    return Sheet(file, header, tuple(rows))


def _commented_header(before: Sequence[str], width: int) -> tuple[str, ...] | None:
    """The header that NumPy and others write as a comment."""
    for comment in reversed([line.lstrip("# ") for line in before if is_comment(line)]):
        for row in csv_rows([comment], "a comment"):
            if len(row.cells) == width and not any(map(_is_number, row.cells)):
                return tuple(cell.strip() for cell in row.cells)
    return None


def _is_number(cell: str) -> bool:
    """Whether a cell is a number, also with a decimal comma, which is refused later."""
    return is_number(cell.replace(",", "."))


def no_column(sheet: Sheet, wanted: str) -> InputError:
    """The error for a header that does not name what is needed."""
    return InputError(f"{sheet.file}: {wanted}; its header has {listed(sheet.header or ())}")
