"""Markdown as HTML: formulae, programs, and names from a reader's file that must not become HTML."""

from __future__ import annotations

import re

import pytest

from twistarm import InputError
from twistarm.guide.teaching.html import html_of
from twistarm.guide.teaching.markup import block, formula, inline
from twistarm.guide.teaching.tex import rough, tex


def test_formulae_are_mathml_that_says_itself_in_tex() -> None:
    html = block("Be $\\theta_1 < 2$, and\n\n$$e^{\\hat\\xi\\theta}$$\n")
    assert html.count("<math ") == 2
    assert 'alttext="\\theta_1 &lt; 2"' in html
    assert 'display="block"' in html
    assert "$" not in html


def test_a_displayed_formula_may_stand_in_a_sentence() -> None:
    assert inline("So $$R = I$$ it is.").count('display="block"') == 1


@pytest.mark.parametrize("tex", ["x^", "{", r"\begin{bmatrix} 1", r"2 \nosuch"])
def test_a_formula_that_cannot_be_read_is_named(tex: str) -> None:
    with pytest.raises(InputError, match=re.escape(f"the formula {tex!r} cannot be read: ")):
        formula(tex)


def test_nothing_from_a_name_becomes_html() -> None:
    name = "</pre><script>alert(1)</script>"
    data = [
        {"kind": "text", "markdown": f"`{name}` {name}"},
        {"kind": "table", "head": [name], "rows": [[name]], "caption": name},
        {"kind": "figure", "svg": "<svg></svg>", "alt": f'"{name}', "caption": name},
        {"kind": "prediction", "question": name, "answer": name},
    ]
    assert not [each["kind"] for each in data if "<script" in html_of(each)]


def test_numbers_in_tex() -> None:
    assert tex([1, -0.0, 0.12345], 2) == "(1.00, 0.00, 0.12)"
    assert tex([[1, 2]], 0) == r"\begin{bmatrix} 1 & 2 \end{bmatrix}"
    assert rough(2.2e-16) == r"2 \cdot 10^{-16}"
    assert rough(0.0) == "0"
    with pytest.raises(InputError, match=r"shape \(1, 1, 1\)"):
        tex([[[1]]])
