"""`twistarm guide` as it is typed: a sentence for each thing that cannot be."""

from __future__ import annotations

from pathlib import Path

import pytest

from small_course import LESSON
from test_cli import Capture, error_of
from twistarm.cli.application import run
from twistarm.guide.building.building import RECORD, Built


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        (["--arm", "no_such_arm", "-o", "new"], "error: no arm 'no_such_arm' in the catalogue"),
        (["--arm", "broken.urdf", "-o", "new"], "; no page was written: twistarm doctor says all"),
        (["-o", "."], "holds something that the guide did not write"),
        (["print", "3_1_forward_kinematic", "-o", "a.pdf"], "closest: '3_1_forward_kinematics'"),
        (["print", LESSON, "-o", "none/a.pdf"], "does not exist; create it first"),
        (["--arm", "scara", "check", "a.py"], "give the options after the command: twistarm guide check … --arm ARM"),
        (["check", "a.py", "--tip", "hand"], "give an ARM: the other options are about one"),
    ],
)
def test_what_cannot_be_is_one_sentence(
    typed: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("broken.urdf").write_text("<robot name='r'><link name='a'/><joint")
    assert words in error_of(capsys, "guide", *typed)
    assert [path.name for path in tmp_path.iterdir()] == ["broken.urdf"]


def test_what_was_built_is_said(built: Built, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole course is a long test's; here it is that of one lesson, which is built already."""
    monkeypatch.setattr("twistarm.guide.building.building.lessons", lambda: (LESSON,))
    assert run(["guide", "-o", str(built.folder)]) == 0
    assert capsys.readouterr().out == f"written: {built.folder / 'index.html'} (opens in a browser, offline)\n"
    assert (built.folder / RECORD).is_file()
