"""Prose of the package, held by rules: a module's first line says what the module is."""

from __future__ import annotations

import ast
import re
from pathlib import Path

PACKAGE = Path(__file__).parent.parent / "src" / "twistarm"

QUESTION = re.compile(r"(What|Which|How|Who|Whether|Where|When)\b|$")


def test_each_first_line_says_what_the_module_is():
    modules = [path for path in sorted(PACKAGE.rglob("*.py")) if "viewer" not in path.parts]
    firsts = {path: ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "" for path in modules}
    asking = {str(path.relative_to(PACKAGE)): text for path, text in firsts.items() if QUESTION.match(text)}
    assert not asking
