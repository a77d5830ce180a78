"""The tasks for Octave and MATLAB: run by Octave, graded from what they wrote."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from twistarm import Arm
from twistarm.guide.exercises import every_exercise
from twistarm.guide.exercises.octave_files import MARK, SCRIPTS, octave_files, octave_solution, script_text, template
from twistarm.guide.exercises.words import OCTAVE, PYTHON
from twistarm.guide.grading import check_file
from twistarm.guide.grading.results import HEADER
from twistarm.support.errors import InputError, UnknownNameError

needs_octave = pytest.mark.skipif(
    shutil.which("octave") is None, reason="Octave is not installed: the tasks for Octave and MATLAB are not run"
)


def octave(folder: Path, script: str) -> Path:
    command = ["octave", "--no-gui", "--norc", "--no-history", "--quiet", f"run_{script}.m"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return folder / f"results_{script}.csv"


def written(folder: Path, script: str, arm: Arm, **edits: tuple[str, str]) -> Path:
    """The model solutions of a script in a folder, with edits {function: (old, new)}; the results."""
    for name in SCRIPTS[script]:
        text = octave_solution(name)
        old, new = edits.get(name, ("", ""))
        assert old in text
        (folder / f"{name}.m").write_text(text.replace(old, new) if old else text)
    (folder / f"run_{script}.m").write_text(script_text(script, arm))
    return octave(folder, script)


@needs_octave
@pytest.mark.parametrize(
    "script", ["rotations", *(pytest.param(name, marks=pytest.mark.slow) for name in SCRIPTS if name != "rotations")]
)
def test_the_model_solutions_are_right(script: str, tmp_path: Path, rover: Arm) -> None:
    report = check_file(written(tmp_path, script, rover), rover)
    assert [verdict.exercise for verdict in report.verdicts] == list(SCRIPTS[script])
    assert report.code == 0, report


@needs_octave
def test_slips_are_named(tmp_path: Path, rover: Arm) -> None:
    results = written(
        tmp_path,
        "rotations",
        rover,
        rotation_z=("[c, -s, 0; s, c, 0;", "[c, s, 0; -s, c, 0;"),
        zyz=("turn_z(alpha) * turn_y(beta) * turn_z(gamma)", "turn_z(gamma) * turn_y(beta) * turn_z(alpha)"),
        rodrigues=("W * W", "W .* W"),
        change_frame=("R_st * R_tc * q_c", "undefined_here"),
    )
    report = check_file(results, rover)
    assert [found.slip for found in report.verdicts] == ["transposed", "fixed for moved axes", "number by number", ""]
    assert "'undefined_here' undefined" in report.verdicts[3].words
    assert report.code == 1


@pytest.mark.slow
@needs_octave
def test_a_template_is_not_written_yet(tmp_path: Path, rover: Arm) -> None:
    for name, text in octave_files(rover):
        (tmp_path / name).write_text(text)
    report = check_file(octave(tmp_path, "rigid_motions"), rover)
    assert {verdict.state for verdict in report.verdicts} == {"unwritten"}


def test_a_template_says_what_to_do_and_not_how() -> None:
    for name in (name for names in SCRIPTS.values() for name in names):
        solution = octave_solution(name)
        assert every_exercise()[name].matlab == solution
        assert "not written yet" in template(solution)
        head, _, own = solution.partition(MARK)
        assert template(solution).startswith(head)
        assert own.splitlines()[0] not in template(solution)


def test_slips_speak_the_language_of_their_exercise() -> None:
    exercises = every_exercise()
    for slip in (slip for exercise in exercises.values() for slip in exercise.slips):
        assert "{" not in slip.words.format(**PYTHON)
    for slip in (slip for names in SCRIPTS.values() for name in names for slip in exercises[name].slips):
        assert not re.search(r"np\.|scipy|\.T\b| @", slip.words.format(**OCTAVE))


ANSWER = "rotation_z,1,argument,1,1,1,0.5\nrotation_z,1,answer,0,3,3"

BROKEN = [
    ("", "holds no results: run the script again"),
    ("rotation_z,1,argument\n", "line 2: it is not as the script writes it"),
    (f"{ANSWER},1,2\n", "line 3: it is not as the script writes it"),
    ("rotation_y,1,argument,1,1,1,2\n", "line 2: there is no exercise 'rotation_y'; closest: 'rotation_z'"),
    ("rotation_z,1,question,1,1,1,2\n", "question"),
    ("rotation_z,1,answer,0,1,1,2\n", "rotation_z takes 1 arguments; the file has 0"),
    ("rotation_log,1,argument,1,3,1,1,2,3\n", "the arguments of rotation_log are not those of the script"),
]


@pytest.mark.parametrize(("text", "words"), BROKEN)
def test_results_that_no_script_wrote(text: str, words: str, tmp_path: Path, rover: Arm) -> None:
    (tmp_path / "results.csv").write_text(f"{HEADER}\n{text}")
    with pytest.raises((InputError, UnknownNameError), match=words):
        check_file(tmp_path / "results.csv", rover)


def test_results_of_which_some_are_missing_are_not_right(tmp_path: Path, rover: Arm) -> None:
    one = f"{HEADER}\n{ANSWER},1,0,0,0,1,0,0,0,1\n".replace("1,1,1,0.5", "1,1,1,0")
    (tmp_path / "results.csv").write_text(one)
    (verdict,) = check_file(tmp_path / "results.csv", rover).verdicts
    assert (verdict.state, verdict.words.partition(",")[2]) == (
        "unusable",
        " in 1 case, but others are missing in results.csv: run the whole script again",
    )
    (tmp_path / "results.csv").write_text(f"{one}# 1 cases\n")
    assert check_file(tmp_path / "results.csv", rover).ok


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ("NaN,0,0,0,1,0,0,0,1", "NaN"),
        ("1,0,0,0,1,0,0,0,1", "rotation_z(alpha=0.5) is"),
        ("0" + ",0" * 10200, "It returns a very large array of shape (101, 101)"),
    ],
)
def test_results_that_are_wrong(numbers: str, words: str, tmp_path: Path, rover: Arm) -> None:
    side = round((numbers.count(",") + 1) ** 0.5)
    (tmp_path / "results.csv").write_text(f"{HEADER}\n{ANSWER},{numbers}\n".replace("0,3,3", f"0,{side},{side}"))
    report = check_file(tmp_path / "results.csv", rover)
    assert report.code == 1
    assert words in repr(report)
