"""`servo`: drive the arm by keys or a gamepad in the browser, simulated or on a robot."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import replace
from math import inf
from typing import Annotated, TextIO

import numpy as np
import typer

from ..arm import Arm
from ..checks import Array, as_positive
from ..errors import InputError, LimitError
from ..servo import ServoSettings
from ..stream import Feedback, SimulatedJoints, Sink, Source, UdpFeedback, UdpSink, UdpSource, run
from ..stream.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from ..stream.streaming import TOLERANCE, checked_rate
from ..usual_limits import defaults_line, with_defaults
from ..viewer import Viewer
from .motion import Rate, capped
from .options import Json, Radians, Theta, takes_arm
from .output import console, print_json, say, shown, units, warn
from .servo_report import report_json, report_table
from .typed import parse_theta
from .viewing import Browser, Host, Port

Udp = Annotated[str | None, typer.Option(metavar="HOST:PORT", help="Send setpoints to a robot there; needs --listen.")]
Listen = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Where the robot's joint states arrive, an address of ours.")
]
Commands = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Take commands as datagrams to there, not from the page.")
]
Hertz = Annotated[float, typer.Option(help="Cycles per second.")]
VelocityMode = Annotated[
    bool, typer.Option("--velocity-mode", help="The robot takes rates alone: begin anew where it is at every rest.")
]
CommandTimeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long a command holds.")]
FeedbackTimeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long a joint state holds.")]
Tolerance = Annotated[float, typer.Option(help="How far a joint may be from where it is commanded to be (rad, m).")]
Margin = Annotated[float, typer.Option(help="Distance kept from position limits (rad, m).")]
Duration = Annotated[float | None, typer.Option(help="End after so many seconds; else Ctrl-C ends it.")]


@takes_arm
def servo(
    arm: Arm,
    theta: Theta = "ready",
    rate: Hertz = 100.0,
    velocity: Rate = None,
    acceleration: Rate = None,
    udp: Udp = None,
    listen: Listen = None,
    commands: Commands = None,
    velocity_mode: VelocityMode = False,
    command_timeout: CommandTimeout = COMMAND_TIMEOUT,
    feedback_timeout: FeedbackTimeout = FEEDBACK_TIMEOUT,
    tolerance: Tolerance = TOLERANCE,
    margin: Margin = 0.0,
    duration: Duration = None,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Drive the arm by keyboard or gamepad in the browser: on simulated joints, or on a robot by --udp."""
    if (udp is None) != (listen is None):
        raise InputError("--udp HOST:PORT and --listen HOST:PORT go together: setpoints out, joint states in")
    if velocity_mode and udp is None:
        raise InputError("--velocity-mode is for a robot that takes rates alone: it needs --udp")
    settings = ServoSettings(position_margin=not_negative(margin, "--margin"))
    checked_rate(rate, settings)
    require_positive(duration=duration, tolerance=tolerance)
    require_positive(command_timeout=command_timeout, feedback_timeout=feedback_timeout)
    x = parse_theta(arm, theta, rad)
    require_inside(arm, x, rad)
    limits = capped(arm, {"velocity": velocity, "acceleration": acceleration})
    driven = replace(arm, limits=with_defaults(arm, limits))

    with ExitStack() as stack:
        sink, feedback = joints_of(driven, x, udp, listen, feedback_timeout, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        source = source_of(driven, viewer, commands, command_timeout, stack)
        announce(viewer, defaults_line(arm, limits), browser, sys.stderr if json else sys.stdout)
        report = run(
            driven, source, sink, feedback, rate=rate, command_timeout=command_timeout,
            feedback_timeout=feedback_timeout, tolerance=tolerance, settings=settings, velocity_mode=velocity_mode,
            duration=duration, on_cycle=viewer.show_servo,
        )  # fmt: skip
    if json:
        print_json(report_json(arm, report))
    else:
        console().print(report_table(arm, report))
    return 0 if report.ok else 1


def require_positive(**typed: float | None) -> None:
    """InputError for an option that was given and is not a positive number."""
    for name, value in typed.items():
        if value is not None:
            as_positive(value, f"--{name.replace('_', '-')}")


def not_negative(value: float, option: str) -> float:
    """A typed number from 0 on."""
    if not 0.0 <= value < inf:
        raise InputError(f"{option} must be a number from 0 on; got {value:g}")
    return value


def require_inside(arm: Arm, theta: Array, radians: bool) -> None:
    """LimitError, in the unit that was typed, where theta (n,) is outside the position limits."""
    off = np.abs(theta - np.clip(theta, arm.limits.lower, arm.limits.upper))
    if off.max() > 0.0:
        j = int(off.argmax())
        value, lower, upper = (shown(arm, each, radians)[j] for each in (theta, arm.limits.lower, arm.limits.upper))
        name, unit = arm.joint_names[j], units(arm, radians)[j]
        raise LimitError(f"--theta: {name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")


def joints_of(
    arm: Arm, theta: Array, udp: str | None, listen: str | None, timeout: float, stack: ExitStack
) -> tuple[Sink, Feedback]:
    """Where setpoints go and joint states come from: a robot, or simulated joints at theta (n,)."""
    if udp is None or listen is None:
        joints = SimulatedJoints(arm, theta)
        return joints, joints
    feedback = stack.enter_context(UdpFeedback(arm, *address(listen, "--listen"), timeout=timeout))
    return stack.enter_context(UdpSink(arm, *address(udp, "--udp"))), feedback


def source_of(arm: Arm, viewer: Viewer, commands: str | None, timeout: float, stack: ExitStack) -> Source:
    """Where commands come from: the pages, or datagrams."""
    if commands is None:
        pages = viewer.commands
        pages.timeout = timeout
        return pages
    return stack.enter_context(UdpSource(arm, *address(commands, "--commands"), timeout=timeout))


def announce(viewer: Viewer, line: str, browser: bool, out: TextIO) -> None:
    """Print which limits were not given and where the arm is, and open the page if wanted and there is a browser."""
    if line:
        say(f"{line} (--velocity, --acceleration)", file=out)
    for note in viewer.notes:
        warn(note)
    say(f"{viewer.arm.name} at {viewer.url}  (Ctrl-C ends it)", file=out)
    if browser and not viewer.open_page():
        warn("no browser found here; open the address yourself")


def address(text: str, option: str) -> tuple[str, int]:
    """Host and port of a typed HOST:PORT, [::1]:PORT for an IPv6 address."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(f"{option} takes HOST:PORT, as in {option} 127.0.0.1:5005; got {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)
