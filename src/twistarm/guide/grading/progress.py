"""The progress of a reader: a readable JSON file in the folder of the exercises."""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path
from typing import Any

from ...support.errors import InputError
from ...support.files import NO_SUCH_FILE, read_bounded, why_no_file, write_whole
from ...support.strict_json import parsed
from .verdict import Report

NAME = "progress.json"
FORMAT = "twistarm guide progress 1"
LARGEST = 2**20


def read_progress(folder: Path) -> dict[str, dict[str, Any]]:
    """{exercise: {"state", "slip", "tries", "file", "checked"}}; empty where nothing was graded yet.

    Raises:
        InputError: The file there is not one of ours.
    """
    path = folder / NAME
    if (why := why_no_file(path)) == NO_SUCH_FILE:
        return {}
    try:
        content = parsed(read_bounded(path, LARGEST).decode()) if not why else None
    except (OSError, ValueError):
        content = None
    exercises = content.get("exercises") if isinstance(content, dict) and content.get("format") == FORMAT else None
    if not isinstance(exercises, dict) or not all(isinstance(each, dict) for each in exercises.values()):
        raise InputError(f"{path} is no progress file of the guide (or was damaged): move it away, and it begins anew")
    return exercises


def folder_with_progress(given: Path, usual: Path) -> Path:
    """The folder with the progress: the given one, or the usual one in it.

    Raises:
        InputError: It is no folder, or holds no progress.
    """
    if not given.is_dir():
        raise InputError(f"{given}: {why_no_file(given) or 'a file'}; give the folder of your exercises")
    for each in (given, given / usual):
        if why_no_file(each / NAME) != NO_SUCH_FILE:
            return each
    raise InputError(
        f"{given} holds no exercises ({NAME} is missing): give their folder, or write them by "
        "`twistarm guide exercises -o DIR`"
    )


def folder_of(path: Path) -> Path:
    """The folder with a graded file's progress: the file's, or the one above if only that has progress."""
    own = path.absolute().parent
    above = why_no_file(own / NAME) == NO_SUCH_FILE and not why_no_file(own.parent / NAME)
    return own.parent if above else own


def begun(folder: Path) -> None:
    """Make the file if missing, so notebooks in that folder are recorded too."""
    if why_no_file(folder / NAME) == NO_SUCH_FILE:
        _write(folder, {})


def save_report(folder: Path, report: Report, only_there: bool = False) -> str:
    """Note a report in the folder's file. Returns a sentence if that fails; the report is valid either way.

    With `only_there` nothing is written if the folder has no such file.
    """
    if not report.verdicts or (only_there and why_no_file(folder / NAME)):
        return ""
    try:
        exercises = read_progress(folder)
        for each in report.verdicts:
            before = exercises.get(each.exercise, {})
            tries = before.get("tries", 0)
            exercises[each.exercise] = {
                "lesson": each.lesson,
                "state": each.state,
                "slip": each.slip or None,
                "tries": (tries if isinstance(tries, int) else 0) + (each.state != "unwritten"),
                "file": report.subject,
                "checked": datetime.now().astimezone().isoformat(timespec="seconds"),
            }
        _write(folder, exercises)
    except InputError as error:
        return f"progress is not kept: {error}"
    return ""


def _write(folder: Path, exercises: dict[str, dict[str, Any]]) -> None:
    text = json.dumps({"format": FORMAT, "exercises": exercises}, indent=2, ensure_ascii=False) + "\n"
    write_whole(folder / NAME, text)
