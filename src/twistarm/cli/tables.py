"""Tables: each column declares its name, unit and values once, for people, for JSON and for CSV."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.csv_lines import csv_text
from ..support.errors import printable
from ..theory.rotations import to_quaternion_wxyz, to_rpy

GAP = 2  # Characters between two columns.
LEAST_TEXT = 20  # A narrow terminal leaves columns of text so many characters.


@dataclass(frozen=True)
class Column:
    """A column: its values in SI, and the unit of all of them or one for each row.

    `per` follows the unit of each row, as in "/s". `text` replaces the values for people, and `people` is False for a
    column of JSON alone. Its name in JSON is `key`; None keeps it out.
    """

    name: str
    values: Sequence[Any] | Array
    unit: str | Sequence[str] = ""
    per: str = ""
    digits: int = 4
    text: Sequence[str] | None = None
    key: str | None = ""
    people: bool = True

    def cells(self, radians: bool) -> list[str]:
        """The values for people."""
        if self.text is not None:
            return list(self.text)
        units = [self.unit] * len(self.values) if isinstance(self.unit, str) else self.unit
        return [quantity_text(x, unit, radians, self.digits) for x, unit in zip(self.values, units, strict=True)]

    def head(self, radians: bool) -> str:
        """The name with the unit of all values."""
        if isinstance(self.unit, str):
            return f"{self.name} [{unit_text(self.unit, radians)}]" if self.unit else self.name
        return f"{self.name} {self.per}".rstrip()


@dataclass(frozen=True)
class Table:
    """A table for people. With a `key` it is for JSON too: an entry with a record for each row.

    With the key "" each column is an entry, a list. People see only `rows`, if they are given.
    """

    title: str
    columns: Sequence[Column]
    key: str | None = None
    rows: Sequence[int] | None = None

    def entries(self) -> dict[str, Any]:
        """What JSON holds of it."""
        if self.key is None:
            return {}
        kept = [column for column in self.columns if column.key is not None]
        named = {column.key or column.name.replace(" ", "_"): column.values for column in kept}
        if not self.key:
            return named
        return {self.key: [dict(zip(named, row, strict=True)) for row in zip(*named.values(), strict=True)]}

    def csv(self) -> str:
        """The columns as CSV in SI, the unit of all values behind the name."""
        heads = [f"{column.name} [{column.unit}]" if column.unit else column.name for column in self.columns]
        return csv_text(heads, zip(*(np.asarray(column.values).tolist() for column in self.columns), strict=True))

    def print_on(self, out: Console, radians: bool = False) -> None:
        """Print it, unless it is empty. Text is folded to the console's width, numbers never: lines may be longer."""
        heads, cells, texts = [], [], []
        for head, column, is_text in self._in_units(radians):
            heads.append(printable(head))
            cells.append([printable(str(cell)) for cell in column])
            texts.append(is_text)
        if not cells[0]:
            return
        if sum(map(_width, heads, cells)) + GAP * (len(heads) - 1) > out.width:
            # Heads break at spaces and behind underscores, so that no number has to.
            heads = [re.sub(r"(?<=[^ _])( |_(?=[^_ ]))", lambda found: found[0].strip() + "\n", head) for head in heads]
        made = RichTable(box=box.SIMPLE_HEAD, header_style="dim", show_edge=False, pad_edge=False)
        made.padding, made.show_header = (0, GAP - 1, 0, 0), any(heads)
        least = GAP * (len(heads) - 1)
        for i, (head, column, is_text) in enumerate(zip(heads, cells, texts, strict=True)):
            width = _width(head, column)
            least += min(width, LEAST_TEXT) if is_text and i else width
            justify = "left" if is_text or i == 0 else "right"
            made.add_column(escape(head), justify=justify, overflow="fold", no_wrap=not is_text or i == 0)  # type: ignore[arg-type]
        for row in zip(*cells, strict=True):
            made.add_row(*map(escape, row))
        out.width = max(out.width, least)  # Rich would cut numbers to fit; a line may be longer than the terminal
        if self.title:
            out.print(f"[bold]{escape(printable(self.title))}[/bold]")
        out.print(made)

    def _in_units(self, radians: bool) -> Iterator[tuple[str, list[str], bool]]:
        """Heads, cells, and whether they are text. The rows' units precede the first column that has them."""
        units_written, rows = False, range(len(self.columns[0].values)) if self.rows is None else self.rows
        for column in (column for column in self.columns if column.people):
            cells = column.cells(radians)
            if not isinstance(column.unit, str) and not units_written:
                units_written = True
                units = [unit_text(unit, radians) for unit in column.unit]
                yield "unit", [units[i] for i in rows], True
            is_text = all(isinstance(value, (str, tuple)) for value in column.values)
            yield column.head(radians), [cells[i] for i in rows], is_text


