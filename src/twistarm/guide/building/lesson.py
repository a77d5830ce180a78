"""A lesson: its cells, and the process that runs them and writes their text and outputs as HTML.

    python -m twistarm.guide.building.lesson LESSON.py SCENES OUT.json

The outcome is JSON: `body`, `sections` (name and title of each) and `failed`. `failed` is empty, or names cell and
reason.
"""

from __future__ import annotations

import ast
import io
import json
import re
import sys
import traceback
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from ...support.errors import InputError, missing_extra, one_line
from ..teaching import output
from ..teaching.html import fold, text
from ..teaching.markup import program, slug

LONGEST_OUTPUT = 20_000  # Most characters of a cell's output on a page.


@dataclass(frozen=True)
class Cell:
    """Text in markdown, or a program.

    A page shows a program where it is tagged "shown". The others it gathers in one fold at its end. The cell begins at
    `line` of the file.
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


def outcome(path: Path, scenes: Path) -> dict[str, Any]:
    """Run the lesson at `path`. A failing cell ends it, and the text continues."""
    cells = cells_of(path)
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(path)}
    body, failed = [], ""
    folded, title = [], ""  # programs that make figures and tables; the first of a section begins with its title
    for number, cell in enumerate(cells, start=1):
        if not cell.code:
            body.append(text(cell.source))
            title = (_titles(cell) or [title])[-1]
            continue
        shown = ""
        if not failed:
            try:
                shown = _run(cell, path, scenes, names)
            except Exception as error:
                own = [at.lineno for at in traceback.extract_tb(error.__traceback__) if at.filename == str(path)]
                line = own[-1] if own else getattr(error, "lineno", None)
                why = one_line(f"{type(error).__name__}: {error}", 300)
                failed = f"{path.stem}: cell {number} (line {line or cell.line}) failed: {why}"
                shown = f'<p class="failed" role="note">{escape(failed)}. The programs after it did not run.</p>'
        if cell.shown:
            body.append(program(cell.source))
        elif not _only_calls_guide(cell.source):
            folded.append(f"# {title}\n\n{cell.source}" if title else cell.source)
            title = ""
        body.append(shown)
    if folded:
        body.append(fold("The program behind this", program("\n\n\n".join(folded)), "fold program"))
    titles = [title for cell in cells if not cell.code for title in _titles(cell)]
    return {"body": "\n".join(body), "sections": [(slug(title), title) for title in titles], "failed": failed}


def _run(cell: Cell, path: Path, scenes: Path, names: dict[str, Any]) -> str:
    """Run a cell; its output as HTML. What it raises is raised."""
    shown: list[str] = []
    printed = io.StringIO()
    # Lines are counted as in the file, so that an error names its own.
    code = compile("\n" * (cell.line - 1) + cell.source, str(path), "exec")
    with output.installed(lambda item: shown.append(item.html(scenes))), redirect_stdout(printed):
        exec(code, names)
    words = escape(printed.getvalue()[:LONGEST_OUTPUT].rstrip())
    printed_html = f'<pre class="printed" tabindex="0"><samp>{words}</samp></pre>' if words else ""
    return printed_html + "\n".join(shown)


def _titles(cell: Cell) -> list[str]:
    return [line[3:].strip() for line in cell.source.splitlines() if line.startswith("## ")]


def _only_calls_guide(source: str) -> bool:
    with suppress(SyntaxError):
        return all(ast.unparse(statement).startswith("guide.") for statement in ast.parse(source).body)
    return False


if __name__ == "__main__":
    lesson, scenes_folder, result = map(Path, sys.argv[1:])
    result.write_text(json.dumps(outcome(lesson, scenes_folder)), "utf-8")
