"""`servo` and `follow`: the arm driven by a person or by a motion, on simulated joints or on a robot."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, usually_limited
from ...control import stream
from ...control.servo import ServoSettings
from ...control.servo.settings import ON_UNREACHABLE, SLIDE
from ...control.stream.cycles import checked_rate
from ...control.stream.following import START_TOLERANCE, TRACKING_TOLERANCE
from ...control.stream.motion_clock import motion_of
from ...control.stream.protocols import MESSAGE_TIMEOUT, TOLERANCE
from ...control.stream.serial_link import BAUDRATE
from ...support.checks import Array, require_choice
from ...support.errors import InputError, LimitError
from ..command import Shared
from ..numbers import JointValues, argument, of_joints, option, quantity, switch
from ..options import Answer, ArmArgument, Avoid, Theta, avoided
from ..output import Outputs, entries, progress_bar, say
from ..tables import outside
from .motion import Acceleration, Velocity, capped, motion_of_file
from .viewing import PageOptions

Hertz = Annotated[float, quantity("Hz", "Cycles per second.")]
Joints = tuple[stream.Sink, stream.Feedback, Callable[[Any], object]]
Tolerance = Annotated[
    Any, quantity("rad m", "How far a joint may be from where it is commanded to be; rad and m without a unit.")
]


@dataclass(frozen=True)
class Robot:
    """The typed options for a robot, and the links to it. InputError where options do not go together."""

    udp: Annotated[str | None, option("HOST:PORT", "Send setpoints to a robot at this address; needs --listen.")] = None
    listen: Annotated[str | None, option("HOST:PORT", "Local address for the robot's joint states.")] = None
    serial: Annotated[
        str | None, option("PORT[:BAUD]", "Drive a robot on a serial port by compact lines, both ways.")
    ] = None
    units: Annotated[
        str, option("joint|motor|counts", "Units of the robot; motors and counts by [actuators] of the arm.toml.")
    ] = "joint"
    senders: Annotated[
        list[str] | None, option("HOST", "Accept datagrams from this host only; repeatable.", "--from")
    ] = None
    key: Annotated[
        str | None, option("FILE", "Sign datagrams by the key in this file, and accept only signed ones.")
    ] = None
    velocity_mode: Annotated[
        bool, switch("The robot accepts only rates: correct them by measured positions.", "--velocity-mode")
    ] = False
    feedback_timeout: Annotated[float, quantity("s", "How long a joint state holds.")] = MESSAGE_TIMEOUT
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
            raise InputError("--velocity-mode is for a robot that accepts only rates: it needs --udp or --serial")
        Outputs(kinds={"mcap": (".mcap",)}, force=self.force).named(*self.written)
        key = None if self.key is None else stream.read_key(self.key)
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

    def joints(self, arm: Arm, theta: Array, stack: ExitStack) -> Joints:
        """Open the links to the robot, and what takes each cycle: with --record a recorder of both.

        Without a robot, return simulated joints at theta (n,).
        """
        how: dict[str, Any] = {"timeout": self.feedback_timeout, "units": self.units}
        sink: stream.Sink
        feedback: stream.Feedback
        if self.serial is not None:
            sink = feedback = stack.enter_context(stream.SerialRobot(arm, *port_of(self.serial), **how))
        elif self.udp is None or self.listen is None:
            sink = feedback = stream.SimulatedJoints(arm, theta)
        else:
            how |= self.admitted
            feedback = stack.enter_context(stream.UdpFeedback(arm, *address(self.listen, "--listen"), **how))
            to_robot = stream.UdpSink(arm, *address(self.udp, "--udp"), key=self.admitted["key"], units=self.units)
            sink = stack.enter_context(to_robot)
        if self.record is None:
            return sink, feedback, lambda cycle: None
        recorder = stack.enter_context(stream.Recorder(arm, self.record, sink))
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


Commands = Annotated[str | None, option("HOST:PORT", "Receive commands as datagrams here, not from the page.")]
CommandTimeout = Annotated[float, quantity("s", "How long a command holds.")]
Margin = Annotated[Any, quantity("rad m", "Distance kept from position limits; rad and m without a unit.", zero=True)]
OnUnreachable = Annotated[str, option("slide|stop", "Where the arm cannot follow: slide along the limit, or stop.")]
Duration = Annotated[float | None, quantity("s", "End after this time; else Ctrl-C ends it.")]


def servo(
    source: ArmArgument,
    robot: RobotOptions,
    page: PageOptions,
    out: Answer,
    theta: Theta = None,
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    margin: Margin = 0.0,
    on_unreachable: OnUnreachable = SLIDE,
    avoid: Avoid = None,
    commands: Commands = None,
    command_timeout: CommandTimeout = MESSAGE_TIMEOUT,
    duration: Duration = None,
    tolerance: Tolerance = TOLERANCE,
) -> int:
    """Drive the arm by keyboard or gamepad in the browser. Joints are simulated without --udp or --serial."""
    arm = source.load()
    robot.require_datagrams(commands, "--commands or --udp")
    require_choice(on_unreachable, ON_UNREACHABLE, "--on-unreachable")
    margins = of_joints(arm, margin, 0.0, "--margin")
    if np.ptp(margins):  # the servo has one margin for all joints
        raise InputError(f"--margin is one number for turns and slides, which {arm.name} has both: leave out its unit")
    settings = ServoSettings(position_margin=float(margins[0]), on_unreachable=on_unreachable)
    checked_rate(rate, settings)
    near = of_joints(arm, tolerance, TOLERANCE, "--tolerance")
    x = arm.ready if theta is None else _inside(arm, theta)
    driven = replace(arm, limits=capped(arm, velocity, acceleration))
    scene = avoided(driven, avoid)
    with ExitStack() as stack:
        # The links open before the page: a robot that does not answer ends the command, and no browser opens for it.
        sink, feedback, keep = robot.joints(driven, x, stack)
        viewer = stack.enter_context(page.viewer(driven, x))
        source_of_commands: Any = viewer.commands
        source_of_commands.timeout = command_timeout
        if commands is not None:
            here = address(commands, "--commands")
            datagrams = stream.UdpSource(driven, *here, timeout=command_timeout, **robot.admitted)
            source_of_commands = stack.enter_context(datagrams)
        page.show_address(viewer, out.words, assumed=defaults_line(driven))

        def on_cycle(cycle: stream.Cycle) -> None:
            viewer.show_servo(cycle)
            keep(cycle)

        report = stream.run(
            driven, source_of_commands, sink, feedback, stream.StreamOptions(
                **robot.options(rate, near), command_timeout=command_timeout, scene=scene,
                settings=viewer.servo_settings(settings),
            ), duration=duration, on_cycle=on_cycle,
        )  # fmt: skip
    out.show({"arm": arm, **vars(report), "ok": report.ok}, *out.lines(report.explain()), written=robot.written)
    return 0 if report.ok else 1


def _inside(arm: Arm, typed: JointValues) -> Array:
    """The typed theta (n,), inside the limits."""
    theta = typed.of(arm)
    for words in outside(arm, theta, typed.radians):
        raise LimitError(f"--theta: {words}")
    return theta


Motion = Annotated[Path, argument("MOTION", "A motion in *.csv, *.json, *.yaml or *.mcap, or a motion.toml to plan.")]
Approach = Annotated[
    bool, switch("Where the arm is elsewhere, move to the start first, straight in joint space.", "--approach")
]
Speed = Annotated[float, quantity("1", "Share of the motion's own speed, above 0 and at most 1.")]
StartTolerance = Annotated[Any, quantity("rad m", "How far from the start a joint may be; rad and m without a unit.")]

KEYS = "space pauses and resumes, q stops"

AT_ONCE = 64  # The most bytes to read between two cycles: a key that is held down must not delay one.


def follow(
    source: ArmArgument,
    motion: Motion,
    robot: RobotOptions,
    page: PageOptions,
    answer: Answer,
    approach: Approach = False,
    speed: Speed = 1.0,
    theta: Theta = None,
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    start_tolerance: StartTolerance = START_TOLERANCE,
    tolerance: Tolerance = TRACKING_TOLERANCE,
) -> int:
    """Follow a motion on simulated joints (--theta places them), or on a robot by --udp or --serial."""
    arm = source.load()
    robot.require_datagrams()
    if theta is not None and not robot.is_simulated:
        raise InputError("--theta places simulated joints; a robot reports its own")
    checked_rate(rate, ServoSettings())
    if speed > 1.0:
        raise InputError(f"--speed is a share of the motion's own, at most 1; got {speed:g}")
    start = of_joints(arm, start_tolerance, START_TOLERANCE, "--start-tolerance")
    tracked = of_joints(arm, tolerance, TRACKING_TOLERANCE, "--tolerance")
    driven, read = motion_of_file(arm, motion, velocity, acceleration)
    planned = motion_of(usually_limited(driven), read)
    # The file may begin a rounding beyond a limit, where simulated joints cannot stand.
    at_start = np.clip(planned.waypoints[0], arm.limits.lower, arm.limits.upper)
    x = at_start if theta is None else _inside(arm, theta)
    out, control, interlock = answer.words, stream.FollowControl(), stream.Interlock()
    with ExitStack() as stack:
        sink, feedback, keep = robot.joints(driven, x, stack)
        viewer = stack.enter_context(page.viewer(driven, x))
        viewer.show_path(planned)
        page.show_address(viewer, out, assumed=defaults_line(driven))
        progress = stack.enter_context(progress_bar("following"))
        typed = stack.enter_context(typed_keys())
        if typed is not None:
            say(KEYS, file=out)

        def on_cycle(cycle: stream.FollowCycle) -> None:
            viewer.show_servo(cycle)
            keep(cycle)
            progress(max(0.0, cycle.at) / cycle.duration if cycle.duration else 1.0)
            for label in cycle.labels:
                say(f"at {cycle.at:.2f} s: {label}", file=out)
            obey(typed, control, interlock)

        options = stream.FollowOptions(
            **robot.options(rate, tracked), interlock=interlock, speed=speed, approach=approach, start_tolerance=start,
            control=control,
        )  # fmt: skip
        report = stream.follow(driven, planned, sink, feedback, options, on_cycle=on_cycle)
    names = report.joint_names
    data = {
        "arm": arm, **entries(report, "ok completed at duration speed"), "ending": report.stream.ending,
        "reason": report.stream.reason, "largest_lag": dict(zip(names, report.largest_lag, strict=True)),
        "largest_error": dict(zip(names, report.largest_error, strict=True)),
        "loop": {"arm": arm, **vars(report.stream), "ok": report.stream.ok},
    }  # fmt: skip
    answer.show(data, *answer.lines(report.explain()), written=robot.written)
    return 0 if report.ok else 1


def obey(typed: Callable[[], str] | None, control: stream.FollowControl, interlock: stream.Interlock) -> None:
    """Obey the keys typed since the last cycle. Resuming enables a robot that stopped itself."""
    for pressed in typed() if typed is not None else "":
        if pressed in "qQ":
            control.stop()
        elif pressed == " ":
            interlock.enable()  # else a robot that stopped itself would stay at rest
            control.toggle()


@contextmanager
def typed_keys() -> Iterator[Callable[[], str] | None]:
    """A function that returns the keys typed since its last call, without waiting.

    None if stdin is no terminal, or belongs to another program in the foreground. The terminal is restored at the end.
    Ctrl-C still works.
    """
    try:
        import termios
        import tty
    except ImportError:  # Windows has no such terminals
        yield None
        return
    try:
        terminal = sys.stdin.fileno()
        before = termios.tcgetattr(terminal) if _is_ours(terminal) else None
    except (AttributeError, OSError, ValueError, termios.error):
        before = None
    if before is None:
        yield None
        return

    def waiting() -> str:
        with suppress(OSError, ValueError):
            if _is_ours(terminal) and select.select([terminal], [], [], 0.0)[0]:
                return os.read(terminal, AT_ONCE).decode("utf-8", "replace")
        return ""

    tty.setcbreak(terminal)  # not raw: Ctrl-C still sends its signal
    try:
        yield waiting
    finally:
        with suppress(termios.error):  # it is gone
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _is_ours(terminal: int) -> bool:
    """Whether it is a terminal with this program in the foreground. Otherwise a read would stop the program."""
    return os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp()
