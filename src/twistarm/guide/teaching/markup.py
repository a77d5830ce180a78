"""Markdown as HTML: formulae as MathML, coloured programs; raw HTML is escaped."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import Any

from ...support.errors import InputError, missing_extra

# Letters of a displayed formula that a telephone may have to scroll, so that a keyboard has to reach it.
LONG = 36

THIN = '<mspace width="0.167em"></mspace>'

FUNCTION = "<mi>(?:arc)?(?:sin|cos|tan|exp|log|ln)</mi>"

POWER = r"(?:<m[in]>[^<]*</m[in]>|<mrow>(?:(?!</?mrow>).)*</mrow>)"

ACCENTED = '<mover accent="true">(?:(?!</?mover).)*</mover>'


def block(markdown: str) -> str:
    """Paragraphs, lists, tables, headings."""
    return _together(_renderer().render(markdown))


def inline(markdown: str) -> str:
    """A line of text, without a paragraph around it."""
    return _together(_renderer().renderInline(markdown))


def _together(html: str) -> str:
    """Keep a formula and the punctuation around it on one line."""
    alone = r'<span class="math inline">(?:(?!</span>).)*</span>'
    return re.sub(
        rf"\({alone}[,.;:?!)]*|{alone}[,.;:?!)]+", r'<span class="together">\g<0></span>', html, flags=re.DOTALL
    )


def formula(tex: str, *, display: bool = False) -> str:
    """A TeX formula as MathML, with the TeX as text for screen readers."""
    from latex2mathml.converter import convert

    try:
        mathml: str = convert(tex, display="block" if display else "inline")
    except Exception as error:
        raise InputError(f"the formula {tex!r} cannot be read: {str(error) or type(error).__name__}") from error
    if unknown := re.search(r"\\\w+", re.sub(r"<[^>]*>", " ", mathml)):
        raise InputError(f"the formula {tex!r} cannot be read: no MathML is known for {unknown[0]}")
    # cos θ, but cos(θ): a function's name is an operator, which that library writes as a letter.
    mathml = re.sub(rf"((?<!<msup>){FUNCTION}|<msup>{FUNCTION}{POWER}</msup>)(?=<m(?!o))", rf"\1{THIN}", mathml)
    mathml = re.sub(rf"(</m(?:i|n|sub|sup|subsup|over|frac)>)(?=(?:<msup>)?{FUNCTION})", rf"\1{THIN}", mathml)
    mathml = mathml.replace('<mo movablelimits="true">', '<mo movablelimits="true" lspace="0">')
    # A dot sits close above its letter, and an exponent stands as high beside θ̇ as beside θ.
    mathml = mathml.replace("<mover>", '<mover accent="true">')
    mathml = re.sub(rf"(<(?:msup|msubsup)>(?:<mrow>)?)({ACCENTED})", r'\1<mpadded height="0.66em">\2</mpadded>', mathml)
    scrolls = 'tabindex="0" ' if display and len(tex) > LONG else ""
    return mathml.replace("<math ", f'<math {scrolls}alttext="{escape(tex)}" ', 1)


def program(source: str) -> str:
    """A Python program in colours, which the style sheet gives."""
    from pygments import highlight
    from pygments.formatters import HtmlFormatter
    from pygments.lexers import PythonLexer

    html: str = highlight(source, PythonLexer(), HtmlFormatter(nowrap=True))
    return f'<pre class="code" tabindex="0"><code>{html.rstrip()}</code></pre>'


def slug(text: str) -> str:
    """A heading's name in an address."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "section"


@cache
def _renderer() -> Any:
    try:
        from markdown_it import MarkdownIt
        from mdit_py_plugins.dollarmath import dollarmath_plugin
    except ImportError as error:
        raise missing_extra("the guide", error.name or "markdown-it-py", "guide") from error
    renderer = MarkdownIt("commonmark", {"html": False, "highlight": _fence}).enable("table")
    dollarmath_plugin(
        renderer, double_inline=True, renderer=lambda tex, options: formula(tex, display=options["display_mode"])
    )
    renderer.add_render_rule("heading_open", _heading)
    renderer.block.ruler.at("list", _list, {"alt": ["paragraph", "reference", "blockquote"]})
    return renderer


def _list(state: Any, first: int, last: int, silent: bool) -> bool:
    """A markdown list. A number at the start of a sentence's line does not begin one.

    A numbered list begins a paragraph, with 1, and has a second entry.
    """
    from markdown_it.rules_block import list_block

    lines = [state.src[state.bMarks[k] : state.eMarks[k]] for k in range(first, last)]
    number = re.match(r"\s*(\d+)[.)](?:\s|$)", lines[0])
    next_entry = silent and state.sCount[first] < state.blkIndent
    alone = number and (silent or number[1] != "1" or not any(re.match(r"\s*2[.)]\s", line) for line in lines))
    if alone and not next_entry:
        return False
    return bool(list_block(state, first, last, silent))


def _fence(source: str, language: str, _: str) -> str:
    return program(source) if language == "python" else f'<pre class="code words"><code>{escape(source)}</code></pre>'


def _heading(renderer: Any, tokens: Any, index: int, options: Any, env: Any) -> str:
    tag = tokens[index].tag
    return f'<{tag} id="{slug(tokens[index + 1].content)}">'
