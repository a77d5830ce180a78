"""`twistarm guide check` and `exercises`: exit codes, files, words."""

from __future__ import annotations

from pathlib import Path

import pytest

from test_cli import Capture, answer, error_of
from twistarm.cli.application import run
from twistarm.guide.exercises import LESSONS

RIGHT = """
from math import cos, sin
def rotation_z(a):
    return [[cos(a), -sin(a), 0], [sin(a), cos(a), 0], [0, 0, 1]]
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("reader") / "exercises"
    assert run(["guide", "exercises", "-o", str(folder)]) == 0
    return folder


def test_the_files_to_fill_in_are_written_and_never_overwritten(written: Path, capsys: Capture) -> None:
    assert {f"{lesson}.py" for lesson in LESSONS} <= {path.name for path in written.iterdir()}
    assert {"run_rotations.m", "rotation_z.m", "run_manipulator.m"} <= {p.name for p in (written / "octave").iterdir()}
    mine = written / f"{LESSONS[0]}.py"
    mine.write_text(RIGHT)
    (written / f"{LESSONS[1]}.py").unlink()
    assert run(["guide", "exercises", "-o", str(written)]) == 0
    assert mine.read_text() == RIGHT
    assert (written / f"{LESSONS[1]}.py").is_file()
    assert "1 files written, 34 that were there left as they are" in capsys.readouterr().out


def test_check_names_the_mistake(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "mine.py"
    file.write_text(RIGHT.replace("-sin(a)", "sin(a)").replace("[sin(a), cos", "[-sin(a), cos"))
    (found,) = answer(capsys, "guide", "check", str(file), code=1)["exercises"]
    assert (found["exercise"], found["state"], found["slip"]) == ("rotation_z", "wrong", "transposed")
    file.write_text(RIGHT)
    assert answer(capsys, "guide", "check", str(file))["exercises"][0]["state"] == "right"


def test_a_function_that_is_imported_is_nobody_s_answer(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "2_3_velocities.py"
    file.write_text("from twistarm.theory.screws import adjoint, exp\n")
    assert run(["guide", "check", str(file)]) == 1
    assert "… adjoint: it is imported, and counts where you define it" in capsys.readouterr().out
    file = tmp_path / "mine.py"
    file.write_text(f"from twistarm.theory.screws import adjoint\n{RIGHT}")
    assert run(["guide", "check", str(file)]) == 0
    assert "adjoint" not in capsys.readouterr().out
    file.write_text(f"from twistarm.screws import exp\n{RIGHT}")
    assert run(["guide", "check", str(file)]) == 2
    words = "it imports twistarm.screws, where no module is: write `from twistarm import screws`"
    assert words in capsys.readouterr().out


def test_what_cannot_be_used(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "mine.py"
    file.write_text("def rotation_z(a:\n")
    assert run(["guide", "check", str(file)]) == 2
    out = capsys.readouterr().out.splitlines()
    assert out[0].startswith("mine.py: line 1: ")
    assert out[2].strip() == "^"
    assert "no_such_arm" in error_of(capsys, "guide", "check", str(file), "--arm", "no_such_arm")
