"""HTML of what a lesson shows: the same for a page of the guide and for a notebook."""

from __future__ import annotations

import json
from collections.abc import Callable
from html import escape
from typing import Any

from ...viewer.files.inline import Inline
from .markup import block, inline, program

Data = dict[str, Any]


def html_of(data: Data) -> str:
    """The HTML of one thing that `Shown.data` gives."""
    return KINDS[data["kind"]](data)


def fold(summary: str, body: str, name: str = "fold") -> str:
    """Something to unfold."""
    return f'<details class="{name}"><summary>{summary}</summary>\n<div>{body}</div></details>'


def _text(data: Data) -> str:
    return f'<div class="text">{block(data["markdown"])}</div>'


def _table(data: Data) -> str:
    lines = [data["head"], *data["rows"]]
    kinds = [' class="number"' if all(map(_is_number, column[1:])) else "" for column in zip(*lines, strict=True)]
    head, *rows = (list(zip(line, kinds, strict=True)) for line in lines)
    titles = "".join(_title(cell, kind) for cell, kind in head)
    body = "".join("<tr>" + "".join(f"<td{kind}>{inline(cell)}</td>" for cell, kind in row) + "</tr>" for row in rows)
    caption = f"<caption>{inline(data['caption'])}</caption>" if data["caption"] else ""
    label = escape(data["caption"] or "Table")
    return (
        f'<div class="wide" role="group" aria-label="{label}" tabindex="0"><table>{caption}'
        f"<thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _title(cell: str, kind: str) -> str:
    """The head of a column. An empty cell is the head of nothing; a formula alone is no text to some who listen."""
    if not cell:
        return "<td></td>"
    title = inline(cell)
    if cell.startswith("$") and cell.endswith("$"):
        title = title.replace("<math ", f'<math aria-label="{escape(cell[1:-1])}" ', 1)
    return f'<th scope="col"{kind}>{title}</th>'


def _is_number(cell: str) -> bool:
    """Whether a cell begins as a number does; an empty one may stand among numbers."""
    return not cell or cell in ("∞", "none") or cell.lstrip("$−-+.")[:1].isdigit()


def _picture(data: Data, svg: str) -> str:
    return f'<div class="picture" role="img" aria-label="{escape(data["alt"])}">{svg}</div>'


def _caption(data: Data) -> str:
    return f"<figcaption>{inline(data['caption'])}</figcaption>" if data["caption"] else ""


def _figure(data: Data) -> str:
    return f"<figure>{_picture(data, data['svg'])}{_caption(data)}</figure>"


def _scene(data: Data) -> str:
    title = escape(data["alt"])
    if "page" in data:
        frame = Inline.page(data["page"], data["alt"]).html
    else:
        # No sandbox: opened from disk its scripts could not be read then. The scene's own policy lets it reach nothing.
        frame = (
            f'<iframe class="live" src="{escape(data["files"][0])}" title="{title}" loading="lazy"></iframe>'
            f'<p class="live aside"><a href="{escape(data["files"][0])}">Open it in a window of its own</a></p>'
        )
    still = f'<div class="still">{_picture(data, data["still"])}</div>'
    return f'<figure class="scene">{frame}{still}{_caption(data)}</figure>'


def _slider(data: Data) -> str:
    name, numbers = data["name"], escape(json.dumps(data["numbers"]))
    return (
        f'<div class="slider" role="group" aria-label="To try: {escape(name.replace("_", " "))}">'
        f'<div class="question">{block(data["question"])}</div>'
        f'<div class="stage" data-slider="{name}" data-numbers="{numbers}">{_picture(data, data["still"])}</div>'
        f"{fold('Show the answer', block(data['answer']))}</div>"
    )


def _prediction(data: Data) -> str:
    question = f'<div class="question">{block(data["question"])}</div>'
    answer = fold("Show the answer", block(data["answer"]))
    return f'<div class="prediction" role="group" aria-label="Predict">{question}{answer}</div>'


def _exercises(data: Data) -> str:
    entries = "".join(
        f'<div class="exercise" role="group" aria-label="Exercise {k}">'
        f'<h3 id="exercise-{escape(entry["name"])}">Exercise {k}: <code>{escape(entry["name"])}</code></h3>'
        f"{block(entry['prompt'])}{program(entry['signature'])}"
        f"{fold('Show a solution', program(entry['solution']))}</div>"
        for k, entry in enumerate(data["entries"], start=1)
    )
    return f'<div class="exercises">{block(HOW_TO_CHECK.format(lesson=data["lesson"]))}{entries}</div>'


HOW_TO_CHECK = """`twistarm guide exercises` writes a file for each lesson. Fill in the functions of this one, and have
them graded by `twistarm guide check guide_exercises/{lesson}.py`, or in a notebook by `guide.check`. A known mistake is
named."""


def _report(data: Data) -> str:
    verdicts = "".join(f"<li>{escape(line)}</li>" for line in data["lines"])
    printed = escape("\n".join(data["printed"]))
    below = (
        f'<p>Your code printed:</p><pre class="printed" tabindex="0"><samp>{printed}</samp></pre>' if printed else ""
    )
    return f'<div class="report" role="group" aria-label="Verdict"><ul>{verdicts}</ul>{below}</div>'


KINDS: dict[str, Callable[[Data], str]] = {
    "text": _text,
    "table": _table,
    "figure": _figure,
    "scene": _scene,
    "slider": _slider,
    "prediction": _prediction,
    "exercises": _exercises,
    "report": _report,
}