def _width(head: str, cells: Sequence[str]) -> int:
    return max(map(cell_len, (*head.split("\n"), *cells)))


def number(value: float, digits: int = 4) -> str:
    """A number without trailing zeros; − for infinity and NaN."""
    if not np.isfinite(value):
        return "−"
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text  # a rounding below zero is no negative number


def unit_text(unit: str, radians: bool) -> str:
    """A unit as people see it: ° for rad unless `radians` is set."""
    return unit if radians or not re.match(r"rad\b", unit) else unit.replace("rad", "°", 1)


def quantity_text(value: Any, unit: str, radians: bool, digits: int = 4) -> str:
    """A value in SI as people see it in `unit_text`. Degrees have two digits fewer than metres and radians."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, (float, np.floating)):
        if unit_text(unit, radians) == unit:
            return number(float(value), digits)
        return number(float(np.degrees(value)), max(digits - 2, 1))
    return ", ".join(value) if isinstance(value, (tuple, list)) else str(value)


def outside(arm: Arm, theta: Array, radians: bool) -> Iterator[str]:
    """A sentence for each joint of theta (n,) outside its position limits."""
    ends = zip(theta.tolist(), arm.limits.lower.tolist(), arm.limits.upper.tolist(), strict=True)
    for name, unit, (x, low, high) in zip(arm.joint_names, arm.units, ends, strict=True):
        if not low <= x <= high:
            value, lower, upper = (quantity_text(coordinate, unit, radians) for coordinate in (x, low, high))
            its = unit_text(unit, radians)
            yield f"{name} = {value} {its} lies outside its limits {lower} … {upper} {its}"


def joint_columns(arm: Arm, theta: Array, digits: int = 4) -> list[Column]:
    """A column for each joint of theta (N, n)."""
    named = zip(arm.joint_names, theta.T, arm.units, strict=True)
    return [Column(name, values, unit, digits=digits) for name, values, unit in named]


def theta_typed(arm: Arm, theta: Array, radians: bool) -> str:
    """theta (n,) as it can be typed or pasted: `--theta "0.1 -30 60"`."""
    rad = " --rad" if radians else ""
    return f'--theta "{theta_values(arm, theta, radians)}"{rad}'


def theta_values(arm: Arm, theta: Array, radians: bool, digits: int = 6) -> str:
    """The numbers of `theta_typed`: 6 digits, to 1 µm and some 1e-8 rad (1e-6 rad in radians)."""
    angle = 1.0 if radians else float(np.degrees(1.0))
    factors = [1.0 if unit == "m" else angle for unit in arm.units]
    return " ".join(number(x * factor, digits) for x, factor in zip(theta, factors, strict=True))


def matrix_table(title: str, matrix: Array, rows: Sequence[str], columns: Sequence[str]) -> Table:
    """A matrix with its rows and columns named. The first of `columns` is the head of the names of the rows."""
    values = [[f"{x:.6f}" for x in column] for column in (np.round(matrix, 6) + 0.0).T]  # + 0.0 turns −0 into 0
    parts = [Column(name, column, text=text) for name, column, text in zip(columns[1:], matrix.T, values, strict=True)]
    return Table(title, [Column(columns[0], list(rows)), *parts])


def pose_parts(title: str, g: Array, radians: bool) -> tuple[Table | str, ...]:
    """A pose as matrix and position in a table, and the sentences of its quaternion and its angles."""
    angles = to_rpy(g[:3, :3])
    rpy = " ".join([*(number(x, 6) for x in angles), "rad"] if radians else [*map(number, np.degrees(angles)), "°"])
    quaternion = " ".join(number(x, 6) for x in to_quaternion_wxyz(g[:3, :3]))
    return (
        matrix_table(title, g[:3], "xyz", ["g", "x", "y", "z", "p [m]"]),
        f"quaternion (w x y z) {quaternion}",
        f"roll pitch yaw {rpy}: turns about the base's x, then y, then z axis",
    )


def pose_entries(g: Array) -> dict[str, Any]:
    """A pose for JSON."""
    R = g[:3, :3]
    return {"matrix": g, "position": g[:3, 3], "rpy": to_rpy(R), "quaternion_wxyz": to_quaternion_wxyz(R)}
