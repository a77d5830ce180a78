"""Every lesson's program, and what it claims, on many arms.

The claims on a lesson are in `claims`, in a file of its name: asserts below the titles of its sections. They see the
names of the lesson at the end of their section.
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from model_arms import REAL_ARMS
from twistarm.description.catalog import own_arms
from twistarm.guide.building.lesson import cells_of
from twistarm.guide.course import LESSONS, lesson_file
from twistarm.guide.teaching import output
from twistarm.guide.teaching.reader import VARIABLE, arm

CLAIMS = Path(__file__).with_name("claims")


def claims_on(lesson: str) -> dict[str, Any]:
    """The claims on each section, as code that knows its lines."""
    path = CLAIMS / f"{lesson}.py"
    head, *parts = re.split(r"^# ## (.*)$", path.read_text("utf-8"), flags=re.MULTILINE)
    line, claims = head.count("\n"), {}
    for title, text in zip(parts[::2], parts[1::2], strict=True):
        claims[title] = compile("\n" * line + text, str(path), "exec")
        line += text.count("\n")
    return claims


def run(lesson: str, scenes: Path | None) -> list[str]:
    """Run a lesson with the claims on it. Returns what it says."""
    said: list[str] = []

    def show(shown: output.Shown) -> None:
        said.append(shown.plain)
        if scenes:
            shown.html(scenes)

    names: dict[str, Any] = {"__name__": "__main__"}
    claims, title = claims_on(lesson), ""
    with output.installed(show):
        for cell in cells_of(lesson_file(lesson)):
            if cell.code:
                exec(compile("\n" * (cell.line - 1) + cell.source, str(lesson_file(lesson)), "exec"), names)
            elif titles := re.findall(r"^## (.*)$", cell.source, flags=re.MULTILINE):
                exec(claims.pop(title, ""), dict(names))
                title = titles[-1]
    assert not claims, "each belongs to a section"
    return said


@pytest.mark.parametrize("lesson", LESSONS)
def test_the_lesson_holds(lesson: str) -> None:
    said = run(lesson, None)
    assert any("`rover_arm`" in words or " rover_arm " in words for words in said), "it speaks of the reader's arm"
    assert "twistarm guide check" in said[-1], "it ends with its exercises"


@pytest.mark.parametrize("lesson", LESSONS)
def test_a_program_that_is_not_folded_fits_a_glance(lesson: str) -> None:
    assert all(cell.source.count("\n") < 20 for cell in cells_of(lesson_file(lesson)) if cell.shown)


@pytest.mark.slow
@pytest.mark.parametrize("lesson", LESSONS)
@pytest.mark.parametrize(
    ("source", "options"), [*((name, {}) for name in own_arms() if name != "rover_arm"), *REAL_ARMS]
)
def test_the_lesson_holds_on_every_arm(
    source: str,
    options: dict[str, Any],
    lesson: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    file = str(request.getfixturevalue("models") / source) if "." in source else source
    monkeypatch.setenv(VARIABLE, json.dumps({"source": file, **options}))
    assert any(arm().name in words for words in run(lesson, tmp_path))
