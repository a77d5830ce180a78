"""`plan`: a trajectory through poses, to a table and to files."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from typing import Annotated, Any

import numpy as np
import typer

from ...limits.joint_limits import JointLimits
from ...model.arm import Arm
from ...model.ready_pose import named_ready
from ...model.usual_limits import defaults_line, with_defaults
from ...planning import Trajectory, plan_joint
from ...planning.trajectory_files import csv_text, json_text
from ...planning.within import RATE_TOL
from ...support.checks import Array, as_positive
from ..options import Json, Radians, takes_arm
from ..output import console, note, number, print_json, progress_bar, say, shown, table, theta_values, units, warn
from ..outputs import Force, Format, outputs_of
from ..typed import POSE, parse_theta


class Kind(str, Enum):
    """The kind of spline."""

    cubic = "cubic"
    quintic = "quintic"
    trapezoid = "trapezoid"


Start = Annotated[
    str | None, typer.Option("--from", metavar=POSE, help="Where it starts, as --to; unless given, the ready pose.")
]
Through = Annotated[
    list[str],
    typer.Option(
        "--to",
        metavar=POSE,
        help="Joint values (0 30 -45 …), joint=value for those that move, or a pose's name; repeat it for each pose.",
    ),
]
Rate = Annotated[
    float | None,
    typer.Option(help="At most this for every joint (rad/s and m/s, or per s²); the arm's own limits hold as well."),
]
Output = Annotated[
    list[str] | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Write time, position, velocity and acceleration to *.csv, or a ROS JointTrajectory to *.json; with "
        "[actuators] what the motors do and their drives count as well. - is standard output; repeat it for both.",
    ),
]
Step = Annotated[float, typer.Option(help="Time step of the files, in seconds.")]


@takes_arm
def plan(
    arm: Arm,
    to: Through,
    start: Start = None,
    kind: Kind = Kind.cubic,
    velocity: Rate = None,
    acceleration: Rate = None,
    stop: Annotated[bool, typer.Option("--stop", help="Come to rest at every pose.")] = False,
    output: Output = None,
    form: Format = None,
    force: Force = False,
    dt: Step = 0.01,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Plan the fastest spline through the poses under position, velocity and acceleration limits, or the usual ones."""
    origin = "ready" if start is None else start
    given = capped(arm, {"velocity": velocity, "acceleration": acceleration})
    limits = with_defaults(arm, given)
    outputs = outputs_of(output, {"csv": (".csv",), "json": (".json",)}, form, force=force, json=json)
    poses = _typed_poses(arm, (origin, *to), rad)
    with progress_bar("planning") as progress:
        planned = plan_joint(arm, poses, kind=kind.value, limits=limits, stop_at_waypoints=stop, progress=progress)
    if start is None:
        note(_start(arm, rad))
    for words in motors_beyond(planned):
        warn(words)
    written = outputs.write({"csv": lambda: csv_text(planned, dt), "json": lambda: json_text(planned, dt)})
    if json:
        print_json({**_as_json(arm, planned, written), "start": origin, "assumed": defaults_line(arm, given) or None})
        return
    if assumed := defaults_line(arm, given):
        say(f"{assumed} (--velocity, --acceleration)", file=outputs.words)
    console(outputs.words).print(plan_table(arm, planned, rad, limits))
    outputs.say(written)


def motors_beyond(planned: Trajectory) -> Iterator[str]:
    """Motors of which a plan asks more than they may do, mostly those that serve several joints, and what helps."""
    motors = planned.actuators
    if motors is None:
        return
    motion = planned.of_motors()
    for order, rate, per in ((1, "velocity", "/s"), (2, "acceleration", "/s²")):
        limit, peak = getattr(motors.limits, rate), motion.peak(order)
        for i in np.flatnonzero(peak > limit * (1.0 + RATE_TOL)):
            cap, unit = limit[i] / np.abs(motors.G[i]).sum(), motion.units[i] + per
            yield (
                f"motor {motors.names[i]!r} would need {number(peak[i])} {unit}; its {rate} limit is "
                f"{number(limit[i])} {unit}: --{rate} {_rounded_down(cap)} keeps it"
            )


def _rounded_down(cap: float) -> str:
    """A positive cap in three digits, as it is typed."""
    step = 10.0 ** (np.floor(np.log10(cap)) - 2)
    return f"{np.floor(cap / step) * step:.3g}"


def _typed_poses(arm: Arm, typed: tuple[str, ...], radians: bool) -> list[Array]:
    """The poses as typed; a joint that one leaves out stays where the pose before it has it."""
    poses = [parse_theta(arm, typed[0], radians)]
    for text in typed[1:]:
        poses.append(parse_theta(arm, text, radians, ("the pose before", poses[-1])))
    return poses


def capped(arm: Arm, caps: dict[str, float | None]) -> JointLimits:
    """The arm's limits, none above what was typed; a limit that was not given takes the typed value."""
    for name, cap in caps.items():
        if cap is not None:
            as_positive(cap, f"--{name}")
    changes = {name: np.minimum(getattr(arm.limits, name), cap) for name, cap in caps.items() if cap is not None}
    return arm.limits.with_(changes, arm.joint_names)


def _start(arm: Arm, radians: bool) -> str:
    """Where a plan starts that was not told: which pose `ready` is, as it would be typed."""
    name = named_ready(arm.named_states)
    which = "computed" if name is None else f"the pose named {name!r}"
    return f'starts at ready ({which}): --from "{theta_values(arm, arm.ready, radians)}"'


def plan_table(arm: Arm, planned: Trajectory, radians: bool, limits: JointLimits) -> Any:
    """When each pose is passed, and the peaks beside the limits that were kept."""
    columns = {
        f"at {number(time, 3)}\N{NO-BREAK SPACE}s": shown(arm, pose, radians)
        for time, pose in zip(planned.times, planned.waypoints, strict=True)
    }
    for order, per, word, limit in (
        (1, "/s", "velocity", limits.velocity),
        (2, "/s²", "acceleration", limits.acceleration),
    ):
        columns[f"peak {word} {per}"] = shown(arm, planned.peak(order), radians)
        if np.isfinite(limit).any():
            columns[f"{word} limit {per}"] = shown(arm, limit, radians)
    rows = [list(row) for row in zip(arm.joint_names, units(arm, radians), *columns.values(), strict=True)]
    title = f"{arm.name}: {number(planned.duration, 3)} s"
    return table(title, ["joint", "unit", *columns], rows, text=["unit"])


def _as_json(arm: Arm, planned: Trajectory, written: list[str]) -> dict[str, Any]:
    return {
        "arm": arm.name,
        "joint_names": planned.joint_names,
        "duration": planned.duration,
        "times": planned.times,
        "waypoints": planned.waypoints,
        "peak_velocity": planned.peak(1),
        "peak_acceleration": planned.peak(2),
        "written": written,
    }
