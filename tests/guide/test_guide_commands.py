"""`twistarm guide`: exit codes, files, words, and the arm that a lesson runs on."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from small_course import LESSON
from test_cli import Capture, answer, error_of
from twistarm import InputError, guide
from twistarm.cli.application import run
from twistarm.guide.building.building import RECORD, Built
from twistarm.guide.exercises import LESSONS
from twistarm.guide.teaching import output
from twistarm.guide.teaching.reader import VARIABLE

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
    mine, deleted = (written / f"{lesson}.py" for lesson in LESSONS[:2])
    mine.write_text(RIGHT)
    deleted.unlink()
    assert run(["guide", "exercises", "-o", str(written)]) == 0
    assert mine.read_text() == RIGHT
    assert f"guide check {deleted}\n" in deleted.read_text()
    assert "1 files written; 34 existing files kept" in capsys.readouterr().out


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


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["--arm", "no_such_arm", "-o", "new"], "error: no arm 'no_such_arm' in the catalogue"),
        (["--arm", "broken.urdf", "-o", "new"], "; no page was written: twistarm doctor lists"),
        (["-o", "."], "holds something that the guide did not write"),
        (["print", "3_1_forward_kinematic", "-o", "a.pdf"], "closest: '3_1_forward_kinematics'"),
        (["print", LESSON, "-o", "none/a.pdf"], "does not exist; create it first"),
        (["--arm", "scara", "check", "a.py"], "give the options after the command: twistarm guide check … --arm ARM"),
        (["check", "a.py", "--tip", "hand"], "give an ARM: the options for loading need one"),
    ],
)
def test_what_cannot_be_is_one_sentence(typed: list[str], words: str, here: Path, capsys: Capture) -> None:
    Path("broken.urdf").write_text("<robot name='r'><link name='a'/><joint")
    assert words in error_of(capsys, "guide", *typed)
    assert [path.name for path in here.iterdir()] == ["broken.urdf"]


def test_what_was_built_is_said(built: Built, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole course is a long test's; here it is that of one lesson, which is built already."""
    monkeypatch.setattr("twistarm.guide.building.building.LESSONS", (LESSON,))
    assert run(["guide", "-o", str(built.folder)]) == 0
    assert capsys.readouterr().out == f"written: {built.folder / 'index.html'} (opens in a browser, offline)\n"
    assert (built.folder / RECORD).is_file()
    opened: list[str] = []
    monkeypatch.setattr("twistarm.cli.commands.guide.SITE", built.folder)
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert run(["guide"]) == 0
    assert opened == [(built.folder / "index.html").as_uri()]


def test_it_is_the_readers_or_the_rover(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert guide.arm().name == "rover_arm"
    monkeypatch.setenv(VARIABLE, json.dumps({"source": "scara"}))
    assert guide.arm().name == "scara"


@pytest.mark.parametrize("text", ["{", "[]", "{}", "3"])
def test_a_variable_that_means_nothing_is_said(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(InputError, match="TWISTARM_GUIDE_ARM takes JSON like"):
        guide.arm()


def test_another_stands_in_and_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, json.dumps({"source": "rr_planar"}))
    texts: list[str] = []
    with output.installed(lambda shown: texts.append(shown.plain)):
        assert guide.arm_with("two joints", lambda arm: arm.n == 2).name == "rr_planar"
        assert texts == []
        assert guide.arm_with("six joints", lambda arm: arm.n == 6).n == 6
    assert texts[0].startswith("Your arm, `rr_planar`, does not have six joints.")
    with pytest.raises(InputError, match="no bundled arm has ninety joints"):
        guide.arm_with("ninety joints", lambda arm: arm.n == 90)
