"""Rows of numbers in CSV, optionally with a header, separated by commas, semicolons, tabs or spaces."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import typer

from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows, is_number, lines_in
from ..support.errors import InputError, listed, shown
from ..support.fields import inside
from ..support.units import column, factor
from .output import note

Columns = Annotated[
    str | None, typer.Option(metavar="A,B,…", help="Names of the CSV's columns, where its header has none or others.")
]

BOUNDS = Bounds(bytes=15_000_000, lines=100_000)
"""A row of seven numbers with all their digits has 140 bytes."""

STDIN = "-"

ROWS_SHOWN = 20
"""The most rows of answers and line numbers to show."""


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
        found: dict[str, Column] = {}
        others: list[str] = []
        for index, cell in enumerate(self.header or ()):
            name, unit = column(cell, known)
            if name is None:
                others.append(cell)
                continue
            if name in found:
                raise InputError(f"{self.file}: two columns hold {name}: {listed(self.header or ())}")
            with inside(self.file, f"column {name}"):
                found[name] = Column(index, factor(unit, units[name]))
        if found and others:
            note(f"{self.file}: not used: {', '.join(others)}")
        return found

    def numbers(self, row: Row, columns: Sequence[Column]) -> Array:
        """The row's values of `columns`, in SI. Raises InputError for a cell that is missing or not a number."""
        width = len(self.header or self.rows[0].cells)
        return np.multiply(
            row.numbers([each.index for each in columns], width, self.file), [each.factor for each in columns]
        )


def few(lines: Sequence[int]) -> str:
    """The first line numbers, and how many more there are."""
    left = len(lines) - ROWS_SHOWN
    return ", ".join(map(str, lines[:ROWS_SHOWN])) + (f" and {left} more" if left > 0 else "")


def read_sheet(path: str, names: str | None) -> Sheet:
    """The sheet in a file, or on standard input for -. `names` [a,b,c] replace its header.

    Lines with # are comments. The first other line is the header where it holds no numbers.
    """
    file = "standard input" if path == STDIN else path
    if path == STDIN and sys.stdin is None:
        raise InputError(f"there is no {file}: it is closed")
    lines = lines_in(sys.stdin.buffer, file, BOUNDS) if path == STDIN else csv_lines(path, BOUNDS)
    rows = list(csv_rows(lines, file))
    numeric = [is_number(cell.replace(",", ".")) for cell in rows[0].cells] if rows else []
    if any(numeric) and not all(numeric):
        raise InputError(f"{file}, line {rows[0].line}: neither a header nor a row of numbers: {shown(rows[0].cells)}")
    header = None if all(numeric) else tuple(cell.strip() for cell in rows[0].cells)
    rows = rows if header is None else rows[1:]
    if not rows:
        raise InputError(f"{file} holds no rows of numbers")
    if names is not None:
        header = tuple(name.strip() for name in re.split(r"[,;]", names))
        if len(header) != len(rows[0].cells):
            raise InputError(f"--columns names {len(header)} columns; {file} has {len(rows[0].cells)}")
    return Sheet(file, header, tuple(rows))


def no_column(sheet: Sheet, wanted: str) -> InputError:
    """The error for a header that does not name what is needed."""
    return InputError(f"{sheet.file}: {wanted}; its header has {listed(sheet.header or ())}")
