"""`guide`: the course on an arm, served or printed, with its exercises as commands."""

from __future__ import annotations

import hashlib
import json
import os
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any

import typer

from ...guide.building.building import Built, as_keywords, build
from ...guide.building.printing import pdf_of
from ...guide.building.server import SiteServer
from ...guide.course import lesson_named, lessons
from ...support.errors import DescriptionError, InputError
from ..options import takes_arm_option
from ..output import progress_bar, say, warn
from ..outputs import Force, outputs_of
from ..quantities import whole
from ..typed import Command, Group
from . import practising
from .viewing import Browser

guide = typer.Typer(
    name="guide",
    cls=Group,
    help="The course in the kinematics of arms, on your own arm, and its exercises, graded.",
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
@takes_arm_option
def course(
    source: str | None,
    load: dict[str, Any],
    context: typer.Context,
    output: Folder = None,
    port: Port = 0,
    browser: Browser = True,
) -> None:
    """Build the course on your arm and read it in the browser; served on this machine until Ctrl-C.

    Every lesson runs on the arm, two at a time, unless nothing has changed. With -o DIR it becomes a site that opens
    from disk, offline.
    """
    if context.invoked_subcommand is not None:
        _require_no_options(context)
        return
    built = _built(source, load, output)
    if output is not None:
        say(f"written: {built.start} (opens in a browser, offline)")
        raise typer.Exit(bool(built.failed))
    _serve(built, port, browser)


@guide.command("print", cls=Command)
@takes_arm_option
def print_lesson(
    source: str | None,
    load: dict[str, Any],
    lesson: Lesson,
    output: Annotated[str, typer.Option("--output", "-o", metavar="FILE", help="Where to write it, *.pdf.")],
    solutions: Annotated[
        bool, typer.Option("--solutions/--without-solutions", help="Whether the exercises have their solutions.")
    ] = True,
    force: Force = False,
) -> None:
    """Print one lesson as a PDF, its answers unfolded; needs Chromium, Chrome or Edge."""
    outputs = outputs_of(output, {"pdf": (".pdf",)}, force=force)
    name = lesson_named(lesson)
    built = _built(source, load, None, [name])
    outputs.say(outputs.write({"pdf": lambda: pdf_of(built.folder, name, solutions)}))
    raise typer.Exit(bool(built.failed))


for command in (practising.exercises, practising.check, practising.progress):
    guide.command(cls=Command)(command)


def _require_no_options(context: typer.Context) -> None:
    """Options of `guide` itself would say nothing to its commands, which have their own."""
    sources = [context.get_parameter_source(name) for name in context.params]
    if any(source is not None and source.name == "COMMANDLINE" for source in sources):
        command = context.invoked_subcommand
        raise InputError(f"give the options after the command: twistarm guide {command} … --arm ARM")


def _built(
    source: str | None, load: Mapping[str, Any], folder: Path | None, names: Sequence[str] | None = None
) -> Built:
    """The course on the typed arm, with its failures."""
    arm = as_keywords(source or "rover_arm", load)
    place = folder or _cache_folder(arm, names)
    try:
        with progress_bar(f"the guide on {source or 'rover_arm'}") as progress:
            built = build(place, arm, names, progress=progress)
    except DescriptionError as error:
        words = f"{error}; no page was written: twistarm doctor says all that is wrong with it"
        raise DescriptionError(words, error.findings) from error
    for words in built.failed:
        warn(words)
    return built


def _cache_folder(arm: Mapping[str, Any], names: Sequence[str] | None) -> Path:
    """The cache folder for the course on this arm; printed lessons are separate."""
    given = os.environ.get("XDG_CACHE_HOME", "")
    home = Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    root = Path(given) if os.path.isabs(given) and sys.platform != "darwin" else home
    digest = hashlib.sha256(json.dumps([arm, names], sort_keys=True).encode()).hexdigest()[:16]
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
