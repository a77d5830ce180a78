"""Markdown as HTML, names that must not become HTML, and a lesson's text, programs and outputs in their order."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from twistarm import InputError, guide
from twistarm.guide.building.lesson import cells_of, title_of
from twistarm.guide.teaching import output
from twistarm.guide.teaching.markup import block, formula
from twistarm.guide.teaching.output import rough, tex


def test_formulae_are_mathml_that_says_itself_in_tex() -> None:
    html = block("Be $\\theta_1 < 2$, and\n\n$$e^{\\hat\\xi\\theta}$$\n")
    assert html.count("<math ") == 2
    assert 'alttext="\\theta_1 &lt; 2"' in html
    assert 'display="block"' in html
    assert "$" not in html


def test_a_number_at_the_start_of_a_line_is_no_list() -> None:
    assert block("The condition is\n115. To turn") == "<p>The condition is\n115. To turn</p>\n"
    assert block("115. To turn the tool") == "<p>115. To turn the tool</p>\n"
    assert block("rates of length\n1. `J_b` (6, m)") == "<p>rates of length\n1. <code>J_b</code> (6, m)</p>\n"
    assert block("1. one\n   more\n2. two\n").count("<li>") == 2


def test_a_function_and_its_power_are_one() -> None:
    for text, last in ((r"\cos^{-1} x", "</mrow></msup>"), (r"\sin^2 x", "<mn>2</mn></msup>"), (r"\cos x", "cos</mi>")):
        assert re.search(re.escape(last) + "<mspace[^>]*></mspace><mi>x</mi>", formula(text)), text
        assert "<mspace" not in formula(text).partition("</msup>" if "^" in text else "<mi>")[0]


def test_an_exponent_stands_beside_the_letter_below_a_dot() -> None:
    for text in (r"\dot\theta^2", r"\dot\theta_1^2", r"{\dot s}^2", r"\hat V^s"):
        html = formula(text)
        assert html.count('<mover accent="true">') == html.count("<mover") == 1
        assert re.search(r'<msu(?:p|bsup)>(?:<mrow>)?<mpadded height="[\d.]+em"><mover', html), text


def test_punctuation_stays_with_its_formula() -> None:
    html = block("Be $a$ a number ($b$), and $c$.")
    together = re.findall(r'<span class="together">(.)?.*?</math></span>(.*?)</span>', html)
    assert together == [("(", "),"), ("<", ".")]


@pytest.mark.parametrize("tex", ["x^", "{", r"\begin{bmatrix} 1", r"2 \nosuch"])
def test_a_formula_that_cannot_be_read_is_named(tex: str) -> None:
    with pytest.raises(InputError, match=re.escape(f"the formula {tex!r} cannot be read: ")):
        formula(tex)


def test_nothing_from_a_name_becomes_html() -> None:
    name = "</pre><script>alert(1)</script>"
    shown: list[output.Shown] = []
    with output.installed(shown.append):
        guide.say(f"`{name}` {name}")
        guide.table([name], [[name]], name)
        guide.figure(guide.axes2()[0], f'"{name}', name)
        guide.predict(name, name)
    assert not [piece.plain for piece in shown if "<script" in piece.html(None)]


def test_numbers_in_tex() -> None:
    assert tex([1, -0.0, 0.12345], 2) == "(1.00, 0.00, 0.12)"
    assert tex([[1, 2]], 0) == r"\begin{bmatrix} 1 & 2 \end{bmatrix}"
    assert rough(2.2e-16) == r"2 \cdot 10^{-16}"
    assert rough(0.0) == "0"
    with pytest.raises(InputError, match=r"shape \(1, 1, 1\)"):
        tex([[[1]]])


def test_numbers_in_a_table() -> None:
    shown: list[output.Shown] = []
    with output.installed(shown.append):
        guide.table(["$a$", "b"], [["x", 0.25], ["y", -3.2e-7], ["z", -4e-17], ["none", ""]])
    numbers = [line.partition("  ")[2].strip() for line in map(str.lstrip, shown[0].plain.splitlines()[1:])]
    assert numbers == ["0.2500", r"$-3 \cdot 10^{-7}$", "0.0000", ""]
    html = shown[0].html(None)
    assert html.count('<td class="number">') == 4, "a column of numbers is one, with its title"
    assert html.count('<th scope="col" class="number">') == 1


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
    assert folded.index("<details") < folded.index("# A section") < folded.index(">y</span>"), "told where it belongs"
    assert ran(HEAD + cell.format("") + cell.format(""))["body"].count("<details") == 1, "one a page"
    assert "<details" not in ran(HEAD + silent.replace("%%", '%% tags=["shown"]') + "# %%\nguide.say('a')\n")["body"]
    assert shown.index(">x</span>") < shown.index("seven</p>") < shown.index("<details") < shown.index(">y</span>")


def test_a_lesson_begins_with_its_title(tmp_path: Path) -> None:
    (tmp_path / "lesson.py").write_text("# %%\nx = 1\n")
    with pytest.raises(InputError, match="begins with a cell of text"):
        title_of(cells_of(tmp_path / "lesson.py"))
