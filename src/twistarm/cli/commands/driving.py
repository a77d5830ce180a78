"""`servo` and `follow`: the arm driven by a person or by a motion, on simulated joints or on a robot."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, usually_limited
from ...control.servo import ServoSettings
from ...control.servo.settings import ON_UNREACHABLE, SLIDE
from ...control.stream import Cycle, FollowControl, FollowCycle, Interlock, Source, StreamReport, UdpSource, run
from ...control.stream import follow as follow_on
from ...control.stream.cycles import checked_rate
from ...control.stream.following.beginning import motion_of
from ...control.stream.following.cycle import START_TOLERANCE, TRACKING_TOLERANCE
from ...control.stream.links.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from ...control.stream.streaming import TOLERANCE
from ...planning import Trajectory
from ...support.checks import Array, require_choice
from ...support.errors import InputError
from ...viewer import Viewer
from ..asked_motion import capped, motion_of_file
from ..options import CONFIGURATION, ArmArgument, Avoid, Json, Radians, Theta, avoided
from ..output import entries, progress_bar, say
from ..outputs import Force, Outputs
from ..quantities import of_joints, quantity
from ..robot import (
    FeedbackTimeout,
    From,
    Hertz,
    Key,
    Listen,
    Record,
    Robot,
    Serial,
    Tolerance,
    Udp,
    Units,
    VelocityMode,
    address,
    require_inside,
)
from ..typed import parse_theta
from .motion import Acceleration, Velocity
from .viewing import Browser, Host, Port, show_address

Commands = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Take commands as datagrams to there, not from the page.")
]
CommandTimeout = Annotated[float, quantity("s", "How long a command holds.")]
Margin = Annotated[Any, quantity("rad m", "Distance kept from position limits; rad and m without a unit.", zero=True)]
OnUnreachable = Annotated[
    str, typer.Option(metavar="slide|stop", help="Where the arm cannot follow: slide along, or stop on the course.")
]
Duration = Annotated[float | None, quantity("s", "End after so long; else Ctrl-C ends it.")]


def servo(
    source: ArmArgument,
    theta: Theta = "ready",
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    margin: Margin = 0.0,
    on_unreachable: OnUnreachable = SLIDE,
    avoid: Avoid = None,
    commands: Commands = None,
    command_timeout: CommandTimeout = COMMAND_TIMEOUT,
    duration: Duration = None,
    udp: Udp = None,
    listen: Listen = None,
    serial: Serial = None,
    units: Units = "joint",
    senders: From = None,
    key: Key = None,
    velocity_mode: VelocityMode = False,
    feedback_timeout: FeedbackTimeout = FEEDBACK_TIMEOUT,
    tolerance: Tolerance = TOLERANCE,
    record: Record = None,
    force: Force = False,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Drive the arm by keyboard or gamepad in the browser: on simulated joints, or on a robot by --udp or --serial."""
    arm = source.load()
    robot = Robot(udp, listen, serial, units, senders, key, velocity_mode, feedback_timeout, record, force)
    if robot.authenticates and udp is None and commands is None:
        raise InputError("--from and --key are for datagrams: they need --commands or --udp")
    robot.require_fitting()
    require_choice(on_unreachable, ON_UNREACHABLE, "--on-unreachable")
    margins = of_joints(arm, margin, 0.0, "--margin")
    if np.ptp(margins):
        raise InputError(f"--margin is one number for turns and slides, which {arm.name} has both: leave out its unit")
    settings = ServoSettings(position_margin=float(margins[0]), on_unreachable=on_unreachable)
    checked_rate(rate, settings)
    near = of_joints(arm, tolerance, TOLERANCE, "--tolerance")
    x = parse_theta(arm, theta, rad)
    require_inside(arm, x, rad)
    driven = replace(arm, limits=capped(arm, {"velocity": velocity, "acceleration": acceleration}))
    scene = avoided(driven, avoid)
    admitted = robot.admitted()
    with ExitStack() as stack:
        sink, feedback = robot.joints(driven, x, admitted, stack)
        sink, keep = robot.recorded(driven, sink, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        source_of_commands = _commands(driven, viewer, commands, command_timeout, admitted, stack)
        show_address(viewer, browser, sys.stderr if json else sys.stdout, assumed=defaults_line(driven))

        def each(cycle: Cycle) -> None:
            viewer.show_servo(cycle)
            keep(cycle)

        report = run(
            driven, source_of_commands, sink, feedback, rate=rate, command_timeout=command_timeout,
            feedback_timeout=feedback_timeout, tolerance=near, settings=viewer.servo_settings(settings),
            scene=scene, velocity_mode=velocity_mode, duration=duration, on_cycle=each,
        )  # fmt: skip
    out = Outputs(json=json, radians=rad)
    out.show(_loop(arm, report), *out.lines(report.explain()), written=robot.written)
    return 0 if report.ok else 1


def _commands(
    arm: Arm, viewer: Viewer, commands: str | None, timeout: float, admitted: dict[str, Any], stack: ExitStack
) -> Source:
    """Where commands come from: the pages, or datagrams."""
    if commands is None:
        pages = viewer.commands
        pages.timeout = timeout
        return pages
    return stack.enter_context(UdpSource(arm, *address(commands, "--commands"), timeout=timeout, **admitted))


def _loop(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """The report of the loop."""
    return {"arm": arm, **vars(report), "ok": report.ok}


Motion = Annotated[
    Path,
    typer.Argument(
        metavar="MOTION", help="A *.csv, *.json, *.yaml or *.mcap of `twistarm plan -o`, or a motion.toml to plan."
    ),
]
Stand = Annotated[str | None, CONFIGURATION]
Approach = Annotated[
    bool,
    typer.Option("--approach", help="Where the arm is elsewhere, move to the start first, straight in joint space."),
]
Speed = Annotated[float, quantity("1", "Share of the motion's own speed, above 0 and at most 1.")]
StartTolerance = Annotated[
    Any, quantity("rad m", "How far from the start a joint may stand; rad and m without a unit.")
]

KEYS = "space pauses and resumes, q stops"

AT_ONCE = 64
"""The most bytes to read between two cycles."""


def follow(
    source: ArmArgument,
    motion: Motion,
    approach: Approach = False,
    speed: Speed = 1.0,
    theta: Stand = None,
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    start_tolerance: StartTolerance = START_TOLERANCE,
    udp: Udp = None,
    listen: Listen = None,
    serial: Serial = None,
    units: Units = "joint",
    senders: From = None,
    key: Key = None,
    velocity_mode: VelocityMode = False,
    feedback_timeout: FeedbackTimeout = FEEDBACK_TIMEOUT,
    tolerance: Tolerance = TRACKING_TOLERANCE,
    record: Record = None,
    force: Force = False,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Follow a motion on simulated joints (--theta says where they stand), or on a robot by --udp or --serial."""
    arm = source.load()
    robot = Robot(udp, listen, serial, units, senders, key, velocity_mode, feedback_timeout, record, force)
    robot.require_fitting()
    if robot.authenticates and udp is None:
        raise InputError("--from and --key are for datagrams: they need --udp")
    if theta is not None and (udp or serial):
        raise InputError("--theta is where simulated joints stand; a robot says where it is")
    checked_rate(rate, ServoSettings())
    if speed > 1.0:
        raise InputError(f"--speed is a share of the motion's own, at most 1; got {speed:g}")
    start = of_joints(arm, start_tolerance, START_TOLERANCE, "--start-tolerance")
    tracked = of_joints(arm, tolerance, TRACKING_TOLERANCE, "--tolerance")
    driven, read = motion_of_file(arm, motion, {"velocity": velocity, "acceleration": acceleration})
    planned = motion_of(usually_limited(driven), read)
    x = _simulated_start(arm, theta, planned, rad)
    admitted = robot.admitted()
    out, control, interlock = sys.stderr if json else sys.stdout, FollowControl(), Interlock()
    with ExitStack() as stack:
        sink, feedback = robot.joints(driven, x, admitted, stack)
        sink, keep = robot.recorded(driven, sink, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        viewer.show_path(planned)
        show_address(viewer, browser, out, assumed=defaults_line(driven))
        progress = stack.enter_context(progress_bar("following"))
        typed = stack.enter_context(typed_keys())
        if typed is not None:
            say(KEYS, file=out)

        def each(cycle: FollowCycle) -> None:
            viewer.show_servo(cycle)
            keep(cycle)
            progress(max(0.0, cycle.at) / cycle.duration if cycle.duration else 1.0)
            for label in cycle.labels:
                say(f"at {cycle.at:.2f} s: {label}", file=out)
            obey(typed, control, interlock)

        report = follow_on(
            driven, planned, sink, feedback, rate=rate, speed=speed, approach=approach,
            start_tolerance=start, tolerance=tracked, feedback_timeout=feedback_timeout,
            velocity_mode=velocity_mode, control=control, interlock=interlock, on_cycle=each,
        )  # fmt: skip
    names = report.joint_names
    data = {
        "arm": arm, **entries(report, "ok completed at duration speed"), "ending": report.stream.ending,
        "reason": report.stream.reason, "largest_lag": dict(zip(names, report.largest_lag, strict=True)),
        "largest_error": dict(zip(names, report.largest_error, strict=True)),
        "loop": _loop(arm, report.stream),
    }  # fmt: skip
    answer = Outputs(json=json, radians=rad)
    answer.show(data, *answer.lines(report.explain()), written=robot.written)
    return 0 if report.ok else 1


def _simulated_start(arm: Arm, theta: str | None, motion: Trajectory, radians: bool) -> Array:
    """Where simulated joints stand, theta (n,): at the motion's start unless it was typed."""
    if theta is None:
        return np.clip(motion.waypoints[0], arm.limits.lower, arm.limits.upper)
    x = parse_theta(arm, theta, radians)
    require_inside(arm, x, radians)
    return x


def obey(typed: Callable[[], str] | None, control: FollowControl, interlock: Interlock) -> None:
    """Obey the keys typed since the last cycle. Resuming enables a robot that stopped itself."""
    for pressed in typed() if typed is not None else "":
        if pressed in "qQ":
            control.stop()
        elif pressed == " ":
            interlock.enable()
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
    tty.setcbreak(terminal)
    try:
        yield lambda: _waiting(terminal)
    finally:
        with suppress(termios.error):  # it is gone
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _is_ours(terminal: int) -> bool:
    """Whether it is a terminal with this program in the foreground. Otherwise a read would stop the program."""
    return os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp()


def _waiting(terminal: int) -> str:
    with suppress(OSError, ValueError):
        if _is_ours(terminal) and select.select([terminal], [], [], 0.0)[0]:
            return os.read(terminal, AT_ONCE).decode("utf-8", "replace")
    return ""
