"""HTML of a lesson's outputs, for a page of the guide and for a notebook."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.files import write_whole
from ..exercises.exercise import Exercise
from . import stills, svg
from .markup import block, inline, program


def fold(summary: str, body: str, name: str = "fold") -> str:
    """Something to unfold."""
    return f'<details class="{name}"><summary>{summary}</summary>\n<div>{body}</div></details>'


def text(markdown: str) -> str:
    """Markdown with formulae between dollars."""
    return f'<div class="text">{block(markdown)}</div>'


def table(head: Sequence[str], rows: Sequence[Sequence[str]], caption: str) -> str:
    """Rows of cells under a head; cells are markdown."""
    columns = zip(head, *rows, strict=True)
    kinds = [' class="number"' if all(map(_is_number, column[1:])) else "" for column in columns]
    titles = "".join(_title(cell, kind) for cell, kind in zip(head, kinds, strict=True))
    lines = ("".join(f"<td{kind}>{inline(cell)}</td>" for cell, kind in zip(row, kinds, strict=True)) for row in rows)
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    above = f"<caption>{inline(caption)}</caption>" if caption else ""
    return (
        f'<div class="wide" role="group" aria-label="{escape(caption or "Table")}" tabindex="0"><table>{above}'
        f"<thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _title(cell: str, kind: str) -> str:
    """A column's head. An empty cell has none, and a formula alone is silent for screen readers."""
    if not cell:
        return "<td></td>"
    title = inline(cell)
    if cell.startswith("$") and cell.endswith("$"):
        title = title.replace("<math ", f'<math aria-label="{escape(cell[1:-1])}" ', 1)
    return f'<th scope="col"{kind}>{title}</th>'


def _is_number(cell: str) -> bool:
    """Whether a cell begins as a number does; an empty one may stand among numbers."""
    return not cell or cell in ("∞", "none") or cell.lstrip("$−-+.")[:1].isdigit()


def figure(figure: Any, alt: str, caption: str) -> str:
    """A figure of matplotlib."""
    return f"<figure>{_picture(figure, alt)}{_caption(caption)}</figure>"


def _picture(figure: Any, alt: str) -> str:
    return f'<div class="picture" role="img" aria-label="{escape(alt)}">{svg.of(figure)}</div>'


def _caption(caption: str) -> str:
    return f"<figcaption>{inline(caption)}</figcaption>" if caption else ""


SCENES: dict[str, dict[str, Any]] = {
    "joints": {"tabs": "tab-move", "layers": {"screws": False}},
    "screws": {"tabs": "tab-move", "layers": {"labels": True}},
    "ellipsoid": {"tabs": "tab-theory", "layers": {"screws": False, "linear_ellipsoid": True}},
    "singular": {"tabs": "tab-theory", "layers": {"linear_ellipsoid": True, "angular_ellipsoid": True}},
    "configurations": {"tabs": "tab-move", "layers": {"screws": False}, "pressed": ["solutions-all"]},
}
"""How the page of a scene begins, by the quantity that it shows."""


def scene(
    arm: Arm, theta: Array, trajectory: Trajectory | None, caption: str, quantity: str, alt: str, folder: Path | None
) -> str:
    """An arm to move, with a quantity that follows. It is a saved page in a frame, and a drawing for paper."""
    # The view takes a while to import, and only scenes need it.
    from ...viewer.parts.arm_data import loading_findings
    from ...viewer.saved_page import Inline, beside, of_arm, stand_alone

    page_data = of_arm(arm, trajectory, theta)
    messages = page_data.messages
    begins = theta if trajectory is None else trajectory(0.0)
    page_data = page_data.with_messages(
        # Nobody looks yet: the reader plays it, from its beginning.
        {**messages["frame"], "theta": begins.tolist(), "running": False},
        # No doctor is going to look, so nothing is said of one. Where loading noted nothing, the page shows none.
        {**loading_findings(arm), "note": ""},
    )

    def of_lesson(page: str) -> str:
        # Where there is little room, the panel is folded to what the lesson is about.
        page = page.replace("<body>", '<body class="compact">', 1)
        return page.replace('id="state">{}', f'id="state">{json.dumps(SCENES[quantity])}', 1)

    if folder is None:
        frame = Inline.page(of_lesson(stand_alone(page_data)), alt).html
    else:
        page, files = beside(page_data)
        page = of_lesson(page)
        name = f"scene_{hashlib.sha256(page.encode()).hexdigest()[:12]}.html"
        for file, content in {name: page, **files}.items():  # scenes share their scripts, so most are there
            if not (folder / file).is_file() or (folder / file).read_text("utf-8", errors="replace") != content:
                write_whole(folder / file, content)
        # No sandbox: opened from disk its scripts could not be read then. The scene's own policy lets it reach nothing.
        frame = (
            f'<iframe class="live" data-src="{folder.name}/{name}" title="{escape(alt)}"></iframe>'
            f'<p class="live aside"><a href="{folder.name}/{name}">Open it in a new window</a></p>'
        )
    still = f'<div class="still">{_picture(stills.arm(arm, theta), alt)}</div>'
    return f'<figure class="scene">{frame}{still}{_caption(caption)}</figure>'


def slider(name: str, question: str, answer: str, numbers: Mapping[str, Any]) -> str:
    """A slider, a drawing of its start, and a question that it answers."""
    return (
        f'<div class="slider" role="group" aria-label="To try: {escape(name.replace("_", " "))}">'
        f'<div class="question">{block(question)}</div>'
        f'<div class="stage" data-slider="{name}" data-numbers="{escape(json.dumps(numbers))}">'
        f"{_picture(*stills.slider(name, numbers))}</div>{fold('Show the answer', block(answer))}</div>"
    )


def prediction(question: str, answer: str) -> str:
    """A question for the reader to answer before the answer is unfolded."""
    question_html = f'<div class="question">{block(question)}</div>'
    answer_html = fold("Show the answer", block(answer))
    return f'<div class="prediction" role="group" aria-label="Predict">{question_html}{answer_html}</div>'


def exercises(lesson: str, entries: Sequence[Exercise]) -> str:
    """Prompt, signature and model solution of each exercise."""
    sections = "".join(
        f'<div class="exercise" role="group" aria-label="Exercise {k}">'
        f'<h3 id="exercise-{escape(entry.name)}">Exercise {k}: <code>{escape(entry.name)}</code></h3>'
        f"{block(entry.prompt)}{program(entry.signature)}"
        f"{fold('Show a solution', program(entry.solution))}</div>"
        for k, entry in enumerate(entries, start=1)
    )
    return f'<div class="exercises">{block(HOW_TO_CHECK.format(lesson=lesson))}{sections}</div>'


HOW_TO_CHECK = """`twistarm guide exercises` writes a file for each lesson. Fill in the functions of this one, and have
them graded by `twistarm guide check guide_exercises/{lesson}.py`, or in a notebook by `guide.check`. A known mistake is
named."""


def report(lines: Sequence[str], printed: Sequence[str]) -> str:
    """Verdicts, and what the reader's code printed."""
    verdicts = "".join(f"<li>{escape(line)}</li>" for line in lines)
    output = escape("\n".join(printed))
    below = f'<p>Your code printed:</p><pre class="printed" tabindex="0"><samp>{output}</samp></pre>' if output else ""
    return f'<div class="report" role="group" aria-label="Verdict"><ul>{verdicts}</ul>{below}</div>'
