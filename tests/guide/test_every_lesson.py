"""Every lesson's program, with all that it claims, on the bundled arm and on one of six joints."""

from __future__ import annotations

import ast
import json
import runpy
from itertools import pairwise

import pytest

from twistarm.guide.building.cells import cells_of
from twistarm.guide.course import lesson_file, lessons
from twistarm.guide.teaching import outlet
from twistarm.guide.teaching.arm import VARIABLE


@pytest.mark.parametrize("lesson", lessons())
def test_no_answer_without_its_question(lesson: str) -> None:
    """What is behind a fold answers a question, and what a view or a reader is asked is answered."""
    cells = cells_of(lesson_file(lesson))
    for before, cell in pairwise(cells):
        if "reveal" in cell.tags:
            assert not before.code, f"line {cell.line}: its question stands in the text before"
            assert "?" in before.source.split("\n\n")[-1], f"line {cell.line}: an answer to no question"
    calls = [
        (cell.line, ast.unparse(node.func), ast.unparse(node))
        for cell in cells
        for node in ast.walk(ast.parse(cell.source if cell.code else ""))
        if isinstance(node, ast.Call)
    ]
    said = [each for each in calls if each[1] in ("guide.predict", "guide.slider", "guide.scene")]
    for (line, kind, words), (_, after, _) in pairwise([*said, (0, "", "")]):
        assert kind != "guide.scene" or "?" not in words or after == "guide.predict", f"line {line}: it is not answered"


@pytest.mark.parametrize("arm", ["rover_arm", pytest.param("rover_arm_6dof", marks=pytest.mark.slow)])
@pytest.mark.parametrize("lesson", lessons())
def test_the_lesson_holds(lesson: str, arm: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, json.dumps({"source": arm}))
    said: list[str] = []
    with outlet.installed(lambda shown: said.append(shown.plain)):
        runpy.run_path(str(lesson_file(lesson)), run_name="__main__")
    assert any(f"`{arm}`" in words or f" {arm} " in words for words in said), "it speaks of the reader's arm"
    assert "twistarm guide check" in said[-1], "it ends with its exercises"
