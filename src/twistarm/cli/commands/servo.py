"""`servo`: drive the arm by keys or a gamepad in the browser, simulated or on a robot."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from math import inf
from typing import Annotated, NamedTuple, TextIO

import numpy as np
import typer

from ...model.arm import Arm
from ...model.usual_limits import defaults_line
from ...servo import ServoSettings
from ...servo.settings import BEYOND, SLIDE
from ...stream import (
    Feedback,
    SerialRobot,
    SimulatedJoints,
    Sink,
    Source,
    UdpFeedback,
    UdpSink,
    UdpSource,
    read_key,
    run,
)
from ...stream.links.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from ...stream.links.serial_link import BAUDRATE
from ...stream.streaming import TOLERANCE, checked_rate
from ...support.checks import Array, as_positive, require_choice
from ...support.errors import InputError, LimitError
from ...viewer import Viewer
from ..options import Json, Radians, Theta, takes_arm
from ..output import console, print_json, say, shown, units, warn
from ..servo_report import report_json, report_table
from ..typed import parse_theta
from .motion import Rate, capped
from .viewing import Browser, Host, Port

Udp = Annotated[str | None, typer.Option(metavar="HOST:PORT", help="Send setpoints to a robot there; needs --listen.")]
Listen = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Where the robot's joint states arrive, an address of ours.")
]
Commands = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Take commands as datagrams to there, not from the page.")
]
Serial = Annotated[
    str | None, typer.Option(metavar="PORT[:BAUD]", help="Drive a robot on a serial port by compact lines, both ways.")
]
Units = Annotated[
    str,
    typer.Option(metavar="joint|motor|counts", help="What the robot speaks; motors by [actuators] of the arm.toml."),
]
From = Annotated[
    list[str] | None, typer.Option("--from", metavar="HOST", help="Take datagrams from this host alone; repeatable.")
]
Key = Annotated[
    str | None,
    typer.Option(metavar="FILE", help="Sign datagrams, and take signed ones alone, by the key in this file."),
]
Hertz = Annotated[float, typer.Option(help="Cycles per second.")]
VelocityMode = Annotated[
    bool, typer.Option("--velocity-mode", help="The robot takes rates alone: correct them by what is measured.")
]
CommandTimeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long a command holds.")]
FeedbackTimeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long a joint state holds.")]
Tolerance = Annotated[float, typer.Option(help="How far a joint may be from where it is commanded to be (rad, m).")]
Margin = Annotated[float, typer.Option(help="Distance kept from position limits (rad, m).")]
Beyond = Annotated[
    str,
    typer.Option(metavar="slide|stop", help="Where the arm cannot follow: slide along, or stop on the course."),
]
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
    serial: Serial = None,
    units: Units = "joint",
    senders: From = None,
    key: Key = None,
    velocity_mode: VelocityMode = False,
    command_timeout: CommandTimeout = COMMAND_TIMEOUT,
    feedback_timeout: FeedbackTimeout = FEEDBACK_TIMEOUT,
    tolerance: Tolerance = TOLERANCE,
    margin: Margin = 0.0,
    beyond: Beyond = SLIDE,
    duration: Duration = None,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Drive the arm by keyboard or gamepad in the browser: on simulated joints, or on a robot by --udp or --serial."""
    if (udp is None) != (listen is None):
        raise InputError("--udp HOST:PORT and --listen HOST:PORT go together: setpoints out, joint states in")
    if serial is not None and udp is not None:
        raise InputError("a robot is on --udp or on --serial, not on both")
    if (senders or key is not None) and udp is None and commands is None:
        raise InputError("--from and --key are for datagrams: they need --commands or --udp")
    if units != "joint" and udp is None and serial is None:
        raise InputError("--units is for a robot: it needs --udp or --serial")
    if velocity_mode and udp is None and serial is None:
        raise InputError("--velocity-mode is for a robot that takes rates alone: it needs --udp or --serial")
    require_choice(beyond, BEYOND, "--beyond")
    settings = ServoSettings(position_margin=not_negative(margin, "--margin"), beyond=beyond)
    checked_rate(rate, settings)
    require_positive(duration=duration, tolerance=tolerance)
    require_positive(command_timeout=command_timeout, feedback_timeout=feedback_timeout)
    x = parse_theta(arm, theta, rad)
    require_inside(arm, x, rad)
    driven = replace(arm, limits=capped(arm, {"velocity": velocity, "acceleration": acceleration}))

    keyed = None if key is None else read_key(key)
    admitted = Admitted(tuple(senders or ()), keyed)

    with ExitStack() as stack:
        sink, feedback = joints_of(driven, x, udp, listen, serial, units, feedback_timeout, admitted, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        source = source_of(driven, viewer, commands, command_timeout, admitted, stack)
        announce(viewer, defaults_line(driven), browser, sys.stderr if json else sys.stdout)
        report = run(
            driven, source, sink, feedback, rate=rate, command_timeout=command_timeout,
            feedback_timeout=feedback_timeout, tolerance=tolerance, settings=viewer.servo_settings(settings),
            velocity_mode=velocity_mode, duration=duration, on_cycle=viewer.show_servo,
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


class Admitted(NamedTuple):
    """Whose datagrams count: the hosts and the key that were typed."""

    senders: tuple[str, ...]
    key: bytes | None


def joints_of(
    arm: Arm,
    theta: Array,
    udp: str | None,
    listen: str | None,
    serial: str | None,
    units: str,
    timeout: float,
    admitted: Admitted,
    stack: ExitStack,
) -> tuple[Sink, Feedback]:
    """Where setpoints go and joint states come from: a robot, or simulated joints at theta (n,)."""
    if serial is not None:
        robot = stack.enter_context(SerialRobot(arm, *port_of(serial), timeout=timeout, units=units))
        return robot, robot
    if udp is None or listen is None:
        joints = SimulatedJoints(arm, theta)
        return joints, joints
    with warned():
        feedback = stack.enter_context(
            UdpFeedback(arm, *address(listen, "--listen"), timeout=timeout, units=units, **admitted._asdict())
        )
    return stack.enter_context(UdpSink(arm, *address(udp, "--udp"), key=admitted.key, units=units)), feedback


def source_of(
    arm: Arm, viewer: Viewer, commands: str | None, timeout: float, admitted: Admitted, stack: ExitStack
) -> Source:
    """Where commands come from: the pages, or datagrams."""
    if commands is None:
        pages = viewer.commands
        pages.timeout = timeout
        return pages
    with warned():
        return stack.enter_context(
            UdpSource(arm, *address(commands, "--commands"), timeout=timeout, **admitted._asdict())
        )


@contextmanager
def warned() -> Iterator[None]:
    """What is warned of inside is said on stderr, a line each."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        yield
    for each in said:
        warn(str(each.message))


def port_of(text: str) -> tuple[str, int]:
    """Serial port and baud rate of a typed PORT[:BAUD]."""
    port, colon, baud = text.rpartition(":")
    if not colon:
        return text, BAUDRATE
    if not port or not baud.isdecimal() or not 0 < int(baud) < 10**8:
        raise InputError(f"--serial takes PORT or PORT:BAUD, as in --serial /dev/ttyUSB0:115200; got {text!r}")
    return port, int(baud)


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
