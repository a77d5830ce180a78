"""The reader's side of a lesson: the arm that it runs on, and the exercises."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from functools import cache
from typing import Any

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...support.errors import InputError
from .. import grading
from ..exercises import exercises_of
from . import html
from .output import say, show

# Environment variable with what `load_arm` takes, as JSON: {"source": "my_arm.urdf.xacro", "tip": "tool0"}.
VARIABLE = "TWISTARM_GUIDE_ARM"
# Bundled arms that may replace the reader's, in this order.
BUNDLED = ("rover_arm", "rover_arm_6dof", "scara", "stanford", "rr_planar", "elbow")


def arm() -> Arm:
    """The arm that the lesson runs on: that of `TWISTARM_GUIDE_ARM`, else the bundled rover arm.

    Raises:
        InputError: The variable holds no JSON object with a source.
        TwistarmError: The arm cannot be loaded; the message says why.
    """
    return _loaded(os.environ.get(VARIABLE) or f'{{"source": "{BUNDLED[0]}"}}')


@cache
def bundled(name: str = BUNDLED[0]) -> Arm:
    """The rover arm that comes with twistarm (five joints), or another of the bundled arms."""
    return load_arm(name)


def arm_with(what: str, fits: Callable[[Arm], bool]) -> Arm:
    """The reader's arm if it fits, else the first fitting bundled one, with a sentence about it.

    Args:
        what: What the lesson needs, as the end of "does not have …": "three joints that turn".
        fits: Whether an arm has it.

    Returns:
        The arm.

    Raises:
        InputError: No bundled arm has it either.
    """
    own = arm()
    if fits(own):
        return own
    for name in BUNDLED:
        if fits(bundled(name)):
            say(
                f"Your arm, `{own.name}`, does not have {what}. This part of the lesson shows it on `{name}`, "
                "an arm that comes with twistarm."
            )
            return bundled(name)
    raise InputError(f"no bundled arm has {what}; the lesson can ask for {', '.join(BUNDLED)}")


@cache
def _loaded(text: str) -> Arm:
    try:
        keywords: dict[str, Any] = json.loads(text)
        source = keywords.pop("source")
    except (ValueError, AttributeError, TypeError, KeyError) as error:
        raise InputError(f'{VARIABLE} takes JSON like {{"source": "my_arm.urdf"}}; got {text!r}') from error
    return load_arm(source, **keywords)


def practice(lesson: str) -> None:
    """Show the exercises of a lesson by name: prompts, signatures, how to check, folded solutions."""
    entries = exercises_of(lesson)
    texts = [f"Exercise {k}: {e.name}\n\n{e.prompt}\n\n{e.signature}\n" for k, e in enumerate(entries, start=1)]
    how = f"To check: twistarm guide check guide_exercises/{lesson}.py"
    show("\n".join([*texts, how]), lambda _: html.exercises(lesson, entries))


def check(function: Callable[..., Any]) -> grading.Report:
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
    # A file that grades itself would start a copy in each copy, without end.
    if os.environ.get(grading.IN_SANDBOX):
        return grading.Report(getattr(function, "__name__", ""))
    report = _ShownReport(**vars(grading.check(function, arm())))
    show("\n".join(report.terminal_lines), lambda _: html.report(report.lines, report.printed_lines))
    return report


class _ShownReport(grading.Report):
    """A report that was shown when it was made."""

    def _ipython_display_(self) -> None:
        """Not shown again as the value of a notebook's cell."""
