"""The process of one lesson: it runs the cells and writes their text and outputs as HTML.

    python -m twistarm.guide.building.lesson_process LESSON.py SCENES OUT.json

The outcome is JSON: `body`, `sections` (name and title of each) and `failed`, empty or a sentence with cell and reason.
"""

from __future__ import annotations

import ast
import io
import json
import sys
import traceback
from contextlib import redirect_stdout, suppress
from html import escape
from pathlib import Path
from typing import Any

from ...support.errors import one_line
from ..teaching import outlet
from ..teaching.html import fold, text
from ..teaching.markup import program, slug
from .cells import Cell, cells_of

LONGEST_OUTPUT = 20_000
"""Most characters of a cell's output on a page."""


def outcome(path: Path, scenes: Path) -> dict[str, Any]:
    """Run the lesson at `path`. A failing cell ends it, and the text continues."""
    cells = cells_of(path)
    names: dict[str, Any] = {"__name__": "__main__", "__file__": str(path)}
    body, failed = [], ""
    programs: list[str] = []  # not on the page yet
    for number, cell in enumerate(cells, start=1):
        if not cell.code:
            body.append(text(cell.source))
            continue
        output = ""
        if not failed:
            try:
                output = _run(cell, path, scenes, names)
            except Exception as error:
                why = one_line(f"{type(error).__name__}: {error}", 300)
                failed = f"{path.stem}: cell {number} (line {_line(error, path, cell)}) failed: {why}"
                output = f'<p class="failed" role="note">{escape(failed)}. The programs after it did not run.</p>'
        if cell.shown:
            body.append(program(cell.source))
        elif not _only_calls_guide(cell.source):
            programs.append(cell.source)
        body.append(output)
        if output and programs:
            body.append(_folded(programs))
            programs = []
    if programs:
        body.append(_folded(programs))
    return {"body": "\n".join(body), "sections": [(slug(title), title) for title in _sections(cells)], "failed": failed}


def _run(cell: Cell, path: Path, scenes: Path, names: dict[str, Any]) -> str:
    """Run a cell; its output as HTML. What it raises is raised."""
    shown: list[str] = []
    printed = io.StringIO()
    # Lines are counted as in the file, so that an error names its own.
    code = compile("\n" * (cell.line - 1) + cell.source, str(path), "exec")
    with outlet.installed(lambda each: shown.append(each.html(scenes))), redirect_stdout(printed):
        exec(code, names)
    words = escape(printed.getvalue()[:LONGEST_OUTPUT].rstrip())
    said = f'<pre class="printed" tabindex="0"><samp>{words}</samp></pre>' if words else ""
    return said + "\n".join(shown)


def _folded(programs: list[str]) -> str:
    return fold("The program behind this", program("\n\n\n".join(programs)), "fold program")


def _only_calls_guide(source: str) -> bool:
    with suppress(SyntaxError):
        return all(ast.unparse(each).startswith("guide.") for each in ast.parse(source).body)
    return False


def _sections(cells: tuple[Cell, ...]) -> list[str]:
    lines = (line for cell in cells if not cell.code for line in cell.source.splitlines())
    return [line[3:].strip() for line in lines if line.startswith("## ")]


def _line(error: Exception, path: Path, cell: Cell) -> int:
    own = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    return own[-1] or cell.line if own else getattr(error, "lineno", None) or cell.line


if __name__ == "__main__":
    lesson, scenes_folder, result = map(Path, sys.argv[1:])
    result.write_text(json.dumps(outcome(lesson, scenes_folder)), "utf-8")
