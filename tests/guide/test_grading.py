"""Grading in a process of its own: whatever a reader's file does, it is told in a sentence, and nothing is lost."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest

from twistarm import Arm
from twistarm.guide import check
from twistarm.guide.exercises import every_exercise
from twistarm.guide.exercises.files import python_text
from twistarm.guide.grading import Report, check_file
from twistarm.guide.grading.answers import ReturnValue
from twistarm.guide.grading.verdict import cases_of, judged
from twistarm.guide.teaching import output
from twistarm.support.errors import InputError, UnknownNameError

RIGHT = """
import numpy as np
def rotation_z(alpha):
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
"""


def returning(value: str) -> str:
    return f"import numpy as np\ndef rotation_z(a):\n    return {value}\n"


HARM = [
    ("os._exit", "import os\ndef rotation_z(a):\n    os._exit(0)\n", 1, "It ended the whole process, as os._exit does"),
    ("sys.exit", "import sys\ndef rotation_z(a):\n    sys.exit(0)\n", 1, "It ends the program (sys.exit) in line 3"),
    ("endless at once", "# rotation_z\nwhile True: pass\n", 2, "while it was read it was not done after 1.5 s"),
    (
        "endless print",
        "def rotation_z(a):\n    while True:\n        print('x' * 100)\n",
        1,
        "It was not done after 1.5 s",
    ),
    ("killed", "import os\ndef rotation_z(a):\n    os.kill(os.getpid(), 9)\n", 1, "was ended by SIGKILL"),
    ("recursion", returning("rotation_z(a)"), 1, "It calls itself without end in line 3"),
    ("memory", returning("np.ones(3 * 10**9)"), 1, "more than 1 GB of memory"),
    ("no module", "import nowhere_at_all\ndef rotation_z(a): return 1\n", 2, "it imports nowhere_at_all, which is not"),
    ("keyboard", returning("float(input('? '))"), 1, "It reads from the keyboard (input) in line 3"),
    ("error at once", "# rotation_z\nx = 1 / 0\n", 2, "line 2: it stops with ZeroDivisionError: division by zero"),
    ("no return", "def rotation_z(a):\n    3\n", 1, "nothing (None) where an array of shape (3, 3) is expected"),
    ("shape", returning("np.eye(4)"), 1, "It returns an array of shape (4, 4) where an array of shape (3, 3)"),
    ("complex", returning("np.eye(3) * 1j"), 1, "It returns a value of type array of complex128"),
    ("NaN", returning("np.full((3, 3), np.nan)"), 1, "It returns NaN (not a number) for rotation_z(alpha="),
    ("another name", "def rotation_zz(a):\n    return 1\n", 2, "functions are 'rotation_zz'; closest: 'rotation_z'"),
    ("empty", "", 2, "it has none of the exercises: it defines no functions"),
    ("deep", "rotation_z = " + "(" * 5000 + ")" * 5000, 2, ""),
    ("a child that goes on", "import subprocess\nsubprocess.Popen(['sleep', '60'])\n" + RIGHT, 0, "right"),
    (
        "no traceback of ours",
        "class E(Exception):\n    def __str__(self): raise ValueError\ndef rotation_z(a):\n    raise E\n",
        1,
        "rotation_z: It",
    ),
    ("given the main guard", RIGHT + "\nif __name__ == '__main__':\n    1 / 0\n", 0, "right"),
    (
        "checks itself",
        RIGHT + "\nfrom twistarm import guide\nassert not guide.check(rotation_z).verdicts\n",
        0,
        "right",
    ),
]


def graded(folder: Path, text: str, arm: Arm, name: str = "mine.py") -> Report:
    (folder / name).write_text(text)
    return check_file(folder / name, arm, seconds=1.5)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [pytest.param(*rest, id=what, marks=pytest.mark.slow if "endless" in what else ()) for what, *rest in HARM],
)
def test_a_file_that_does_harm(text: str, code: int, words: str, tmp_path: Path, rover: Arm) -> None:
    began = time.monotonic()
    report = graded(tmp_path, text, rover)
    assert words in repr(report), report
    assert report.code == code, report
    assert all(len(line) < 700 and "Traceback" not in line for line in report.lines)
    assert time.monotonic() - began < 30


def test_after_one_endless_loop_the_others_are_graded(tmp_path: Path, rover: Arm) -> None:
    text = RIGHT + "import time\ndef zyz(a, b, c):\n    while True: time.sleep(1)\ndef zyz_angle(R):\n    return 1\n"
    report = graded(tmp_path, text, rover, "2_1_1_rotation_matrices.py")
    assert [verdict.state for verdict in report.verdicts] == ["right", "unusable", "unwritten"]
    assert report.verdicts[1].words.startswith("It was not done after 1.5 s")
    assert report.verdicts[2].words == "there is no function zyz_angles; did you mean it by 'zyz_angle'?"


def test_syntax_is_shown_with_its_line_and_a_caret(tmp_path: Path, rover: Arm) -> None:
    report = graded(tmp_path, "\nif True:\n    x = = 3\n", rover)
    assert report.problem.startswith("line 3: ")
    assert report.excerpt == ("    x = = 3", "        ^")


@pytest.mark.slow
def test_megabytes_that_are_printed_are_cut(tmp_path: Path, rover: Arm) -> None:
    report = graded(tmp_path, "for k in range(200_000):\n    print('x' * 100)\n" + RIGHT, rover)
    assert report.ok
    assert len(report.printed) == 10_000


@pytest.mark.slow
def test_templates_load_and_are_not_written_yet(tmp_path: Path, rover: Arm) -> None:
    for lesson in dict.fromkeys(exercise.lesson for exercise in every_exercise().values()):
        report = graded(tmp_path, python_text(lesson), rover, f"{lesson}.py")
        assert {verdict.state for verdict in report.verdicts} == {"unwritten"}
        assert report.code == 1


@pytest.mark.slow
def test_solutions_are_right_in_a_process_of_their_own(tmp_path: Path, rover: Arm) -> None:
    for lesson in dict.fromkeys(exercise.lesson for exercise in every_exercise().values()):
        solutions = [exercise.solution for exercise in every_exercise().values() if exercise.lesson == lesson]
        head = "from __future__ import annotations\nimport numpy as np\n\n"
        (tmp_path / f"{lesson}.py").write_text(head + "\n\n".join(solutions))
        report = check_file(tmp_path / f"{lesson}.py", rover)
        assert report.code == 0, report


def test_what_is_no_file_to_grade(tmp_path: Path, rover: Arm) -> None:
    with pytest.raises(InputError, match="no such file; give the Python file"):
        check_file(tmp_path / "nowhere.py", rover)
    with pytest.raises(InputError, match="a folder"):
        check_file(tmp_path, rover)
    (tmp_path / "latin.py").write_bytes("# schön\n".encode("latin-1"))
    with pytest.raises(InputError, match=r"is no UTF-8 text \(byte 6 is 0xf6\): save it as UTF-8"):
        check_file(tmp_path / "latin.py", rover)


def test_in_a_notebook(here: Path, rover: Arm) -> None:
    calls = []

    def rotation_z(alpha: float) -> object:
        calls.append(alpha)
        print("from the copy")
        return np.array([[np.cos(alpha), np.sin(alpha), 0], [-np.sin(alpha), np.cos(alpha), 0], [0, 0, 1]])

    shown: list[output.Shown] = []
    with output.installed(shown.append):
        report = check(rotation_z)
    (report_shown,) = shown
    assert report_shown.plain.splitlines()[2:4] == ["your code printed:", "  from the copy"]
    assert "<li>✗ rotation_z: This is the transpose" in report_shown.html(None)
    assert "<samp>from the copy" in report_shown.html(None)
    assert report.verdicts[0].slip == "transposed"
    assert "from the copy" in report.printed
    assert not calls  # it ran in a copy of this process
    assert not list(here.iterdir())

    def rotation_y(alpha: float) -> object:
        return None

    with pytest.raises(UnknownNameError, match="there is no exercise 'rotation_y'; closest: 'rotation_z'"):
        check(rotation_y)
    with pytest.raises(InputError, match="without a call"):
        check(rotation_z(0.1))  # type: ignore[arg-type]


def test_of_a_large_answer_the_part_that_differs_is_shown(rover: Arm) -> None:
    exercise = every_exercise()["adjoint"]
    cases = cases_of(exercise, rover, 0)
    wrong = [np.array(case.expected.value) for case in cases]
    wrong[0][4, 2] += 1.0
    verdict = judged(exercise, cases, [ReturnValue(value) for value in wrong])
    assert verdict.words.startswith("Column 3 of adjoint(g=[[")
    assert verdict.words.count("[") == 5 + 2  # of the argument, and of both columns


def test_an_argument_that_hides_a_module_is_named(tmp_path: Path, rover: Arm) -> None:
    text = (
        "from twistarm import screws\n"
        "def product_of_exponentials(screws, home, x):\n    return screws.exp(screws[:, 0], x[0]) @ home\n"
    )
    (verdict,) = graded(tmp_path, text, rover).verdicts
    assert "where an argument has the name screws, it hides the module" in verdict.words


def test_a_changed_argument_is_named(rover: Arm) -> None:
    exercise = every_exercise()["transform_points"]
    cases = cases_of(exercise, rover, 0)
    answers = [ReturnValue(case.expected.value, changed=(1,)) for case in cases]
    verdict = judged(exercise, cases, answers)
    assert (verdict.state, verdict.slip) == ("wrong", "argument changed")
    assert "points_t is another after the call" in verdict.words
