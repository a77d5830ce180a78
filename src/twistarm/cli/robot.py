"""The robot that a command drives: the options for its links, and the links."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import typer

from ..arm.arm import Arm
from ..control.stream import Feedback, Recorder, SerialRobot, SimulatedJoints, Sink, UdpFeedback, UdpSink, read_key
from ..control.stream.links.serial_link import BAUDRATE
from ..support.checks import Array
from ..support.errors import InputError, LimitError
from .outputs import outputs_of
from .quantities import quantity
from .tables import shown, units

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
Record = Annotated[str | None, typer.Option(metavar="FILE.mcap", help="Record the stream as ROS 2 messages.")]
Hertz = Annotated[float, quantity("Hz", "Cycles per second.")]
VelocityMode = Annotated[
    bool, typer.Option("--velocity-mode", help="The robot takes rates alone: correct them by what is measured.")
]
FeedbackTimeout = Annotated[float, quantity("s", "How long a joint state holds.")]
Tolerance = Annotated[
    Any, quantity("rad m", "How far a joint may be from where it is commanded to be; rad and m without a unit.")
]


@dataclass(frozen=True)
class Robot:
    """The typed options for a robot, and the links to it."""

    udp: str | None
    listen: str | None
    serial: str | None
    units: str
    senders: list[str] | None
    key: str | None
    velocity_mode: bool
    feedback_timeout: float
    record: str | None
    force: bool

    @property
    def authenticates(self) -> bool:
        """Whether --from or --key was given."""
        return bool(self.senders) or self.key is not None

    @property
    def written(self) -> list[str]:
        """The file of --record, if there is one."""
        return [] if self.record is None else [self.record]

    def require_fitting(self) -> None:
        """Raise InputError where options do not go together."""
        if (self.udp is None) != (self.listen is None):
            raise InputError("--udp HOST:PORT and --listen HOST:PORT go together: setpoints out, joint states in")
        if self.serial is not None and self.udp is not None:
            raise InputError("a robot is on --udp or on --serial, not on both")
        if self.units != "joint" and self.udp is None and self.serial is None:
            raise InputError("--units is for a robot: it needs --udp or --serial")
        if self.velocity_mode and self.udp is None and self.serial is None:
            raise InputError("--velocity-mode is for a robot that takes rates alone: it needs --udp or --serial")
        outputs_of(self.record, {"mcap": (".mcap",)}, force=self.force)

    def admitted(self) -> dict[str, Any]:
        """Hosts and key of the accepted datagrams, as arguments of the links. Reads the key file."""
        return {"senders": tuple(self.senders or ()), "key": None if self.key is None else read_key(self.key)}

    def joints(self, arm: Arm, theta: Array, admitted: dict[str, Any], stack: ExitStack) -> tuple[Sink, Feedback]:
        """Open the links to the robot. Without a robot, return simulated joints at theta (n,)."""
        timeout, units = self.feedback_timeout, self.units
        if self.serial is not None:
            robot = stack.enter_context(SerialRobot(arm, *port_of(self.serial), timeout=timeout, units=units))
            return robot, robot
        if self.udp is None or self.listen is None:
            joints = SimulatedJoints(arm, theta)
            return joints, joints
        feedback = stack.enter_context(
            UdpFeedback(arm, *address(self.listen, "--listen"), timeout=timeout, units=units, **admitted)
        )
        sink = UdpSink(arm, *address(self.udp, "--udp"), key=admitted["key"], units=units)
        return stack.enter_context(sink), feedback

    def recorded(self, arm: Arm, sink: Sink, stack: ExitStack) -> tuple[Sink, Callable[[Any], object]]:
        """The sink and what takes each cycle: a recorder of both, if there is --record."""
        if self.record is None:
            return sink, lambda cycle: None
        recorder = stack.enter_context(Recorder(arm, self.record, sink))
        return recorder, recorder


def require_inside(arm: Arm, theta: Array, radians: bool) -> None:
    """LimitError, in the unit that was typed, where theta (n,) is outside the position limits."""
    off = np.abs(theta - np.clip(theta, arm.limits.lower, arm.limits.upper))
    if off.max() > 0.0:
        j = int(off.argmax())
        value, lower, upper = (shown(arm, each, radians)[j] for each in (theta, arm.limits.lower, arm.limits.upper))
        name, unit = arm.joint_names[j], units(arm, radians)[j]
        raise LimitError(f"--theta: {name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")


def port_of(text: str) -> tuple[str, int]:
    """Serial port and baud rate of a typed PORT[:BAUD]."""
    port, colon, baud = text.rpartition(":")
    if not colon:
        return text, BAUDRATE
    if not port or not baud.isdecimal() or not 0 < int(baud) < 10**8:
        raise InputError(f"--serial takes PORT or PORT:BAUD, as in --serial /dev/ttyUSB0:115200; got {text!r}")
    return port, int(baud)


def address(text: str, option: str) -> tuple[str, int]:
    """Host and port of a typed HOST:PORT, [::1]:PORT for an IPv6 address."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(f"{option} takes HOST:PORT, as in {option} 127.0.0.1:5005; got {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)
