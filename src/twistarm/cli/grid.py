"""Tables that fit a terminal. Numbers and names stay whole; columns that do not fit go on below."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich import box
from rich.cells import cell_len
from rich.console import Console, ConsoleOptions
from rich.markup import escape
from rich.table import Table

GAP = 2
"""Columns of the terminal between two of the table."""

LONGEST_WORD = 30
"""A longer word in a column of text, such as a path, is broken."""


@dataclass(frozen=True)
class Column:
    """A column's head and cells. Cells stay whole unless `wraps` breaks them between words."""

    head: str
    cells: tuple[str, ...]
    left: bool = False
    wraps: bool = False

    @property
    def natural(self) -> int:
        """The width in which each cell is one line."""
        return max(map(cell_len, (self.head, *self.cells)))

    @property
    def least(self) -> int:
        """The least width that breaks text only between words, and the head also behind underscores."""
        widths = [cell_len(part.rstrip()) for part in _parts(self.head)]
        if self.wraps:
            widths += [min(cell_len(word), LONGEST_WORD) for cell in self.cells for word in cell.split()]
        else:
            widths += [cell_len(cell) for cell in self.cells]
        return max(widths)

    def head_within(self, width: int) -> str:
        """The head on as many lines as it needs."""
        lines = [""]
        for part in _parts(self.head):
            whole = cell_len((lines[-1] + part).rstrip()) <= width
            lines = [*lines[:-1], lines[-1] + part] if whole else [*lines, part]
        return "\n".join(line.rstrip() for line in lines if line)


def _parts(head: str) -> list[str]:
    """Where a head may be broken: behind spaces and underscores."""
    return re.findall(r"[^ _]*(?:_+| +|$)", head) or [""]


@dataclass(frozen=True)
class Grid:
    """A table for rich to print. Its first column is repeated where it goes on below."""

    title: str
    columns: tuple[Column, ...]
    caption: str = ""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table | str]:
        if self.title:
            yield f"[bold]{escape(self.title)}[/bold]"
        for i, block in enumerate(_blocks(self.columns, options.max_width)):
            if i:
                yield ""
            yield _table(block, _widths(block, options.max_width))
        if self.caption:
            yield escape(self.caption)


def _blocks(columns: Sequence[Column], width: int) -> list[list[Column]]:
    """The columns in as few blocks as fit, of about equally many."""
    first, *others = columns
    for count in range(1, len(others) + 1):
        size = -(-len(others) // count)
        blocks = [[first, *others[i : i + size]] for i in range(0, len(others), size)]
        if all(sum(_widths(block, width)) + GAP * (len(block) - 1) <= width for block in blocks):
            return blocks
    return [[first, other] for other in others] or [[first]]


def _widths(columns: Sequence[Column], width: int) -> list[int]:
    """The width of each column: what it needs, then the rest to the narrowest wishes.

    If even two columns do not fit, the wider one is broken.
    """
    widths = [column.least for column in columns]
    spare = width - GAP * (len(columns) - 1) - sum(widths)
    if spare < 0 and len(columns) <= 2:
        widest = widths.index(max(widths))
        widths[widest] = max(widths[widest] + spare, 1)
    spare = max(spare, 0)
    wishes = sorted((column.natural - column.least, i) for i, column in enumerate(columns))
    for left, (wish, i) in zip(range(len(wishes), 0, -1), wishes, strict=True):
        given = min(wish, spare // left)
        widths[i] += given
        spare -= given
    return widths


def _table(columns: Sequence[Column], widths: Sequence[int]) -> Table:
    made = Table(box=box.SIMPLE_HEAD, header_style="dim", show_edge=False, pad_edge=False)
    made.padding, made.show_header = (0, GAP - 1, 0, 0), any(column.head for column in columns)
    heads = [column.head_within(width) for column, width in zip(columns, widths, strict=True)]
    lines = max(head.count("\n") for head in heads)
    for column, head, width in zip(columns, heads, widths, strict=True):
        # Heads stand at the bottom of theirs, cells at the top.
        head = "\n" * (lines - head.count("\n")) + head
        made.add_column(escape(head), justify="left" if column.left else "right", overflow="fold", width=width)
    for row in zip(*(column.cells for column in columns), strict=True):
        made.add_row(*map(escape, row))
    return made
