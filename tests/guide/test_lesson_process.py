"""A lesson as it is run: its text and outputs, what is folded, and what is said where a cell fails."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from twistarm import InputError
from twistarm.guide.building.cells import cells_of, title_of

Ran = Callable[[str], dict[str, Any]]

HEAD = "# %% [markdown]\n# # A title\n#\n# Is $x < 1$ & <b>bold</b>?\n#\n# ## A section\n\n"


def test_text_programs_and_outputs_stand_in_their_order(ran: Ran) -> None:
    made = ran(HEAD + "# %%\nfrom twistarm import guide\nx = 2\nguide.say(f'It is **{x}**.')\nprint('<printed>')\n")
    assert made["sections"] == [("a-section", "A section")]
    assert made["failed"] == ""
    body = made["body"]
    places = [
        body.index(part) for part in ("A title", "A section", "&lt;printed&gt;", "<strong>2</strong>", 'class="code"')
    ]
    assert places == sorted(places)
    assert "<b>" not in body, "a text holds no HTML"


def test_a_failing_cell_is_named_by_its_line_and_the_text_goes_on(ran: Ran) -> None:
    made = ran(HEAD + "# %%\nx = 1\n\n# %%\ny = 2\ny = x / 0\n\n# %% [markdown]\n# The end\n\n# %%\nprint('not run')\n")
    assert made["failed"] == "lesson: cell 3 (line 13) failed: ZeroDivisionError: division by zero"
    assert "The end" in made["body"]
    assert "<samp>not run" not in made["body"]


def test_a_syntax_error_is_a_sentence_with_its_line(ran: Ran) -> None:
    assert re.search(r"cell 2 \(line 9\) failed: SyntaxError", ran(HEAD + "# %%\nx = = 1\n")["failed"])


def test_a_program_is_folded_below_its_output_unless_it_is_tagged(ran: Ran) -> None:
    silent = "# %%\nfrom twistarm import guide\ny = 1\n\n"
    cell = "# %%{}\nx = 7\nguide.say('seven')\n"
    folded, shown = (ran(HEAD + silent + cell.format(tag))["body"] for tag in ("", ' tags=["shown"]'))
    assert folded.index("seven</p>") < folded.index("<details") < folded.index(">y</span>") < folded.index(">x</span>")
    assert folded.count("<details") == 1, "with the program before it that shows nothing"
    assert "<details" not in ran(HEAD + silent.replace("%%", '%% tags=["shown"]') + "# %%\nguide.say('a')\n")["body"]
    assert shown.index(">x</span>") < shown.index("seven</p>") < shown.index("<details") < shown.index(">y</span>")


def test_a_lesson_begins_with_its_title(tmp_path: Path) -> None:
    (tmp_path / "lesson.py").write_text("# %%\nx = 1\n")
    with pytest.raises(InputError, match="begins with a cell of text"):
        title_of(cells_of(tmp_path / "lesson.py"))
