"""`servo`: drive the arm by keys or a gamepad in the browser, simulated or on a robot."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line
from ...control.servo import ServoSettings
from ...control.servo.settings import ON_UNREACHABLE, SLIDE
from ...control.stream import Cycle, Source, StreamReport, UdpSource, run
from ...control.stream.cycles import checked_rate
from ...control.stream.links.inbox import COMMAND_TIMEOUT
from ...control.stream.streaming import TOLERANCE
from ...support.checks import require_choice
from ...support.errors import InputError
from ...viewer import Viewer
from ..asked_motion import capped
from ..avoiding import Avoid, avoided
from ..options import Json, Radians, Theta, takes_arm
from ..output import print_json, say
from ..outputs import Outputs
from ..quantities import of_joints, quantity
from ..robot import Hertz, Robot, Tolerance, address, require_inside, takes_robot
from ..typed import parse_theta
from ..wording import words
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


@takes_arm
@takes_robot
def servo(
    arm: Arm,
    *,
    theta: Theta = "ready",
    rate: Hertz = 100.0,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    robot: Robot,
    commands: Commands = None,
    command_timeout: CommandTimeout = COMMAND_TIMEOUT,
    tolerance: Tolerance = TOLERANCE,
    margin: Margin = 0.0,
    on_unreachable: OnUnreachable = SLIDE,
    avoid: Avoid = None,
    duration: Duration = None,
    port: Port = 0,
    host: Host = "127.0.0.1",
    browser: Browser = True,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Drive the arm by keyboard or gamepad in the browser: on simulated joints, or on a robot by --udp or --serial."""
    if robot.authenticates and robot.udp is None and commands is None:
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
        sink, record = robot.recorded(driven, sink, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False, keep=port != 0))
        source = source_of(driven, viewer, commands, command_timeout, admitted, stack)
        show_address(viewer, browser, sys.stderr if json else sys.stdout, assumed=defaults_line(driven))

        def each(cycle: Cycle) -> None:
            viewer.show_servo(cycle)
            record(cycle)

        report = run(
            driven, source, sink, feedback, rate=rate, command_timeout=command_timeout,
            feedback_timeout=robot.feedback_timeout, tolerance=near, settings=viewer.servo_settings(settings),
            scene=scene, velocity_mode=robot.velocity_mode, duration=duration, on_cycle=each,
        )  # fmt: skip
    if json:
        print_json(report_json(arm, report) | {"written": robot.written})
    else:
        say(*words(report.explain(), radians=rad).splitlines())
        Outputs().say(robot.written)
    return 0 if report.ok else 1


def source_of(
    arm: Arm, viewer: Viewer, commands: str | None, timeout: float, admitted: dict[str, Any], stack: ExitStack
) -> Source:
    """Where commands come from: the pages, or datagrams."""
    if commands is None:
        pages = viewer.commands
        pages.timeout = timeout
        return pages
    return stack.enter_context(UdpSource(arm, *address(commands, "--commands"), timeout=timeout, **admitted))


def report_json(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """The report of the loop, for programs."""
    values = vars(report)
    counts = {name: {each.name: count for each, count in values[name].items()} for name in ("statuses", "reasons")}
    return {"arm": arm.name, **values, "ending": report.ending.name, **counts, "ok": report.ok}
