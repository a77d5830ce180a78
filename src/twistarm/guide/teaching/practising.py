"""Exercises in a lesson: what is to be written, and what the reader wrote, graded."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from .. import grading
from ..exercises import exercises_of
from ..grading.processes import IN_SANDBOX
from ..grading.report import Report
from .arm import arm
from .outlet import show


def practice(lesson: str) -> None:
    """Show the exercises of a lesson, by its name: prompts, signatures, how to check, solutions behind a fold."""
    from .shown import Exercises

    fields = ("name", "prompt", "signature", "solution")
    show(Exercises(lesson, [{field: getattr(each, field) for field in fields} for each in exercises_of(lesson)]))


def check(function: Callable[..., Any]) -> Report:
    """Grade a function as the exercise of its name, on random instances and on the screws of `arm()`; show the verdict.

    Args:
        function: The reader's function; it is run in a copy of this process, for a limited time.

    Returns:
        The report: `ok` where everything is right. In a file that is being graded itself it is empty.

    Raises:
        InputError: It is no function.
        UnknownNameError: There is no exercise of its name; the closest one is named.
    """
    if os.environ.get(IN_SANDBOX):
        return Report(getattr(function, "__name__", ""))
    from .shown import Graded

    report = Graded(**vars(grading.check(function, arm())))
    show(report)
    return report
