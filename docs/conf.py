"""The site: Sphinx reads the Markdown pages beside this file, the docstrings and the program's own help.

Nothing is fetched, neither while it is built nor by who reads it: equations become MathML, which browsers draw.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import typer.main
from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from typer.cli import get_docs_for_click

from twistarm import __version__, load_arm
from twistarm.cli.application import app as program
from twistarm.viewer.saved_page import beside, of_arm

REPOSITORY = "https://github.com/twistarm/twistarm"

project, author, release = "twistarm", "the founders of twistarm", __version__
copyright = author
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = "twistarm"
html_static_path = ["_static", "../src/twistarm/guide/site/fonts", "../src/twistarm/guide/site/scripts/frames.js"]
html_css_files = ["site.css"]
html_js_files = [("frames.js", {"defer": ""})]
html_math_renderer = "mathml"
html_theme_options = {"source_repository": REPOSITORY, "source_branch": "main", "source_directory": "docs/"}
myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_heading_anchors = 3
suppress_warnings = ["ref.python"]  # `n` is an attribute of several classes
default_role = "code"  # `theta` in a docstring is code, as in Markdown
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
autodoc_type_aliases = {name: name for name in ("Array", "ArrayLike", "RealArray", "Matrix", "Row", "TargetLike")}
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
maximum_signature_line_length = 100


def visit_math(writer: Any, node: Any) -> None:
    """An equation within a line, as MathML."""
    writer.body.append(convert(node.astext()))
    raise nodes.SkipNode


def visit_displayed_math(writer: Any, node: Any) -> None:
    """An equation on a line of its own, as MathML."""
    writer.body.append(convert(node.astext(), display="block"))
    raise nodes.SkipNode


def commands() -> str:
    """Every command of the program with its arguments and options, in Markdown."""
    command = typer.main.get_command(program)
    context = command.make_context("twistarm", [], resilient_parsing=True)
    text = get_docs_for_click(obj=command, ctx=context, name="twistarm")
    return re.sub(r"\A.*?(?=^## )", "", text, flags=re.S | re.M)


# An arm to move, in place of the picture before it. In the repository it is a comment, and the picture stands.
ARM = r"<!-- arm (\w+) -->"
FRAME = r"""<iframe class="arm" data-src="_static/arms/\1.html" title="\1, to be moved by hand"></iframe>
<p class="arm"><a href="_static/arms/\1.html">Open it in a new window</a></p>"""


def write_arms(app: Sphinx, error: Exception | None) -> None:
    """The pages of the arms in frames, and the scripts that they share."""
    if error is not None or app.builder.format != "html":
        return
    folder = Path(app.outdir) / "_static" / "arms"
    folder.mkdir(exist_ok=True)
    texts = (page.read_text("utf-8") for page in sorted(Path(app.srcdir).glob("*.md")))
    for name in sorted({name for text in texts for name in re.findall(ARM, text)}):
        page, files = beside(of_arm(load_arm(name)))
        for file, content in {f"{name}.html": page.replace("<body>", '<body class="compact">', 1), **files}.items():
            (folder / file).write_text(content, "utf-8")


def complete(_app: Sphinx, _page: str, source: list[str]) -> None:
    """A page with the commands and arms in it; what it links to outside of the site lies in the repository."""
    text = source[0].replace("<!-- commands -->", commands() if "<!-- commands -->" in source[0] else "")
    text = re.sub(ARM, FRAME, text)
    source[0] = re.sub(r"\]\((?:\.\./)+([^)#]+)", rf"]({REPOSITORY}/blob/main/\1", text)


def escaped(_app: Sphinx, _what: str, _name: str, _obj: Any, _options: Any, lines: list[str]) -> None:
    """Bars of a docstring as they stand, |x| no substitution; what is between backticks is left alone."""
    for i, line in enumerate(lines):
        parts = line.split("`")
        lines[i] = "`".join(part.replace("|", "\\|") if k % 2 == 0 else part for k, part in enumerate(parts))


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", escaped)
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displayed_math, None))
    app.connect("source-read", complete)
    app.connect("build-finished", write_arms)


os.environ["COLUMNS"] = "100"
