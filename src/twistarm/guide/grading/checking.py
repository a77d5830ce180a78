"""Grade a reader's file, a results file of Octave or MATLAB, or a function of a notebook."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...arm.arm import Arm
from ...support.errors import InputError, UnknownNameError, closest, listed, quote
from ...support.files import read_bounded, why_no_file
from ..exercises import LESSONS, Exercise, every_exercise, exercises_of
from .results import HEADER, verdicts_on
from .running import SECONDS, Run, run, run_function
from .verdict import Report, Verdict, cases_of, judged

LARGEST_FILE = 2**24  # Bytes of a reader's file or of a results file.


def check(function: Callable[..., Any], arm: Arm, seed: int = 0) -> Report:
    """Grade a function as the exercise of its name, in a copy of this process.

    Args:
        function: The reader's function.
        arm: The arm with the screws among the instances.
        seed: Of the random instances.

    Returns:
        The report.

    Raises:
        InputError: It is no function.
        UnknownNameError: There is no exercise of its name.
    """
    if not callable(function) or not hasattr(function, "__code__"):
        raise InputError(f"check takes a function, as in check(rotation_z), without a call; got {quote(function)}")
    name = function.__name__
    if function.__module__.startswith("twistarm."):
        raise InputError(f"{name} is that of {function.__module__}: check takes the one that you have written")
    exercises = every_exercise()
    if name not in exercises:
        raise UnknownNameError(f"there is no exercise {name!r}{closest(name, exercises)}")
    cases = cases_of(exercises[name], arm, seed)
    result = run_function(function, name, [case.arguments for case in cases])
    return Report(name, (judged(exercises[name], cases, result.answers[name]),), printed=result.printed)


def check_file(path: Path, arm: Arm, seed: int = 0, seconds: float = SECONDS) -> Report:
    """Grade the exercises in a Python file, or in a results file of Octave or MATLAB.

    A file named as a lesson (`2_1_1_quaternions.py`) must have all its exercises. In others those found are graded.

    Args:
        path: The file.
        arm: The arm with the screws among the instances.
        seed: Of the random instances.
        seconds: Time for the file, and for each exercise.

    Returns:
        The report; also where the file has an error.

    Raises:
        InputError: There is no such file, or it is no text.
    """
    text = _text(path)
    if text.startswith(HEADER):
        return Report(path.name, tuple(verdicts_on(text, path)))
    expected = {exercise.name for exercise in exercises_of(path.stem)} if path.stem in LESSONS else set()
    mentioned = expected | set(re.findall(r"\w+", text))
    exercises = {name: exercise for name, exercise in every_exercise().items() if name in mentioned}
    cases = {name: cases_of(exercise, arm, seed) for name, exercise in exercises.items()}
    instances = {name: [case.arguments for case in rows] for name, rows in cases.items()}
    result = run(text, path.name, path.absolute().parent, instances, seconds)
    verdicts = [
        judged(exercise, cases[name], result.answers[name]) if name in result.answers else _missing(exercise, result)
        for name, exercise in exercises.items()
        if name in result.answers or name in expected
    ]
    problem = result.problem
    if not problem and not verdicts:
        functions = f"its functions are {listed(result.own)}" if result.own else "it defines no functions"
        near = next((words for name in result.own if (words := closest(name, every_exercise()))), "")
        problem = f"it has none of the exercises: {functions}{near}; `twistarm guide exercises` writes files to fill in"
    return Report(path.name, () if problem else tuple(verdicts), problem, result.excerpt, result.printed)


def _text(path: Path) -> str:
    """What a file holds; InputError where that is no text."""
    try:
        return read_bounded(path, LARGEST_FILE).decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path} is no UTF-8 text (byte {error.start + 1} is 0x{error.object[error.start]:02x}): save it as UTF-8"
        ) from error
    except (OSError, ValueError) as error:  # a name that cannot be a file's is a ValueError
        what = "give the Python file, or the results file, that is to be graded"
        raise InputError(f"{path}: {why_no_file(path, error)}; {what}") from error


def _missing(exercise: Exercise, result: Run) -> Verdict:
    if exercise.name in result.functions:
        words = "it is imported, and counts where you define it: write it in this file"
    else:
        near = closest(exercise.name, [name for name in result.own if name not in every_exercise()])
        meant = f"; did you mean it by {near[len('; closest: ') :]}?" if near else ""
        words = f"there is no function {exercise.name}{meant}"
    return Verdict(exercise.name, exercise.lesson, "unwritten", words)
