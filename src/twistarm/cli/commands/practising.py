"""`guide check`, `guide progress`, `guide exercises`: the exercises of the guide, graded."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...guide.exercises import LESSONS, exercises_of
from ...guide.exercises.files import HERE, write_exercises
from ...guide.grading import Report, check_file
from ...guide.grading.progress import begun, folder_of, folder_with_progress, read_progress, save_report
from ...guide.grading.verdict import SIGNS
from ...guide.teaching.arm import arm as arm_of_the_lessons
from ...support.files import as_path
from ..options import Json, takes_arm_option
from ..output import console, print_json, say, table, warn
from ..quantities import whole


@takes_arm_option
def check(
    source: str | None,
    load: dict[str, Any],
    file: Annotated[str, typer.Argument(metavar="FILE", help="A Python file, or a results file of Octave or MATLAB.")],
    seed: Annotated[int, whole(0, 2**32, "Of the random instances.")] = 0,
    json: Json = False,
) -> int:
    """Grade the exercises in FILE, on random instances and on the screws of the arm.

    The exit code is 0 if all is right, 1 if something is wrong or missing, 2 if FILE cannot be used.
    """
    path = as_path(file)
    report = check_file(path, _arm(source, load), seed)
    trouble = save_report(folder_of(path), report)
    if json:
        print_json(_as_json(report))
    else:
        say(*report.told)
    if trouble:
        warn(trouble)
    return report.code


def progress(
    folder: Annotated[str, typer.Argument(metavar="DIR", help="The folder of the exercises.")] = ".", json: Json = False
) -> None:
    """Show which exercises are done, and what was said of the others."""
    found = read_progress(folder_with_progress(as_path(folder), HERE))
    states = {lesson: _of_lesson(lesson, found) for lesson in LESSONS}
    if json:
        print_json(states)
        return
    columns = ["lesson", "right", "", "still to do"]
    console().print(table("", columns, [_row(lesson, states[lesson]) for lesson in LESSONS], text=["", "still to do"]))
    every = [each["state"] == "right" for of_lesson in states.values() for each in of_lesson.values()]
    say(f"{sum(every)} of {len(every)} exercises are right")


def _row(lesson: str, states: dict[str, dict[str, Any]]) -> list[str]:
    """A lesson's line: the number of right ones, a sign for each, the last verdicts."""
    tried = {name: each for name, each in states.items() if each["state"] != "right" and each["tries"]}
    words = ", ".join(f"{name} ({each['slip']})" if each["slip"] else name for name, each in tried.items())
    signs = "".join(SIGNS[each["state"]] for each in states.values())
    right = sum(each["state"] == "right" for each in states.values())
    return [lesson, f"{right} of {len(states)}", signs, words]


@takes_arm_option
def exercises(
    source: str | None,
    load: dict[str, Any],
    folder: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder to write them into.")
    ] = HERE,
) -> None:
    """Write the files to fill in: Python for each lesson, and Octave and MATLAB. No file is replaced."""
    written, stayed = write_exercises(folder, _arm(source, load))
    begun(folder)
    left = f", {len(stayed)} that were there left as they are" if stayed else ""
    say(f"{folder}: {len(written)} files written{left}")
    say(f"next: open {folder / LESSONS[0]}.py, fill it in, and twistarm guide check {folder / LESSONS[0]}.py")


def _arm(source: str | None, load: dict[str, Any]) -> Arm:
    return arm_of_the_lessons() if source is None else load_arm(source, **load)


def _of_lesson(lesson: str, found: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """State, slip and tries of each exercise of a lesson."""
    states = {}
    for exercise in exercises_of(lesson):
        kept_of_it = found.get(exercise.name, {})
        state = kept_of_it.get("state")
        states[exercise.name] = {
            "state": state if state in SIGNS else "unwritten",
            "slip": kept_of_it.get("slip"),
            "tries": kept_of_it.get("tries", 0),
        }
    return states


def _as_json(report: Report) -> dict[str, Any]:
    return {
        "file": report.subject,
        "ok": report.ok,
        "problem": report.problem or None,
        "excerpt": report.excerpt,
        "exercises": [vars(each) | {"slip": each.slip or None} for each in report.verdicts],
        "printed": report.printed,
    }
