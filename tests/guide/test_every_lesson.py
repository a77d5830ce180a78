"""Every lesson's program, with all that it claims, on the bundled arm and on one of six joints."""

from __future__ import annotations

import json
import runpy

import pytest

from twistarm.guide.course import lesson_file, lessons
from twistarm.guide.teaching import outlet
from twistarm.guide.teaching.arm import VARIABLE


@pytest.mark.parametrize("arm", ["rover_arm", pytest.param("rover_arm_6dof", marks=pytest.mark.slow)])
@pytest.mark.parametrize("lesson", lessons())
def test_the_lesson_holds(lesson: str, arm: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, json.dumps({"source": arm}))
    said: list[str] = []
    with outlet.installed(lambda shown: said.append(shown.plain)):
        runpy.run_path(str(lesson_file(lesson)), run_name="__main__")
    assert any(f"`{arm}`" in words or f" {arm} " in words for words in said), "it speaks of the reader's arm"
    assert "twistarm guide check" in said[-1], "it ends with its exercises"
