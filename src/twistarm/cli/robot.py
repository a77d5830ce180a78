"""The robot that a command drives: the options for its links, and the links."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Annotated, Any

from ..arm.arm import Arm
from ..control.stream import Feedback, Recorder, SerialRobot, SimulatedJoints, Sink, UdpFeedback, UdpSink, read_key
from ..control.stream.protocols import FEEDBACK_TIMEOUT
from ..control.stream.serial_link import BAUDRATE
from ..support.checks import Array
from ..support.errors import InputError
from .command import Shared
from .numbers import option, quantity, switch
from .output import Outputs

Hertz = Annotated[float, quantity("Hz", "Cycles per second.")]
Tolerance = Annotated[
    Any, quantity("rad m", "How far a joint may be from where it is commanded to be; rad and m without a unit.")
]


@dataclass(frozen=True)
class Robot:
    """The typed options for a robot, and the links to it. InputError where options do not go together."""

    udp: Annotated[str | None, option("HOST:PORT", "Send setpoints to a robot there; needs --listen.")] = None
    listen: Annotated[str | None, option("HOST:PORT", "Where the robot's joint states arrive, an address of ours.")] = (
        None
    )
    serial: Annotated[
        str | None, option("PORT[:BAUD]", "Drive a robot on a serial port by compact lines, both ways.")
    ] = None
    units: Annotated[
        str, option("joint|motor|counts", "What the robot speaks; motors by [actuators] of the arm.toml.")
    ] = "joint"
    senders: Annotated[
        list[str] | None, option("HOST", "Take datagrams from this host alone; repeatable.", "--from")
    ] = None
    key: Annotated[
        str | None, option("FILE", "Sign datagrams, and take signed ones alone, by the key in this file.")
    ] = None
    velocity_mode: Annotated[
        bool, switch("The robot takes rates alone: correct them by what is measured.", "--velocity-mode")
    ] = False
    feedback_timeout: Annotated[float, quantity("s", "How long a joint state holds.")] = FEEDBACK_TIMEOUT
    record: Annotated[str | None, option("FILE.mcap", "Record the stream as ROS 2 messages.")] = None
    force: Annotated[bool, switch("Replace files that are there.", "--force")] = False
    admitted: dict[str, Any] = field(init=False)
    """Hosts and key of the accepted datagrams, as arguments of the links."""

    def __post_init__(self) -> None:
        if (self.udp is None) != (self.listen is None):
            raise InputError("--udp HOST:PORT and --listen HOST:PORT go together: setpoints out, joint states in")
        if self.serial is not None and self.udp is not None:
            raise InputError("a robot is on --udp or on --serial, not on both")
        if self.units != "joint" and self.is_simulated:
            raise InputError("--units is for a robot: it needs --udp or --serial")
        if self.velocity_mode and self.is_simulated:
            raise InputError("--velocity-mode is for a robot that takes rates alone: it needs --udp or --serial")
        Outputs(kinds={"mcap": (".mcap",)}, force=self.force).named(*self.written)
        key = None if self.key is None else read_key(self.key)
        object.__setattr__(self, "admitted", {"senders": tuple(self.senders or ()), "key": key})

    @property
    def is_simulated(self) -> bool:
        """Whether there are simulated joints instead of a robot."""
        return self.udp is None and self.serial is None

    @property
    def written(self) -> list[str]:
        """The file of --record, if there is one."""
        return [] if self.record is None else [self.record]

    def require_datagrams(self, commands: str | None = None, options: str = "--udp") -> None:
        """InputError for --from or --key where no datagrams arrive."""
        if (self.senders or self.key is not None) and self.udp is None and commands is None:
            raise InputError(f"--from and --key are for datagrams: they need {options}")

    def options(self, rate: float, tolerance: Array) -> dict[str, Any]:
        """What the options of a stream to this robot are made of."""
        return {
            "rate": rate, "tolerance": tolerance, "feedback_timeout": self.feedback_timeout,
            "velocity_mode": self.velocity_mode,
        }  # fmt: skip

    def joints(self, arm: Arm, theta: Array, stack: ExitStack) -> tuple[Sink, Feedback, Callable[[Any], object]]:
        """Open the links to the robot, and what takes each cycle: a recorder of both, if there is --record.

        Without a robot, return simulated joints at theta (n,).
        """
        how: dict[str, Any] = {"timeout": self.feedback_timeout, "units": self.units}
        sink: Sink
        feedback: Feedback
        if self.serial is not None:
            sink = feedback = stack.enter_context(SerialRobot(arm, *port_of(self.serial), **how))
        elif self.udp is None or self.listen is None:
            sink = feedback = SimulatedJoints(arm, theta)
        else:
            how |= self.admitted
            feedback = stack.enter_context(UdpFeedback(arm, *address(self.listen, "--listen"), **how))
            to_robot = UdpSink(arm, *address(self.udp, "--udp"), key=self.admitted["key"], units=self.units)
            sink = stack.enter_context(to_robot)
        if self.record is None:
            return sink, feedback, lambda cycle: None
        recorder = stack.enter_context(Recorder(arm, self.record, sink))
        return recorder, feedback, recorder


RobotOptions = Annotated[Robot, Shared(Robot)]


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
