"""Exercises in a lesson: what is to be written, and what the reader wrote, graded."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from .. import grading
from ..exercises import exercises_of
from ..grading.running import IN_SANDBOX
from ..grading.verdict import Report
from .arm import arm
from .outlet import show


def practice(lesson: str) -> None:
    """Show the exercises of a lesson by name: prompts, signatures, how to check, folded solutions."""
    from . import html

    entries = exercises_of(lesson)
    texts = [f"Exercise {k}: {e.name}\n\n{e.prompt}\n\n{e.signature}\n" for k, e in enumerate(entries, start=1)]
    how = f"To check: twistarm guide check guide_exercises/{lesson}.py"
    show("\n".join([*texts, how]), lambda _: html.exercises(lesson, entries))


def check(function: Callable[..., Any]) -> Report:
    """Grade a function as the exercise of its name and show the verdict.

    The instances are random and the screws of `arm()`.

    Args:
        function: The reader's function. A copy of this process runs it for a limited time.

    Returns:
        The report: `ok` where everything is right. In a file that is being graded itself it is empty.

    Raises:
        InputError: It is no function.
        UnknownNameError: There is no exercise of its name; the closest one is named.
    """
    if os.environ.get(IN_SANDBOX):
        return Report(getattr(function, "__name__", ""))
    from . import html

    report = _Shown(**vars(grading.check(function, arm())))
    show("\n".join(report.told), lambda _: html.report(report.lines, report.printed_lines))
    return report


class _Shown(Report):
    """A report that was shown when it was made."""

    def _ipython_display_(self) -> None:
        """Not shown again as the value of a notebook's cell."""
