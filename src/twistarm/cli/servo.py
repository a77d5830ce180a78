"""`servo`: drive the arm by keys or a gamepad in the browser, simulated or on a robot."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import fields, replace
from typing import Annotated, Any, TextIO

import numpy as np
import typer
from rich.table import Table

from ..arm import Arm
from ..checks import Array
from ..errors import InputError
from ..limits import JointLimits
from ..stream import Cycle, Feedback, SimulatedJoints, Sink, Source, StreamReport, UdpFeedback, UdpSink, UdpSource, run
from ..viewer import Viewer, show_in_browser
from .kinematics import warn_outside
from .motion import Rate, capped
from .options import Json, Radians, Theta, parse_theta, takes_arm
from .output import console, print_json, table, warn
from .viewing import Browser, Host, Port

DEFAULTS = {"velocity": {"rad": 1.0, "m": 0.25}, "acceleration": {"rad": 3.0, "m": 1.0}}
"""Limits where an arm gives none, per s and s²: brisk for a small arm, and slow enough to let go of a key."""

Udp = Annotated[str | None, typer.Option(metavar="HOST:PORT", help="Send setpoints to a robot there; needs --listen.")]
Listen = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Where the robot's joint states arrive, an address of ours.")
]
Commands = Annotated[
    str | None, typer.Option(metavar="HOST:PORT", help="Take commands as datagrams to there, not from the page.")
]
Hertz = Annotated[float, typer.Option(help="Cycles per second.")]
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
    x = parse_theta(arm, theta, rad)
    limits = capped(arm, {"velocity": velocity, "acceleration": acceleration})
    driven = replace(arm, limits=with_defaults(arm, limits))
    last = [""]

    with ExitStack() as stack:
        stack.enter_context(ended_like_ctrl_c())
        sink, feedback = joints_of(driven, x, udp, listen, stack)
        viewer = stack.enter_context(Viewer(driven, x, host=host, port=port, open_browser=False))
        source = source_of(driven, viewer, commands, stack)

        def on_cycle(cycle: Cycle) -> None:
            last[0] = cycle.reason
            viewer.show_servo(cycle)

        announce(viewer, defaults_line(arm, limits), browser, sys.stderr if json else sys.stdout)
        report = run(driven, source, sink, feedback, rate=rate, duration=duration, on_cycle=on_cycle)
    if json:
        print_json(report_json(arm, report))
    else:
        console().print(report_table(arm, report, last[0]))
    return 0 if report.ok else 1


def with_defaults(arm: Arm, limits: JointLimits) -> JointLimits:
    """`limits`, and `DEFAULTS` where they have no velocity or acceleration."""
    usual = {name: np.array([by_unit[unit] for unit in arm.units]) for name, by_unit in DEFAULTS.items()}
    given = {name: getattr(limits, name) for name in DEFAULTS}
    changes = {name: np.where(np.isfinite(given[name]), given[name], usual[name]) for name in DEFAULTS}
    return limits.with_(changes, arm.joint_names)


def defaults_line(arm: Arm, limits: JointLimits) -> str:
    """Which limits were not given and what stands in for them, "" where all were."""
    parts = []
    for name, power in (("velocity", "s"), ("acceleration", "s²")):
        unlimited = np.isinf(getattr(limits, name))
        for unit in ("rad", "m"):
            of = [
                joint
                for joint, u, free in zip(arm.joint_names, arm.units, unlimited, strict=True)
                if free and u == unit
            ]
            if of:
                parts.append(f"{name} {DEFAULTS[name][unit]:g} {unit}/{power} for {', '.join(of)}")
    return f"no limits given, used instead: {'; '.join(parts)} (--velocity, --acceleration)" if parts else ""


def joints_of(arm: Arm, theta: Array, udp: str | None, listen: str | None, stack: ExitStack) -> tuple[Sink, Feedback]:
    """Where setpoints go and joint states come from: a robot, or simulated joints at theta (n,)."""
    if udp is None or listen is None:
        warn_outside(arm, theta)
        joints = SimulatedJoints(arm, theta)
        return joints, joints
    feedback = stack.enter_context(UdpFeedback(arm, *address(listen, "--listen")))
    return stack.enter_context(UdpSink(arm, *address(udp, "--udp"))), feedback


def source_of(arm: Arm, viewer: Viewer, commands: str | None, stack: ExitStack) -> Source:
    """Where commands come from: the pages, or datagrams."""
    if commands is None:
        return viewer.commands
    return stack.enter_context(UdpSource(arm, *address(commands, "--commands")))


def announce(viewer: Viewer, line: str, browser: bool, out: TextIO) -> None:
    """Print what must be known at the start, and open the page if wanted and there is a browser."""
    if line:
        print(line, file=out)
    print(f"{viewer.arm.name} at {viewer.url}  (Ctrl-C ends it)", file=out, flush=True)
    if browser and not show_in_browser(viewer.url):
        warn("no browser found here; open the address yourself")


def address(text: str, option: str) -> tuple[str, int]:
    """Host and port of a typed HOST:PORT, [::1]:PORT for an IPv6 address."""
    host, _, port = text.rpartition(":")
    if not host or not port.isdecimal() or int(port) > 65535:
        raise InputError(f"{option} takes HOST:PORT, as in {option} 127.0.0.1:5005; got {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)


@contextmanager
def ended_like_ctrl_c() -> Iterator[None]:
    """A closed terminal and `kill` end what runs as Ctrl-C does: with the arm brought to rest."""
    numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {number: signal.signal(number, signal.default_int_handler) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def report_json(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """What the loop did, for programs."""
    values = {field.name: getattr(report, field.name) for field in fields(report)}
    statuses = {status.name: count for status, count in report.statuses.items()}
    return {"arm": arm.name, **values, "ending": report.ending.name, "statuses": statuses, "ok": report.ok}


def report_table(arm: Arm, report: StreamReport, last_reason: str) -> Table:
    """The same for people; `last_reason`: why there was no command, or no joint state, in the last cycle."""
    late = [f"{1e3 * seconds:.2f} ms" for seconds in (report.late_p50, report.late_p99, report.late_max)]
    statuses = ", ".join(f"{status.name} {count}" for status, count in report.statuses.items())
    rows = [
        ["ended", ": ".join(filter(None, (report.ending.value, report.reason)))],
        ["cycles", f"{report.cycles} at {report.rate:g} Hz in {report.duration:.1f} s, {report.missed} missed"],
        ["begun late by", f"{late[0]} (median), {late[1]} (99 %), {late[2]} (most)"],
        ["status", statuses or f"never moved: {last_reason}"],
        ["no command", f"{report.uncommanded:.1f} s"],
        ["no joint state", f"{report.waited:.1f} s at the start, {report.blind:.1f} s later"],
        ["at the end", "at rest" if report.at_rest else "stopped at once, before it had come to rest"],
        *(["trouble", failure] for failure in report.failures),
    ]
    return table(f"{arm.name}: servo", ["", ""], rows, text=("",))
