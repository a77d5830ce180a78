"""The results file of the Octave and MATLAB exercises: arguments and answers as CSV.

A line is `exercise,case,argument,k,rows,columns,numbers…` or `exercise,case,answer,0,rows,columns,numbers…`, numbers
column by column, or `exercise,case,error,0,0,0,text`. The last line, `# N cases`, counts the cases.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...arm.loading.load import load_arm
from ...support.errors import InputError, UnknownNameError, closest, one_line
from ..exercises import Exercise, every_exercise
from ..exercises.words import OCTAVE
from .answers import Failure, ReturnValue, form_of, of_function
from .verdict import Case, Verdict, judged

HEADER = "# twistarm guide results 1"
"""The first line of such a file."""

Rows = dict[tuple[str, int], dict[str, Any]]


def verdicts_on(text: str, path: Path) -> Iterator[Verdict]:
    """A verdict for each exercise of a results file, in words of Octave and MATLAB.

    None is right if the script did not run to its end.
    """
    lines = text.splitlines()
    ran = {tuple(line.split(",")[:2]) for line in lines[1:] if line.strip() and not line.startswith("#")}
    whole = f"# {len(ran)} cases" in lines
    for exercise, cases, answers in read_results(text, path):
        verdict = judged(exercise, cases, answers, OCTAVE)
        if verdict.ok and not whole:
            words = f"{verdict.words}, but others are missing in {path.name}: run the whole script again"
            verdict = replace(verdict, state="unusable", words=words)
        yield verdict


def read_results(text: str, path: Path) -> Iterator[tuple[Exercise, list[Case], list[ReturnValue]]]:
    """Each exercise of a results file with its cases and the answers to them.

    Raises:
        InputError: A line is not as the scripts write it.
        UnknownNameError: It names an exercise that there is not.
    """
    rows: Rows = {}
    for number, line in enumerate(text.splitlines()[1:], 2):
        if line.strip() and not line.startswith("#"):
            _read(line, rows, f"{path}, line {number}")
    if not rows:
        raise InputError(f"{path} holds no results: run the script again")
    exercises = every_exercise()
    for name in dict.fromkeys(name for name, _ in rows):
        exercise = exercises[name]
        found = [each for (other, _), each in rows.items() if other == name]
        cases = [_case(exercise, each, path) for each in found]
        yield exercise, cases, [_answer(each, case) for each, case in zip(found, cases, strict=True)]


def _read(line: str, rows: Rows, where: str) -> None:
    """Note what one line says."""
    try:
        name, case, what, k, height, width, *rest = line.split(",")
        entry = rows.setdefault((name, int(case)), {"arguments": {}})
        if what == "error":
            entry["error"] = ",".join(rest)
        else:
            numbers = np.array([float(each) for each in rest]).reshape(int(height), int(width), order="F")
            if what == "argument":
                entry["arguments"][int(k)] = numbers
            elif what == "answer":
                entry["answer"] = numbers
            else:
                raise ValueError(what)
    except ValueError as error:
        why = f"it is not as the script writes it ({one_line(str(error), 80)}): run the script again"
        raise InputError(f"{where}: {why}") from error
    exercises = every_exercise()
    if name not in exercises:
        raise UnknownNameError(f"{where}: there is no exercise {one_line(name, 60)!r}{closest(name, exercises)}")


def _case(exercise: Exercise, entry: dict[str, Any], path: Path) -> Case:
    """The case of a line's arguments, in the forms of the exercise's instances."""
    given = entry["arguments"]
    forms = _forms(exercise.name)
    if sorted(given) != list(range(1, len(forms) + 1)):
        raise InputError(f"{path}: {exercise.name} takes {len(forms)} arguments; the file has {len(given)}")
    arguments = tuple(_as(given[i + 1], form) for i, form in enumerate(forms))
    expected = of_function(exercise.reference, arguments)
    if expected.error is not None or expected.undefined:
        raise InputError(f"{path}: the arguments of {exercise.name} are not those of the script: run it again")
    return Case(arguments, expected)


@cache
def _forms(exercise: str) -> tuple[int, ...]:
    """How many axes each argument of an exercise has, on any arm."""
    instances = every_exercise()[exercise].instances(np.random.default_rng(0), load_arm("rr_planar"))
    return tuple(np.ndim(each) for each in next(iter(instances)))


def _as(numbers: Any, axes: int) -> Any:
    return numbers if axes == 2 else numbers.ravel() if axes == 1 else float(numbers.ravel()[0])


def _answer(entry: dict[str, Any], case: Case) -> ReturnValue:
    """An answer. A row or column becomes a vector or a number if one is expected."""
    text = entry.get("error", None if "answer" in entry else "it gave no answer")
    if text is not None:
        return ReturnValue(error=Failure("NotImplementedError" if "not written yet" in text else "an error", text))
    numbers = entry["answer"]
    form = form_of(case.expected.value)
    if len(form) < 2 and 1 in numbers.shape and numbers.size == int(np.prod(form)):
        numbers = numbers.reshape(form)
    return of_function(lambda: numbers, ())
