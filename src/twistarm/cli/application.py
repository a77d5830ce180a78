"""The program: its commands and its handling of errors."""

from __future__ import annotations

import io
import os
import signal
import sys
from collections.abc import Callable, Sequence
from typing import Annotated, Any

import typer

from ..planning import PathError
from ..support.errors import NotConvergedError, TwistarmError
from ..support.interrupts import end_by, ended_like_ctrl_c
from .command import Command, Group
from .commands import arms, baking, calibrating, checking, designing, driving, guide, kinematics, motion, viewing
from .numbers import switch
from .options import ArmCommand
from .output import say
from .wording import words_of

# Exit codes: a bad answer, unusable input, a fault of twistarm, Ctrl-C.
BAD_ANSWER, BAD_INPUT, BUG, INTERRUPTED = 1, 2, 70, 130

COMMANDS: dict[str, tuple[Callable[..., Any], ...]] = {
    "An arm": (viewing.demo, arms.arms, arms.info, arms.init, checking.doctor, checking.check, checking.freeze,
               checking.collisions, baking.bake, baking.dh),
    "Kinematics": (kinematics.fk, kinematics.jacobian, kinematics.ik, designing.reach),
    "Motion": (motion.plan, viewing.view, driving.servo, driving.follow),
    "Design": (designing.payload, designing.designs, designing.panel),
    "Hardware": (calibrating.wiring, calibrating.calibrate),
}  # fmt: skip
"""The commands in the sections of the help."""

app = typer.Typer(
    name="twistarm",
    cls=Group,
    help="Kinematics of robot arms in the language of screws. ARM is a URDF, xacro or MJCF file, an arm.toml, a "
    "Denavit–Hartenberg table, or a name that `twistarm arms` lists.",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for section, functions in COMMANDS.items():
    for function in functions:
        without_arm = function in (viewing.demo, arms.arms)
        app.command(cls=Command if without_arm else ArmCommand, rich_help_panel=section)(function)
app.add_typer(guide.guide, rich_help_panel="Course")


def _print_version(wanted: bool) -> None:
    if wanted:
        say(f"twistarm {arms.version()}")
        raise typer.Exit


Version = Annotated[bool, switch("Print twistarm's version.", "--version", is_eager=True, callback=_print_version)]
Debug = Annotated[bool, switch("Show the traceback of an error.", "--debug")]


@app.callback(invoke_without_command=True)
def _program(context: typer.Context, show_version: Version = False, debug: Debug = False) -> None:
    if context.invoked_subcommand is None:
        say(*context.get_help().splitlines())


def program() -> None:
    """Run the typed command. End with its exit code, or by the signal that ended it."""
    for stream in (sys.stdout, sys.stderr):
        # A terminal that lacks ° or ξ shows a question mark instead of stopping the program.
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    with ended_like_ctrl_c() as sent:
        code = run(sys.argv[1:], sent)
    # Ctrl-C is the usual end of a view or a servo, and no failure.
    end_by([number for number in sent if number != signal.SIGINT or code == INTERRUPTED])
    sys.exit(code)


def run(arguments: Sequence[str], sent: Sequence[int] = ()) -> int:
    """Run the program and return its exit code. Every error is one line on stderr; --debug shows the traceback.

    An error after a signal was `sent` counts as the interruption.
    """
    debug = "--debug" in arguments
    # --debug may be anywhere, not only before the command.
    rest = [argument for argument in arguments if argument != "--debug"]
    try:
        code = app(args=rest, prog_name="twistarm", standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has gone (`| head`); keep Python from complaining when it closes stdout.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BAD_ANSWER
    except Exception as error:
        if sent:
            return INTERRUPTED
        if debug:
            raise
        return _report(error, radians=bool({"--rad", "--json"} & set(rest)))


def _report(error: Exception, *, radians: bool) -> int:
    # Usage errors: typer's click raises them with their own wording.
    if hasattr(error, "format_message"):
        what = error.format_message().replace("Value error, ", "")
        _say(f"{what} (see twistarm --help, or --help after the command)")
        return BAD_INPUT
    _say(words_of(error, radians=radians))
    if isinstance(error, (NotConvergedError, PathError)):  # what was asked for makes sense, and this arm cannot do it
        return BAD_ANSWER
    return BAD_INPUT if isinstance(error, (TwistarmError, OSError)) else BUG


def _say(message: str) -> None:
    """Print an error in one line."""
    say(f"error: {' '.join(message.split())}", file=sys.stderr)
