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


def verdicts_on(text: str, path: Path) -> Iterator[Verdict]:
    """A verdict for each exercise of a results file, in words of Octave and MATLAB.

    None is right if the script did not run to its end.

    Raises:
        InputError: A line is not as the scripts write it.
        UnknownNameError: It names an exercise that there is not.
    """
    cases = cases_in(text, path)
    ended = f"# {len(cases)} cases" in text.splitlines()
    for name in dict.fromkeys(name for name, _ in cases):
        instances, answers = zip(*(case for (other, _), case in cases.items() if other == name), strict=True)
        verdict = judged(every_exercise()[name], instances, answers, OCTAVE)
        if verdict.ok and not ended:
            words = f"{verdict.words}, but others are missing in {path.name}: run the whole script again"
            verdict = replace(verdict, state="unusable", words=words)
        yield verdict


def cases_in(text: str, path: Path) -> dict[tuple[str, str], tuple[Case, ReturnValue]]:
    """The cases of a results file with their answers, by exercise and number."""
    exercises = every_exercise()
    rows: dict[tuple[str, str], dict[tuple[str, int], Any]] = {}
    for number, line in enumerate(text.splitlines()[1:], 2):
        if not line.strip() or line.startswith("#"):
            continue
        where = f"{path}, line {number}"
        try:
            name, case, what, k, height, width, *rest = line.split(",")
            if what not in ("argument", "answer", "error"):
                raise ValueError(what)
            shape = int(height), int(width)
            value: Any = (
                ",".join(rest) if what == "error" else np.array(list(map(float, rest))).reshape(shape, order="F")
            )
            rows.setdefault((name, case), {})[what, int(k)] = value
        except ValueError as error:
            why = f"it is not as the script writes it ({one_line(str(error), 80)}): run the script again"
            raise InputError(f"{where}: {why}") from error
        if name not in exercises:
            raise UnknownNameError(f"{where}: there is no exercise {one_line(name, 60)!r}{closest(name, exercises)}")
    if not rows:
        raise InputError(f"{path} holds no results: run the script again")
    return {key: _case(exercises[key[0]], row, path) for key, row in rows.items()}


def _case(exercise: Exercise, row: dict[tuple[str, int], Any], path: Path) -> tuple[Case, ReturnValue]:
    """A case in the forms of the exercise's instances. A row or column is a vector or a number where one is wanted."""
    axes = _axes(exercise.name)
    given = {k: numbers for (what, k), numbers in row.items() if what == "argument"}
    if sorted(given) != list(range(1, len(axes) + 1)):
        raise InputError(f"{path}: {exercise.name} takes {len(axes)} arguments; the file has {len(given)}")
    arguments = tuple(
        given[k] if count == 2 else given[k].ravel() if count == 1 else float(given[k].ravel()[0])
        for k, count in enumerate(axes, start=1)
    )
    expected = of_function(exercise.reference, arguments)
    if expected.error is not None or expected.undefined:
        raise InputError(f"{path}: the arguments of {exercise.name} are not those of the script: run it again")
    case = Case(arguments, expected)
    if ("answer", 0) not in row:
        text = row.get(("error", 0), "it gave no answer")
        kind = "NotImplementedError" if "not written yet" in text else "an error"
        return case, ReturnValue(error=Failure(kind, text))
    numbers, form = row["answer", 0], form_of(expected.value)
    if len(form) < 2 and 1 in numbers.shape and numbers.size == int(np.prod(form)):
        numbers = numbers.reshape(form)
    return case, of_function(lambda: numbers, ())


@cache
def _axes(exercise: str) -> tuple[int, ...]:
    """How many axes each argument of an exercise has, on any arm."""
    instances = every_exercise()[exercise].instances(np.random.default_rng(0), load_arm("rr_planar"))
    return tuple(np.ndim(argument) for argument in next(iter(instances)))
