"""The cells of a lesson, read from its file in the percent format."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ...support.errors import InputError, missing_extra


@dataclass(frozen=True)
class Cell:
    """Text in markdown, or a program.

    A page folds a program unless it is tagged "shown". The cell begins at `line` of the file.
    """

    source: str
    code: bool
    shown: bool
    line: int


def cells_of(path: Path) -> tuple[Cell, ...]:
    """The cells of the lesson at `path`."""
    try:
        import jupytext
    except ImportError as error:
        raise missing_extra("the guide", "jupytext", "guide") from error
    text = path.read_text("utf-8")
    notebook = jupytext.reads(text, fmt="py:percent")
    starts = [number for number, line in enumerate(text.splitlines(), start=1) if re.match(r"# ?%%", line)]
    return tuple(
        Cell(cell.source, cell.cell_type == "code", "shown" in cell.metadata.get("tags", ()), start + 1)
        for cell, start in zip(notebook.cells, starts, strict=True)
    )


def title_of(cells: tuple[Cell, ...]) -> str:
    """The title: the first line of the first cell."""
    first = cells[0].source.partition("\n")[0] if cells else ""
    if not first.startswith("# "):
        raise InputError("a lesson begins with a cell of text with the first line `# TITLE`")
    return first[2:].strip()
