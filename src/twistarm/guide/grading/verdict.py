"""Verdicts on answers, and reports. A verdict names a typical mistake, or shows the first wrong case."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.errors import one_line
from ...support.messages import plural
from ..exercises.exercise import Exercise, whole
from ..exercises.words import PYTHON
from .answers import Failure, ReturnValue, flat, form_of, in_words, of_function

SEEN_DIGITS = 4
THEORY_OF = "twistarm.theory"
THEORY = ("screws", "poe", "rotations", "joints")  # Modules of twistarm.theory that the lessons use.
LARGEST_SHOWN = 16  # Numbers of an array that a sentence can show.

ENDINGS = {
    "SystemExit": ("ends the program (sys.exit)", ": leave that out"),
    "EOFError": ("reads from the keyboard (input)", ": leave that out; all that a function needs is in its arguments"),
    "MemoryError": ("takes more than 1 GB of memory", ": how large do its arrays get?"),
    "RecursionError": ("calls itself without end", ""),
}
"""Errors in words, and what to do about them."""

# The most lines, and letters of a line, that are shown of what the reader's code printed.
SHOWN_LINES, SHOWN_LETTERS = 12, 200

SIGNS = {"right": "✓", "wrong": "✗", "unwritten": "…", "unusable": "✗"}


@dataclass(frozen=True)
class Verdict:
    """The grader's verdict on one exercise.

    `state` is "right", "wrong", "unwritten" or "unusable". `slip` is the name of a known mistake. `words` are a
    sentence or a few for the reader.
    """

    exercise: str
    lesson: str
    state: str
    words: str
    slip: str = ""

    @property
    def ok(self) -> bool:
        """Whether it is right."""
        return self.state == "right"


@dataclass(frozen=True)
class Report:
    """The graded exercises and their verdicts.

    `problem` says in one sentence why the whole file cannot be used. For a syntax error, `excerpt` has its line and a
    caret below. `printed` is what the reader's code printed.
    """

    subject: str
    verdicts: tuple[Verdict, ...] = ()
    problem: str = ""
    excerpt: tuple[str, ...] = ()
    printed: str = ""

    @property
    def ok(self) -> bool:
        """Whether everything is right."""
        return not self.problem and all(verdict.ok for verdict in self.verdicts)

    @property
    def code(self) -> int:
        """The exit code: 0 if all is right, 1 if something is wrong or not written, 2 for an unusable file."""
        return 2 if self.problem else int(not self.ok)

    @property
    def lines(self) -> list[str]:
        """The report in words, a line for each verdict."""
        if self.problem:
            return [f"{self.subject}: {self.problem}", *self.excerpt]
        return [f"{SIGNS[verdict.state]} {verdict.exercise}: {verdict.words}" for verdict in self.verdicts]

    @property
    def printed_lines(self) -> list[str]:
        """The beginning of what the reader's code printed, where something is not right."""
        if self.ok or not self.printed.strip():
            return []
        lines = [line[:SHOWN_LETTERS] for line in self.printed.splitlines()]
        return lines if len(lines) <= SHOWN_LINES else [*lines[:SHOWN_LINES], "…"]

    @property
    def terminal_lines(self) -> list[str]:
        """The report for a terminal: its lines, and below them what was printed."""
        printed = [f"  {line}" for line in self.printed_lines]
        return [*self.lines, *(["", "your code printed:", *printed] if printed else [])]

    def __repr__(self) -> str:
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Case:
    """An instance: the arguments, and the answer that is right."""

    arguments: tuple[Any, ...]
    expected: ReturnValue


def cases_of(exercise: Exercise, arm: Arm, seed: int) -> list[Case]:
    """An exercise's instances with their answers, reproducible for one seed and arm."""
    rows = list(exercise.instances(np.random.default_rng(seed), arm))
    return [Case(row, of_function(exercise.reference, row)) for row in rows]


def judged(
    exercise: Exercise, cases: Sequence[Case], answers: Sequence[ReturnValue] | str, terms: Mapping[str, str] = PYTHON
) -> Verdict:
    """The verdict on a function's answers to the cases, in the terms of a language.

    `answers` is a text if the process ended early.
    """

    def verdict(state: str, words: str, slip: str = "") -> Verdict:
        return Verdict(exercise.name, exercise.lesson, state, words, slip)

    if isinstance(answers, str):
        return verdict("unusable", f"It {answers}")
    if any(answer.error is not None and answer.error.kind == "NotImplementedError" for answer in answers):
        return verdict("unwritten", "not written yet")
    if len(answers) < len(cases):
        return verdict("unusable", "It gave fewer answers than it was asked for")
    pairs = list(zip(cases, answers, strict=False))
    wrong = next((pair for pair in pairs if not _alike(exercise, *pair, pair[0].expected)), None)
    if wrong is None:
        if changed := sorted({exercise.parameters[i] for answer in answers for i in answer.changed}):
            words = f"{' and '.join(changed)} is another after the call: the caller finds it changed"
            copied = "Work on a copy, as in `p = p.copy()`."
            return verdict("wrong", f"The answers are right, but {words}. {copied}", "argument changed")
        return verdict("right", f"right, in {plural(len(cases), 'case')}")
    for slip in exercise.slips:
        function = exercise.wrong(slip)
        if all(_alike(exercise, case, answer, of_function(function, case.arguments)) for case, answer in pairs):
            return verdict("wrong", slip.words.format(**terms), slip.name)
    return verdict("wrong", _of_the_case(exercise, *wrong))


