"""`guide`: the course on an arm, to read or to print, and its exercises, written and graded."""

from __future__ import annotations

import webbrowser
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from ...arm.arm import Arm
from ...guide.building.building import Built, build, pdf_of
from ...guide.course import lesson_named
from ...guide.exercises import LESSONS
from ...guide.exercises.files import HERE, write_exercises
from ...guide.grading import check_file
from ...guide.teaching.reader import arm as arm_of_the_lessons
from ...support.errors import DescriptionError, InputError
from ...support.files import as_path
from ..numbers import argument, option, switch, whole
from ..options import ArmCommand, ArmGroup, ArmOption, Json, Source, answers
from ..output import Outputs, progress_bar, say, warn

SITE = Path("guide_site")  # The folder of the site where nobody names another.

guide = typer.Typer(
    name="guide",
    cls=ArmGroup,
    help="The course in the kinematics of arms, on your own arm, and its exercises, graded.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

Folder = Annotated[
    Path | None,
    option("DIR", "Write the site into this folder, new or empty or built before, and end.", "--output", "-o"),
]
Browser = Annotated[bool, switch("Open the course in a browser.", "--browser/--no-browser")]


def lessons_like(typed: str) -> list[str]:
    """Completions of LESSON."""
    return [name for name in LESSONS if name.startswith(typed)]


Lesson = Annotated[str, argument("LESSON", "A lesson by its name.", autocompletion=lessons_like)]


@guide.callback(invoke_without_command=True)
def course(context: typer.Context, source: ArmOption = None, output: Folder = None, browser: Browser = True) -> None:
    """Build the course on your arm in the folder guide_site, and open it in the browser.

    Every lesson runs on the arm, two at a time, unless nothing has changed. The site opens from disk, offline. With -o
    DIR it is written there and not opened.
    """
    if context.invoked_subcommand is not None:
        # Options of `guide` itself would say nothing to its commands, which have their own.
        origins = [context.get_parameter_source(str(param.name)) for param in context.command.params]
        if any(origin is not None and origin.name == "COMMANDLINE" for origin in origins):
            command = context.invoked_subcommand
            raise InputError(f"give the options after the command: twistarm guide {command} … --arm ARM")
        return
    built = _built(source, SITE if output is None else output)
    say(f"written: {built.start} (opens in a browser, offline)")
    if output is None and browser and not webbrowser.open(built.start.as_uri()):
        warn("no browser found here; open the file yourself")
    raise typer.Exit(bool(built.failed))


Printed = Annotated[Outputs, answers("output force", {"pdf": (".pdf",)}, output="Where to write it; else LESSON.pdf.")]


@guide.command("print", cls=ArmCommand)
def print_lesson(
    lesson: Lesson,
    out: Printed,
    source: ArmOption = None,
    solutions: Annotated[
        bool, switch("Whether the exercises have their solutions.", "--solutions/--without-solutions")
    ] = True,
) -> None:
    """Print one lesson as a PDF, its answers unfolded; needs Chromium, Chrome or Edge."""
    name = lesson_named(lesson)
    out = out if out.files else out.named(f"{name}.pdf")
    with TemporaryDirectory(prefix="twistarm-guide-") as folder:
        built = _built(source, Path(folder), [name])
        out.say(out.write({"pdf": lambda: pdf_of(built.folder, name, solutions)}))
    raise typer.Exit(bool(built.failed))


@guide.command(cls=ArmCommand)
def exercises(
    folder: Annotated[Path, option("DIR", "The folder to write them into.", "--output", "-o")] = HERE,
    source: ArmOption = None,
) -> None:
    """Write the files to fill in: Python for each lesson, and Octave and MATLAB. No file is replaced."""
    written, stayed = write_exercises(folder, _arm(source))
    left = f"; {len(stayed)} existing files kept" if stayed else ""
    say(f"{folder}: {len(written)} files written{left}")
    say(f"next: open {folder / LESSONS[0]}.py, fill it in, and twistarm guide check {folder / LESSONS[0]}.py")


@guide.command(cls=ArmCommand)
def check(
    file: Annotated[str, argument("FILE", "A Python file, or a results file of Octave or MATLAB.")],
    out: Json,
    source: ArmOption = None,
    seed: Annotated[int, whole(0, 2**32, "Of the random instances.")] = 0,
) -> int:
    """Grade the exercises in FILE, on random instances and on the screws of the arm.

    The exit code is 0 if all is right, 1 if something is wrong or missing, 2 if FILE cannot be used.
    """
    report = check_file(as_path(file), _arm(source), seed)
    data = {
        "file": report.subject,
        "ok": report.ok,
        "problem": report.problem or None,
        "excerpt": report.excerpt,
        "exercises": [vars(verdict) | {"slip": verdict.slip or None} for verdict in report.verdicts],
        "printed": report.printed,
    }
    out.show(data, *report.terminal_lines)
    return report.code


def _arm(source: Source | None) -> Arm:
    return arm_of_the_lessons() if source is None else source.load()


def _built(source: Source | None, folder: Path, names: Sequence[str] | None = None) -> Built:
    """The course on the typed arm, with its failures."""
    typed = source or Source("rover_arm")
    arm = {"source": typed.name, **{name: value for name, value in typed.without_tool("an arm.toml").items() if value}}
    try:
        with progress_bar(f"the guide on {typed.name}") as progress:
            built = build(folder, arm, names, progress=progress)
    except DescriptionError as error:
        words = f"{error}; no page was written: twistarm doctor lists its faults"
        raise DescriptionError(words, error.findings) from error
    for words in built.failed:
        warn(words)
    return built
