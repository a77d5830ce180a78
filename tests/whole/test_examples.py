"""The examples run and assert what they claim; tests/guide runs the lessons."""

from __future__ import annotations

import runpy
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from twistarm.support.checks import Array
from twistarm.viewer import Viewer

EXAMPLES = Path(__file__).parents[2] / "examples"
PROGRAMS = sorted(file for file in EXAMPLES.rglob("[0-9]*.py") if "ros2" not in file.relative_to(EXAMPLES).parts)


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: str(path.relative_to(EXAMPLES)))
def test_it_runs_from_any_directory(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [str(program)])
    monkeypatch.syspath_prepend(program.parent)
    runpy.run_path(str(program), run_name="__main__")
    assert capsys.readouterr().out.strip(), "a lesson says what it found"
    assert list(tmp_path.iterdir()) == []


def test_a_task_plays_in_the_view(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[Array] = []

    def wait(viewer: Viewer) -> None:
        latest = time.monotonic() + 20.0
        seen.append(viewer.theta)
        while np.array_equal(viewer.theta, seen[0]) and time.monotonic() < latest:
            time.sleep(0.02)
        seen.append(viewer.theta)

    monkeypatch.syspath_prepend(EXAMPLES)
    monkeypatch.setattr(Viewer, "wait", wait)
    monkeypatch.setattr(Viewer, "open_page", lambda viewer: True)
    monkeypatch.setattr(sys, "argv", ["06_swing_a_latch.py", "--view"])
    motion = runpy.run_path(str(EXAMPLES / "06_swing_a_latch.py"))["motion"]
    path = motion(np.linspace(0.0, motion.duration, 4001))
    assert np.abs(path - seen[1]).max(axis=1).min() < 2e-3
    assert not np.array_equal(seen[0], seen[1])
