"""`guide`: the course on an arm, served or printed, and its exercises, written and graded."""

from __future__ import annotations

import hashlib
import json as text_of_json
import os
import sys
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from ...arm.arm import Arm
from ...guide.building.building import Built, as_keywords, build
from ...guide.building.printing import pdf_of
from ...guide.building.server import SiteServer
from ...guide.course import lesson_named, lessons
from ...guide.exercises import LESSONS, exercises_of
from ...guide.exercises.files import HERE, write_exercises
from ...guide.grading import check_file
from ...guide.grading.progress import begun, folder_of, folder_with_progress, read_progress, save_report
from ...guide.grading.verdict import SIGNS
from ...guide.teaching.arm import arm as arm_of_the_lessons
from ...support.errors import DescriptionError, InputError
from ...support.files import as_path
from ..command import Command
from ..options import ArmCommand, ArmGroup, ArmOption, Json, Source
from ..output import progress_bar, say, warn
from ..outputs import Force, Outputs, outputs_of
from ..quantities import whole
from ..tables import Column, Table
from .viewing import Browser

guide = typer.Typer(
    name="guide",
    cls=ArmGroup,
    help="The course in the kinematics of arms, on your own arm, and its exercises, graded.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Folder = Annotated[
    Path | None,
    typer.Option(
        "--output", "-o", metavar="DIR", help="Write the site into this folder, new or empty or built before, and end."
    ),
]
Port = Annotated[int, whole(0, 65535, "Port to serve on, on this machine alone; 0: a free one.")]


def lessons_like(typed: str) -> list[str]:
    """Completions of LESSON."""
    return [name for name in lessons() if name.startswith(typed)]


Lesson = Annotated[str, typer.Argument(metavar="LESSON", help="A lesson by its name.", autocompletion=lessons_like)]


@guide.callback(invoke_without_command=True)
def course(
    context: typer.Context, source: ArmOption = None, output: Folder = None, port: Port = 0, browser: Browser = True
) -> None:
    """Build the course on your arm and read it in the browser; served on this machine until Ctrl-C.

    Every lesson runs on the arm, two at a time, unless nothing has changed. With -o DIR it becomes a site that opens
    from disk, offline.
    """
    if context.invoked_subcommand is not None:
        _require_no_options(context)
        return
    built = _built(source, output)
    if output is not None:
        say(f"written: {built.start} (opens in a browser, offline)")
        raise typer.Exit(bool(built.failed))
    _serve(built, port, browser)


@guide.command("print", cls=ArmCommand)
def print_lesson(
    lesson: Lesson,
    output: Annotated[str, typer.Option("--output", "-o", metavar="FILE", help="Where to write it, *.pdf.")],
    source: ArmOption = None,
    solutions: Annotated[
        bool, typer.Option("--solutions/--without-solutions", help="Whether the exercises have their solutions.")
    ] = True,
    force: Force = False,
) -> None:
    """Print one lesson as a PDF, its answers unfolded; needs Chromium, Chrome or Edge."""
    outputs = outputs_of(output, {"pdf": (".pdf",)}, force=force)
    name = lesson_named(lesson)
    built = _built(source, None, [name])
    outputs.say(outputs.write({"pdf": lambda: pdf_of(built.folder, name, solutions)}))
    raise typer.Exit(bool(built.failed))


@guide.command(cls=ArmCommand)
def exercises(
    folder: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="The folder to write them into.")
    ] = HERE,
    source: ArmOption = None,
) -> None:
    """Write the files to fill in: Python for each lesson, and Octave and MATLAB. No file is replaced."""
    written, stayed = write_exercises(folder, _arm(source))
    begun(folder)
    left = f", {len(stayed)} that were there left as they are" if stayed else ""
    say(f"{folder}: {len(written)} files written{left}")
    say(f"next: open {folder / LESSONS[0]}.py, fill it in, and twistarm guide check {folder / LESSONS[0]}.py")


