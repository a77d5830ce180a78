"""A lesson as it is run: its text and outputs, what is folded, and what is said where a cell fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from twistarm import InputError
from twistarm.guide.building.cells import cells_of, title_of
from twistarm.guide.building.lesson_process import without_speech

Ran = Callable[[str], dict[str, Any]]

HEAD = "# %% [markdown]\n# # A title\n#\n# Is $x < 1$ & <b>bold</b>?\n#\n# ## A section\n\n"


def test_text_programs_and_outputs_stand_in_their_order(ran: Ran) -> None:
    made = ran(HEAD + "# %%\nfrom twistarm import guide\nx = 2\nguide.say(f'It is **{x}**.')\nprint('<printed>')\n")
    assert made["sections"] == [("a-section", "A section")]
    assert made["failed"] == ""
    body = made["body"]
    places = [
        body.index(part) for part in ("A title", "A section", 'class="code"', "&lt;printed&gt;", "<strong>2</strong>")
    ]
    assert places == sorted(places)
    assert "<b>" not in body, "a text holds no HTML"
    assert "guide.say" not in body, "what only speaks is not shown as a program"


def test_a_failing_cell_is_named_by_its_line_and_the_text_goes_on(ran: Ran) -> None:
    made = ran(HEAD + "# %%\nx = 1\n\n# %%\ny = 2\ny = x / 0\n\n# %% [markdown]\n# The end\n\n# %%\nprint('not run')\n")
    assert made["failed"] == "lesson: cell 3 (line 13) failed: ZeroDivisionError: division by zero"
    assert "The end" in made["body"]
    assert "<samp>not run" not in made["body"]


def test_a_claim_that_does_not_hold_is_quoted(ran: Ran) -> None:
    made = ran(HEAD + "# %%\nx = 1\nassert x == 2\n")
    assert made["failed"].endswith("(line 10) failed: what it claims does not hold here: assert x == 2")


def test_a_syntax_error_is_a_sentence_with_its_line(ran: Ran) -> None:
    assert re.search(r"cell 2 \(line 9\) failed: SyntaxError", ran(HEAD + "# %%\nx = = 1\n")["failed"])


def test_tags_fold_the_output_the_program_or_both(ran: Ran) -> None:
    cell = "# %% tags=[{}]\nfrom twistarm import guide\nx = 7\nguide.say('seven')\n"
    reveal, hidden, solution = (ran(HEAD + cell.format(f'"{tag}"'))["body"] for tag in ("reveal", "hidden", "solution"))
    assert reveal.index(">x</span>") < reveal.index("<details") < reveal.index("seven</p>")
    assert hidden.index("seven</p>") < hidden.index("<details") < hidden.index(">x</span>")
    inside = solution.partition("<details")[2].partition("</details>")[0]
    assert inside.index(">x</span>") < inside.index("seven</p>")
    with pytest.raises(InputError, match=r"lesson.py, line 8: .* reveal, hidden, solution; got \['folded'\]"):
        ran(HEAD + cell.format('"folded"'))


def test_a_lesson_begins_with_its_title(tmp_path: Path) -> None:
    (tmp_path / "lesson.py").write_text("# %%\nx = 1\n")
    with pytest.raises(InputError, match="begins with a cell of text"):
        title_of(cells_of(tmp_path / "lesson.py"))


@pytest.mark.parametrize(
    ("source", "left"),
    [
        ("a = 1\nguide.say(\n    'x'\n)\nb = 2", "a = 1\n\nb = 2"),
        ("guide.figure(fig, 'words')\nguide.predict('a', 'b')", ""),
        ("x = guide.arm()\nfor y in x:\n    guide.say(y)", "x = guide.arm()\nfor y in x:\n    guide.say(y)"),
    ],
)
def test_statements_that_only_speak_are_left_out(source: str, left: str) -> None:
    assert without_speech(source) == left
