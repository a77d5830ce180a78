"""The cells of a lesson, read from its file in the percent format."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ...support.errors import InputError, missing_extra

TAGS = ("reveal", "hidden", "solution")
"""What a cell may be tagged: its output behind a fold; its program behind one; both."""


@dataclass(frozen=True)
class Cell:
    """Text in markdown, or a program; `line` is where it begins in the file."""

    source: str
    code: bool
    tags: frozenset[str]
    line: int


def cells_of(path: Path) -> tuple[Cell, ...]:
    """The cells of the lesson at `path`; InputError for a tag that there is not."""
    try:
        import jupytext
    except ImportError as error:
        raise missing_extra("the guide", "jupytext", "guide") from error
    text = path.read_text("utf-8")
    notebook = jupytext.reads(text, fmt="py:percent")
    starts = [number for number, line in enumerate(text.splitlines(), start=1) if re.match(r"# ?%%", line)]
    cells = []
    for cell, start in zip(notebook.cells, starts, strict=True):
        tags = frozenset(cell.metadata.get("tags", ()))
        if unknown := tags - set(TAGS):
            raise InputError(
                f"{path.name}, line {start}: a cell may be tagged {', '.join(TAGS)}; got {sorted(unknown)}"
            )
        cells.append(Cell(cell.source, cell.cell_type == "code", tags, start + 1))
    return tuple(cells)


def title_of(cells: tuple[Cell, ...]) -> str:
    """The title: the first line of the first cell."""
    first = cells[0].source.partition("\n")[0] if cells else ""
    if not first.startswith("# "):
        raise InputError("a lesson begins with a cell of text with the first line `# TITLE`")
    return first[2:].strip()
