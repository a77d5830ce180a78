"""The robot that a command drives: options for its links, and what they open."""

from __future__ import annotations

from contextlib import ExitStack
from typing import Annotated, NamedTuple, TextIO

import numpy as np
import typer

from ..arm.arm import Arm
from ..control.stream import Feedback, SerialRobot, SimulatedJoints, Sink, UdpFeedback, UdpSink
from ..control.stream.links.serial_link import BAUDRATE
from ..support.checks import Array, as_positive
from ..support.errors import InputError, LimitError
from ..viewer import Viewer
from .output import say, shown, units, warn

Udp = Annotated[str | None, typer.Option(metavar="HOST:PORT", help="Send setpoints to a robot there; needs --listen.")]
Listen = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Where the robot's joint states arrive, an address of ours.")
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
FeedbackTimeout = Annotated[float, typer.Option(metavar="SECONDS", help="How long a joint state holds.")]
Tolerance = Annotated[float, typer.Option(help="How far a joint may be from where it is commanded to be (rad, m).")]


def require_robot(
    udp: str | None, listen: str | None, serial: str | None, units: str, velocity_mode: bool, admitted: bool
) -> None:
    """Raise InputError for conflicting robot options; `admitted`: --from or --key was given."""
    if (udp is None) != (listen is None):
        raise InputError("--udp HOST:PORT and --listen HOST:PORT go together: setpoints out, joint states in")
    if serial is not None and udp is not None:
        raise InputError("a robot is on --udp or on --serial, not on both")
    if admitted and udp is None:
        raise InputError("--from and --key are for datagrams: they need --udp")
    if units != "joint" and udp is None and serial is None:
        raise InputError("--units is for a robot: it needs --udp or --serial")
    if velocity_mode and udp is None and serial is None:
        raise InputError("--velocity-mode is for a robot that takes rates alone: it needs --udp or --serial")


def require_positive(**typed: float | None) -> None:
    """InputError for an option that was given and is not a positive number."""
    for name, value in typed.items():
        if value is not None:
            as_positive(value, f"--{name.replace('_', '-')}")


def require_inside(arm: Arm, theta: Array, radians: bool) -> None:
    """LimitError, in the unit that was typed, where theta (n,) is outside the position limits."""
    off = np.abs(theta - np.clip(theta, arm.limits.lower, arm.limits.upper))
    if off.max() > 0.0:
        j = int(off.argmax())
        value, lower, upper = (shown(arm, each, radians)[j] for each in (theta, arm.limits.lower, arm.limits.upper))
        name, unit = arm.joint_names[j], units(arm, radians)[j]
        raise LimitError(f"--theta: {name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")


class Admitted(NamedTuple):
    """The allowed senders: the typed hosts and the key."""

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
    """The sink and the feedback: a robot, or simulated joints at theta (n,)."""
    if serial is not None:
        robot = stack.enter_context(SerialRobot(arm, *port_of(serial), timeout=timeout, units=units))
        return robot, robot
    if udp is None or listen is None:
        joints = SimulatedJoints(arm, theta)
        return joints, joints
    feedback = stack.enter_context(
        UdpFeedback(arm, *address(listen, "--listen"), timeout=timeout, units=units, **admitted._asdict())
    )
    return stack.enter_context(UdpSink(arm, *address(udp, "--udp"), key=admitted.key, units=units)), feedback


def port_of(text: str) -> tuple[str, int]:
    """Serial port and baud rate of a typed PORT[:BAUD]."""
    port, colon, baud = text.rpartition(":")
    if not colon:
        return text, BAUDRATE
    if not port or not baud.isdecimal() or not 0 < int(baud) < 10**8:
        raise InputError(f"--serial takes PORT or PORT:BAUD, as in --serial /dev/ttyUSB0:115200; got {text!r}")
    return port, int(baud)


def announce(viewer: Viewer, line: str, browser: bool, out: TextIO) -> None:
    """Print assumed limits and the page's address, and open the page if wanted."""
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
