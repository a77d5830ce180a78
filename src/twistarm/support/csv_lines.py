"""Rows of a CSV file, read within bounds, and our CSV text."""

from __future__ import annotations

import codecs
import csv
import io
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from math import isfinite
from typing import BinaryIO, NamedTuple

from .checks import number_in
from .errors import InputError, listed
from .fields import inside
from .files import as_path, open_regular, why_no_file
from .units import column, factor

MAX_LINE = 100_000  # Characters of a line: a thousand columns of numbers with all their digits are 20,000.


class Bounds(NamedTuple):
    """How much is read of a file: bytes and lines."""

    bytes: int
    lines: int


def csv_lines(path: str | os.PathLike[str], bounds: Bounds) -> Iterator[str]:
    """The lines of the regular file at `path`, as `lines_in`. Raises InputError if unreadable."""
    file = as_path(path)
    try:
        opened = open_regular(file)
    except (OSError, ValueError) as error:  # a name that cannot be a file's is a ValueError
        raise InputError(f"{file}: {why_no_file(file, error)}; give the path of a CSV file") from error
    with opened:
        yield from lines_in(opened, str(file), bounds)


def lines_in(file: BinaryIO, name: str, bounds: Bounds) -> Iterator[str]:
    """The lines of an opened file or a pipe, with their ends.

    The text is UTF-16 by its byte-order mark, UTF-8 with or without a mark, or Latin-1. Raises InputError for a line of
    more than `MAX_LINE` characters and for a file beyond the bounds.
    """
    try:
        data = file.read(bounds.bytes + 1)
    except OSError as error:
        raise InputError(f"cannot read {name}: {error.strerror or error}") from error
    allowed = f"{bounds.bytes / 1e6:.0f} MB and {bounds.lines:,} lines"
    too_large = InputError(f"{name} is too large: at most {allowed} are read; split it, or leave out lines")
    if len(data) > bounds.bytes:
        raise too_large
    marked = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if marked else "utf-8-sig")
    except UnicodeDecodeError as error:
        if marked:
            raise InputError(f"{name} is no text: {error}") from error
        text = data.decode("latin-1")
    # Ends of the old Macintosh, \r alone, are ends too.
    for count, line in enumerate(io.StringIO(text, newline=""), 1):
        if count > bounds.lines:
            raise too_large
        if len(line) > MAX_LINE:
            raise InputError(f"{name}, line {count}: more than {MAX_LINE:,} characters; is it the right file?")
        yield line


class Row(NamedTuple):
    """The cells of a line that says something."""

    line: int
    cells: list[str]

    def numbers(self, columns: Sequence[int], width: int, file: str) -> list[float]:
        """The finite numbers in some columns of a row as wide as the header.

        Raises InputError, with line and column, for a cell without a number and a row of another width.
        """
        if len(self.cells) != width:
            raise InputError(f"{file}, line {self.line}: {len(self.cells)} values where there are {width} columns")
        cells = [self.cells[k] for k in columns]
        with suppress(ValueError):  # most rows are sound, and whole ones are read five times as fast
            values, text = list(map(float, cells)), "".join(cells)
            if text.isascii() and "_" not in text and all(map(isfinite, values)):
                return values
        return [number_in(self.cells[k].strip(), f"{file}, line {self.line}: column {k + 1}") for k in columns]


def csv_rows(lines: Iterable[str], file: str) -> Iterator[Row]:
    """The rows of a file's lines, without blank lines and lines with #.

    The first row decides the separator: tabs, semicolons or commas, else spaces. In a row with words it is the most
    frequent of them, in a row of numbers the first.
    """
    count = 0

    def written() -> Iterator[str]:
        nonlocal count
        for line in lines:
            count += 1
            if line.strip() and not line.lstrip().startswith("#"):
                yield line

    rows = written()
    first = next(rows, "")
    separators = [sign for sign in "\t;," if sign in first]
    has_words = first.upper() != first.lower()
    separator = max(separators, key=first.count) if separators and has_words else next(iter(separators), None)
    whole = chain([first] if first else [], rows)
    try:
        for cells in map(str.split, whole) if separator is None else csv.reader(whole, delimiter=separator):
            yield Row(count, cells)
    except csv.Error as error:
        raise InputError(f"{file}, line {count} is no CSV text: {error}") from error


def known_columns(
    heads: Sequence[str], known: Mapping[str, str], quantities: Mapping[str, str], place: str
) -> tuple[dict[str, tuple[int, float]], list[str]]:
    """The number of each column and the size of its unit, by the name that `known` gives its head; and other heads.

    `quantities` are those of the names. Raises InputError for two columns of a name, and a unit of another quantity.
    """
    found: dict[str, tuple[int, float]] = {}
    others = []
    for k, head in enumerate(heads):
        name, unit = column(head, known)
        if name is None:
            others.append(head)
            continue
        if name in found:
            raise InputError(f"{place}: two columns hold {name}: {listed(heads)}")
        with inside(place, f"column {name}"):
            found[name] = k, 1.0 if unit == quantities[name] else factor(unit, quantities[name])
    return found, others


def is_number(cell: str) -> bool:
    """Whether a cell holds a number as other programs write it."""
    with suppress(ValueError):
        float(cell)
        return cell.isascii() and "_" not in cell
    return False


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table as CSV."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *rows])
    return text.getvalue()