@guide.command(cls=ArmCommand)
def check(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A Python file, or a results file of Octave or MATLAB.")],
    source: ArmOption = None,
    seed: Annotated[int, whole(0, 2**32, "Of the random instances.")] = 0,
    json: Json = False,
) -> int:
    """Grade the exercises in FILE, on random instances and on the screws of the arm.

    The exit code is 0 if all is right, 1 if something is wrong or missing, 2 if FILE cannot be used.
    """
    path = as_path(file)
    report = check_file(path, _arm(source), seed)
    trouble = save_report(folder_of(path), report)
    data = {
        "file": report.subject,
        "ok": report.ok,
        "problem": report.problem or None,
        "excerpt": report.excerpt,
        "exercises": [vars(each) | {"slip": each.slip or None} for each in report.verdicts],
        "printed": report.printed,
    }
    Outputs(json=json).show(data, *report.told)
    if trouble:
        warn(trouble)
    return report.code


@guide.command(cls=Command)
def progress(
    folder: Annotated[str, typer.Argument(metavar="DIR", help="The folder of the exercises.")] = ".", json: Json = False
) -> None:
    """Show which exercises are done, and what was said of the others."""
    found = read_progress(folder_with_progress(as_path(folder), HERE))
    states = {lesson: _states(lesson, found) for lesson in LESSONS}
    todo = []
    for lesson in LESSONS:
        tried = {name: each for name, each in states[lesson].items() if each["state"] != "right" and each["tries"]}
        todo.append(", ".join(f"{name} ({each['slip']})" if each["slip"] else name for name, each in tried.items()))
    right = [[each["state"] == "right" for each in states[lesson].values()] for lesson in LESSONS]
    columns = [
        Column("lesson", LESSONS),
        Column("right", [f"{sum(each)} of {len(each)}" for each in right]),
        Column("", ["".join(SIGNS[each["state"]] for each in states[lesson].values()) for lesson in LESSONS]),
        Column("still to do", todo),
    ]
    count = f"{sum(map(sum, right))} of {sum(map(len, right))} exercises are right"
    Outputs(json=json).show(states, Table("", columns), count)


def _arm(source: Source | None) -> Arm:
    return arm_of_the_lessons() if source is None else source.load()


def _states(lesson: str, found: dict[str, dict[str, Any]]) -> dict[str, dict[str, Any]]:
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


def _require_no_options(context: typer.Context) -> None:
    """Options of `guide` itself would say nothing to its commands, which have their own."""
    origins = [context.get_parameter_source(str(param.name)) for param in context.command.params]
    if any(origin is not None and origin.name == "COMMANDLINE" for origin in origins):
        command = context.invoked_subcommand
        raise InputError(f"give the options after the command: twistarm guide {command} … --arm ARM")


def _built(source: Source | None, folder: Path | None, names: Sequence[str] | None = None) -> Built:
    """The course on the typed arm, with its failures."""
    typed = source or Source("rover_arm")
    arm = as_keywords(typed.name, typed.keywords)
    place = folder or _cache_folder(arm, names)
    try:
        with progress_bar(f"the guide on {typed.name}") as progress:
            built = build(place, arm, names, progress=progress)
    except DescriptionError as error:
        words = f"{error}; no page was written: twistarm doctor says all that is wrong with it"
        raise DescriptionError(words, error.findings) from error
    for words in built.failed:
        warn(words)
    return built


def _cache_folder(arm: dict[str, Any], names: Sequence[str] | None) -> Path:
    """The cache folder for the course on this arm; printed lessons are separate."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    home = Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    root = Path(given) if os.path.isabs(given) and sys.platform != "darwin" else home
    digest = hashlib.sha256(text_of_json.dumps([arm, names], sort_keys=True).encode()).hexdigest()[:16]
    place = root / "twistarm" / "guide" / digest
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot use {place}: {error.strerror or error}; give a folder by -o DIR") from error
    return place


def _serve(built: Built, port: int, browser: bool) -> None:
    with SiteServer(built.folder, port) as server:
        say(f"the guide on {built.arm.name} at {server.url}  (Ctrl-C ends it)")
        if browser and not webbrowser.open(server.url):
            warn("no browser found here; open the address yourself, or use -o DIR for a site that needs no server")
        with suppress(KeyboardInterrupt):
            server.serve_forever()
