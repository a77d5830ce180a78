"""`twistarm guide check`, `progress` and `exercises`: exit codes, files, words."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from test_cli import Capture, error_of
from twistarm.cli.application import run
from twistarm.guide.exercises import LESSONS, every_exercise
from twistarm.guide.grading.progress import FORMAT, NAME

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


def test_check_keeps_the_progress(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "mine.py"
    file.write_text(RIGHT.replace("-sin(a)", "sin(a)").replace("[sin(a), cos", "[-sin(a), cos"))
    assert run(["guide", "check", str(file)]) == 1
    assert "✗ rotation_z: This is the transpose" in capsys.readouterr().out
    kept = json.loads((tmp_path / NAME).read_text())
    assert kept["format"] == FORMAT
    assert kept["exercises"]["rotation_z"]["slip"] == "transposed"
    assert run(["guide", "progress", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told[LESSONS[0]]["rotation_z"] == {"state": "wrong", "slip": "transposed", "tries": 1}
    file.write_text(RIGHT)
    assert run(["guide", "check", str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["exercises"][0]["state"] == "right"
    assert json.loads((tmp_path / NAME).read_text())["exercises"]["rotation_z"]["tries"] == 2


def test_progress_fits_a_terminal_of_80_columns(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    state = {"state": "wrong", "slip": "fixed for moved axes", "tries": 3}
    content = {"format": FORMAT, "exercises": dict.fromkeys(("zyz", "rotation_z", "zyz_angles", "zyzz"), state)}
    (tmp_path / NAME).write_text(json.dumps(content))
    assert run(["guide", "progress", str(tmp_path)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert all(len(line) <= 80 for line in lines)
    assert any("2_1_1_rotation_matrices" in line and "0 of 3" in line for line in lines)
    assert "fixed for moved axes" in " ".join(lines)
    assert lines[-1] == f"0 of {len(every_exercise())} exercises are right"


@pytest.mark.parametrize(
    "content", ["{", '{"format": "of another program"}', f'{{"format": "{FORMAT}", "exercises": [1]}}']
)
def test_a_progress_file_that_is_not_ours_is_left_alone(content: str, tmp_path: Path, capsys: Capture) -> None:
    (tmp_path / NAME).write_text(content)
    assert run(["guide", "progress", str(tmp_path)]) == 2
    assert "is no progress file of the guide" in capsys.readouterr().err
    if content != "{":
        return
    (tmp_path / "mine.py").write_text(RIGHT)
    assert run(["guide", "check", str(tmp_path / "mine.py")]) == 0
    assert "warning: progress is not kept" in capsys.readouterr().err
    assert (tmp_path / NAME).read_text() == content


def test_progress_of_nothing_is_said(tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "no such file" in error_of(capsys, "guide", "progress", str(tmp_path / "nowhere"))
    monkeypatch.chdir(tmp_path)
    assert "progress.json is missing" in error_of(capsys, "guide", "progress")
    assert run(["guide", "exercises"]) == 0
    capsys.readouterr()
    assert run(["guide", "progress"]) == 0  # beside the folder that `exercises` makes
    assert "0 of " in capsys.readouterr().out


def test_a_function_that_is_imported_is_nobody_s_answer(tmp_path: Path, capsys: Capture) -> None:
    file = tmp_path / "2_3_velocities.py"
    file.write_text("from twistarm.theory.screws import adjoint, exp\n")
    assert run(["guide", "check", str(file)]) == 1
    assert "… adjoint: it is imported, and counts where you define it" in capsys.readouterr().out
    file = tmp_path / "mine.py"
    file.write_text(f"from twistarm.theory.screws import adjoint\n{RIGHT}")
    assert run(["guide", "check", str(file)]) == 0
    assert "adjoint" not in capsys.readouterr().out
    kept = json.loads((tmp_path / NAME).read_text())["exercises"]
    assert kept["adjoint"]["state"] == "unwritten"
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
    assert not (tmp_path / NAME).exists()
    assert "no_such_arm" in error_of(capsys, "guide", "check", str(file), "--arm", "no_such_arm")


def test_results_below_the_folder_count_in_it(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text(json.dumps({"format": FORMAT, "exercises": {}}))
    (tmp_path / "octave").mkdir()
    (tmp_path / "octave" / "mine.py").write_text(RIGHT)
    assert run(["guide", "check", str(tmp_path / "octave" / "mine.py")]) == 0
    assert "rotation_z" in json.loads((tmp_path / NAME).read_text())["exercises"]