def _alike(exercise: Exercise, case: Case, answer: ReturnValue, other: ReturnValue) -> bool:
    """Whether an answer is another by form and numbers, the right one or a slip's. NaN equals NaN and an error."""
    if answer.error is not None and other.error is not None:
        return answer.error.kind == other.error.kind
    if answer.error is not None or other.error is not None:
        return answer.undefined and other.undefined
    if answer.form != other.form:
        return False
    a, b = answer.numbers, other.numbers
    if answer.form == case.expected.form and np.isfinite([*a, *b]).all():  # `seen` takes the part that is graded
        with np.errstate(all="ignore"):  # of an answer that is far away
            a, b = (flat(exercise.seen(side.value, *case.arguments)) for side in (answer, other))
    scale = max(1.0, float(np.abs(case.expected.numbers).max(initial=0.0)))
    return a.shape == b.shape and bool(np.allclose(a, b, rtol=0.0, atol=exercise.tolerance * scale, equal_nan=True))


def _of_the_case(exercise: Exercise, case: Case, answer: ReturnValue) -> str:
    """Words for an answer that no slip explains."""
    names = zip(exercise.parameters, case.arguments, strict=True)
    call = f"{exercise.name}({', '.join(f'{name}={_shown(value)}' for name, value in names)})"
    expected = in_words(form_of(case.expected.value))
    if answer.error is not None:
        return _of_error(exercise, answer.error, call)
    if answer.form == "None":
        return f"It returns nothing (None) where {expected} is expected: is a `return` missing?"
    if answer.form != case.expected.form:
        flat_is_right = answer.form in ((*case.expected.form, 1), (1, *case.expected.form))
        how = ": a vector has one axis here, as .ravel() gives it" if flat_is_right else ""
        return f"It returns {in_words(answer.form)} where {expected} is expected{how}."
    bad = answer.numbers[~np.isfinite(answer.numbers)]
    if bad.size:
        what = "NaN (not a number)" if np.isnan(bad).any() else "infinity"
        return f"It returns {what} for {call}: a division by 0, or a root, acos or logarithm out of its range."
    right, yours, where = case.expected.value, answer.value, ""
    if not isinstance(right, list) and np.size(right) > LARGEST_SHOWN:  # the first column or row that differs
        axis = int(np.ndim(right) == 2 and len(right) <= LARGEST_SHOWN)
        scale = max(1.0, float(np.abs(right).max()))
        differs = np.abs(np.subtract(right, yours)) > exercise.tolerance * scale
        k = int(np.argmax(differs.any(axis=tuple(n for n in range(np.ndim(right)) if n != axis))))
        where = f"{'Column' if axis else 'Row' if np.ndim(right) == 2 else 'Number'} {k + 1} of "
        right, yours = np.take(right, k, axis), np.take(yours, k, axis)
    known = "is" if exercise.seen is whole else "may be"
    return f"{where}{call} {known} {_shown(right)}, and yours gives {_shown(yours)}."


def _of_error(exercise: Exercise, error: Failure, call: str) -> str:
    if error.signature:
        parameters = ", ".join(exercise.parameters)
        return f"It takes {error.signature} and is called with ({parameters}): give it these arguments, in this order."
    where = f" in line {error.line}" if error.line else ""
    if error.kind in ("AttributeError", "TypeError") and (words := _of_a_name_taken(exercise, error.text)):
        return f"It stops{where}: {words}."
    request = "" if error.kind in ENDINGS or error.module else f"; it was asked for {call}"
    return f"It {why_stopped(error, where)}{request}."


def why_stopped(error: Failure, where: str = "") -> str:
    """What code does that stops with an error, after "it"."""
    if error.kind in ENDINGS:
        what, advice = ENDINGS[error.kind]
        return f"{what}{where}{advice}"
    if error.module:
        part = error.module.removeprefix("twistarm.")
        ours = f"where no module is: write `from twistarm import {part}`, or `from {THEORY_OF}.{part} import …`"
        why = ours if part in THEORY else "which is not installed: leave it out, or install it"
        return f"imports {error.module}{where}, {why}"
    raised = one_line(f"{error.kind}: {error.text}".rstrip(": "), 200)
    return f"stops{where} with {raised}"


def _of_a_name_taken(exercise: Exercise, text: str) -> str:
    """The problem, if an argument is used as its namesake module or function. Otherwise empty."""
    missing = re.fullmatch(r"'numpy.ndarray' object has no attribute '(\w+)'", text)
    for module in THEORY:
        if missing and hasattr(import_module(f"{THEORY_OF}.{module}"), missing[1]):
            hidden = f"where an argument has the name {module}, it hides the module; give the argument another name"
            return f"an array has no function {missing[1]}: {hidden}"
    if "'numpy.ndarray' object is not callable" in text:
        return f"an argument ({', '.join(exercise.parameters)}) is called as a function: is yours of the same name?"
    return ""


def _shown(value: Any) -> str:
    """A value on one line: a large array by its shape alone."""
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return f"({', '.join(map(_shown, value))})"
    if np.ndim(value) == 0:
        return f"{0.0 if abs(value) < 1e-12 else float(value):.6g}"
    if np.size(value) > LARGEST_SHOWN:
        return f"an array of shape {np.shape(value)}"
    text = np.array2string(np.asarray(value, float) + 0.0, precision=SEEN_DIGITS, suppress_small=True, separator=", ")
    return " ".join(text.split())
