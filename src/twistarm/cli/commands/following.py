"""`follow`: a motion file on simulated joints or on a robot, paused and stopped by keys."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, usually_limited
from ...control.servo import ServoSettings
from ...control.stream import FollowControl, FollowCycle, FollowReport, Interlock
from ...control.stream import follow as follow_on
from ...control.stream.cycles import checked_rate
from ...control.stream.following.beginning import motion_of
from ...control.stream.following.cycle import START_TOLERANCE, TRACKING_TOLERANCE
from ...planning import Trajectory
from ...support.checks import Array
from ...support.errors import InputError
from ...viewer import Viewer
from ..asked_motion import motion_of_file
from ..options import CONFIGURATION, Json, Radians, takes_arm
from ..output import print_json, progress_bar, say
from ..outputs import Outputs
from ..quantities import of_joints, quantity
from ..robot import Hertz, Robot, Tolerance, require_inside, takes_robot
from ..typed import parse_theta
from ..wording import words
from .motion import Acceleration, Velocity
from .servo import report_json
from .viewing import Browser, Host, Port, show_address

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


@takes_arm
@takes_robot
def follow(
    arm: Arm,
    *,
    motion: Motion,
    approach: Approach = False,
    speed: Speed = 1.0,
    theta: Stand = None,
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    robot: Robot,
    tolerance: Tolerance = TRACKING_TOLERANCE,
    start_tolerance: StartTolerance = START_TOLERANCE,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Follow a motion on simulated joints (--theta says where they stand), or on a robot by --udp or --serial."""
    robot.require_fitting()
    if robot.authenticates and robot.udp is None:
        raise InputError("--from and --key are for datagrams: they need --udp")
    if theta is not None and (robot.udp or robot.serial):
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
        sink, record = robot.recorded(driven, sink, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        viewer.show_path(planned)
        show_address(viewer, browser, out, assumed=defaults_line(driven))
        progress = stack.enter_context(progress_bar("following"))
        typed = stack.enter_context(typed_keys())
        if typed is not None:
            say(KEYS, file=out)

        def each(cycle: FollowCycle) -> None:
            viewer.show_servo(cycle)
            record(cycle)
            progress(max(0.0, cycle.at) / cycle.duration if cycle.duration else 1.0)
            for label in cycle.labels:
                say(f"at {cycle.at:.2f} s: {label}", file=out)
            obey(typed, control, interlock)

        report = follow_on(
            driven, planned, sink, feedback, rate=rate, speed=speed, approach=approach,
            start_tolerance=start, tolerance=tracked, feedback_timeout=robot.feedback_timeout,
            velocity_mode=robot.velocity_mode, control=control, interlock=interlock, on_cycle=each,
        )  # fmt: skip
    if json:
        print_json(_as_json(arm, report) | {"written": robot.written})
    else:
        say(*words(report.explain(), radians=rad).splitlines())
        Outputs().say(robot.written)
    return 0 if report.ok else 1


def _as_json(arm: Arm, report: FollowReport) -> dict[str, Any]:
    lags, errors = (
        dict(zip(report.joint_names, off.tolist(), strict=True)) for off in (report.largest_lag, report.largest_error)
    )
    return {
        "arm": arm.name, "ok": report.ok, "completed": report.completed, "ending": report.stream.ending.name,
        "reason": words(report.stream.reason, radians=True),
        "at": report.at, "duration": report.duration, "speed": report.speed,
        "largest_lag": lags, "largest_error": errors, "loop": report_json(arm, report.stream),
    }  # fmt: skip


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
