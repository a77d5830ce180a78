"""`plan`: a trajectory through poses or targets, or of a motion.toml, to a table and to files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, with_defaults
from ...limits.joint_limits import JointLimits
from ...planning import ActiveLimit, Trajectory, active_limits, load_motion
from ...planning.files.c_header import SUFFIXES, header_text
from ...planning.files.csv_file import csv_text
from ...planning.files.joint_trajectory import json_text
from ...planning.files.mcap_file import mcap_bytes
from ...planning.joint_space import Kind
from ...support.errors import InputError
from ..asked_motion import Typed, capped, typed_targets
from ..command import POSE, RPY, XYZ
from ..options import ArmArgument, Avoid, Json, Radians, avoided
from ..output import note, progress_bar
from ..outputs import STDOUT, Contents, Force, Format, Outputs, outputs_of, repeated
from ..quantities import OfJoints, quantity
from ..tables import Column, Table, number, theta_values
from ..targets import Axis, OrientationTol, PositionTol, typed_tolerances

MOST_STRETCHES = 8
"""So many rows of active limits are shown; --json has them all."""

MOTION_KINDS = {"csv": (".csv",), "json": (".json",), "header": SUFFIXES, "mcap": (".mcap",)}
"""The kinds of files that hold a motion."""

COUNTED = ("csv", "header")
"""The kinds of files that may hold what drives count in place of the joints."""


TIMING = typer.Option(
    help="How it is timed. Through poses: cubic unless given. With --line, --xyz or a motion.toml: s_curve unless "
    "given, or time_optimal, quintic."
)
Start = Annotated[
    str | None, typer.Option("--from", metavar=POSE, help="Where it starts, as --to; unless given, the ready pose.")
]
Motion = Annotated[
    str | None, typer.Argument(metavar="[MOTION]", help="A motion.toml; twistarm init --motion writes one.")
]
Through = Annotated[
    list[str] | None,
    typer.Option(
        "--to",
        metavar=POSE,
        help="Joint values (0 30 -45 …), joint=value for those that move, or a pose's name; repeat it for each pose.",
    ),
]
Positions = Annotated[
    list[str] | None,
    typer.Option("--xyz", metavar=XYZ, help="Instead of --to: where the tool is to be, in metres; repeat it."),
]
Line = Annotated[bool, typer.Option("--line", help="The tool goes along straight lines from pose to pose.")]
Rpys = Annotated[
    list[str] | None,
    typer.Option(
        "--rpy",
        metavar=RPY,
        help="Orientation at --xyz: turns about the base's x, y and z axes, in this order [°, or rad with --rad]; one "
        "for all positions, or repeated for each.",
    ),
]
Directions = Annotated[
    list[str] | None,
    typer.Option(
        "--direction",
        metavar=XYZ,
        help="Only where the tool points at --xyz, in base axes; turning about that is free. One for all positions, or "
        "repeated for each.",
    ),
]
Blend = Annotated[
    float | None,
    quantity("m", "Round the corners of --line or --xyz inside this radius; without it: stop there.", zero=True),
]
ToolSpeed = Annotated[
    float | None, quantity("m/s", "The tool goes no faster, with --line, --xyz or a motion.toml.", "--linear-speed")
]
CAP = "At most this for every joint, or for those in its unit; the arm's own limits hold as well."
Velocity = Annotated[OfJoints | None, quantity("rad/s m/s", CAP)]
Acceleration = Annotated[OfJoints | None, quantity("rad/s² m/s²", CAP)]
Output = Annotated[
    list[str] | None,
    repeated(
        "Write time, position, velocity and acceleration to *.csv, a ROS JointTrajectory to *.json, "
        "ROS 2 messages to *.mcap, a C99 and C++17 header to *.h; with [actuators] what the motors do and their drives "
        "count as well, but in *.mcap. - is standard output"
    ),
]
Unwrap = Annotated[
    bool,
    typer.Option(
        "--unwrap", help="Continuous joints go to poses by the shorter way, by whole turns; to --xyz they always do."
    ),
]
Smooth = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE",
        help="How far the path may leave the poses of --to, recorded ones with noise, to be smooth [°, or rad with "
        "--rad; a slide by as many m as rad].",
    ),
]
MaxTime = Annotated[
    float, quantity("s", "With --avoid: give up the way to a goal after so many seconds.", "--max-time")
]
Counts = Annotated[
    bool, typer.Option("--counts", help="Write what the motors' drives count alone, for firmware that knows no joints.")
]
Step = Annotated[float, quantity("s", "Time step of the files.")]


def plan(
    source: ArmArgument,
    motion: Motion = None,
    to: Through = None,
    xyz: Positions = None,
    rpy: Rpys = None,
    direction: Directions = None,
    axis: Axis = None,
    line: Line = False,
    start: Start = None,
    kind: Annotated[Kind | None, TIMING] = None,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    linear_speed: ToolSpeed = None,
    stop: Annotated[bool, typer.Option("--stop", help="Come to rest at every pose.")] = False,
    blend: Blend = None,
    smooth: Smooth = None,
    unwrap: Unwrap = False,
    position_tol: PositionTol = None,
    orientation_tol: OrientationTol = None,
    avoid: Avoid = None,
    max_time: MaxTime = 5.0,
    output: Output = None,
    form: Format = None,
    force: Force = False,
    counts: Counts = False,
    dt: Step = 0.01,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Plan the fastest motion through poses, targets or the segments of a file, within the limits."""
    arm = source.load()
    if [motion is not None, bool(to), bool(xyz)].count(True) != 1:
        raise InputError("give poses by --to, positions by --xyz, or a motion.toml")
    if smooth is not None and (line or not to or avoid):
        raise InputError("--smooth is about poses that a motion passes: it goes with --to alone")
    met = typed_tolerances(position_tol, orientation_tol, rad)
    asked = Typed(arm, start, rad, line, stop, blend, linear_speed, kind, met, unwrap, None, max_time)
    asked.require_fitting(by_file=motion is not None, by_joints=not (xyz or line or avoid), goals=len(to or xyz or ()))
    targets = typed_targets(xyz or (), rpy or (), direction or (), axis, rad)
    file = None if motion is None else load_motion(motion, arm)
    scene = avoided(arm, avoid or (None if file is None or file.scene is None else str(file.scene)))
    asked = replace(asked, scene=scene)
    given = capped(arm, {"velocity": velocity, "acceleration": acceleration}, {} if file is None else file.limits)
    limits = with_defaults(arm, given)
    out = outputs_of(output, MOTION_KINDS, form, force=force, json=json, radians=rad)
    if counts and any(kind not in COUNTED for kind, _ in out.files):
        raise InputError("--counts goes with *.csv and *.h: a JointTrajectory is in rad and m")
    with progress_bar("planning") as progress:
        if file is not None:
            planned, segments = asked.of_file(file, limits, progress)
        elif xyz or line or scene:
            planned, segments = asked.through(targets or asked.poses(to)[1:], limits, progress)
        else:
            planned, segments = asked.by_waypoints(to, smooth, limits, progress)
    origin = asked.origin(file)
    if origin is None:
        name = arm.ready_name
        which = "computed" if name is None else f"the pose named {name!r}"
        note(f'starts at ready ({which}): --from "{theta_values(arm, arm.ready, rad)}"')
    for each in planned.notes:
        note(each, radians=rad)
    assumed = defaults_line(arm, given)
    nearest = None if scene is None else scene.clearance(planned.breakpoints, planned.coefficients)
    data = {
        "arm": arm,
        "duration": planned.duration,
        "times": planned.times,
        "waypoints": planned.waypoints,
        "start": "ready" if origin is None else origin,
        "assumed": assumed or None,
        "nearest": nearest,
        "notes": planned.notes,
    }
    out.show(
        data,
        *([f"{assumed} (--velocity, --acceleration)"] if assumed else []),
        *plan_tables(arm, planned, limits),
        active_limits_table(active_limits(arm, planned, limits=limits, segments=segments)),
        *([] if nearest is None else [f"nearest: {nearest}"]),
        files=motion_texts(arm, planned, out, dt, counts=counts),
    )


def motion_texts(arm: Arm, planned: Trajectory, outputs: Outputs, dt: float, *, counts: bool = False) -> Contents:
    """What writes a motion of the arm, by the kind of file."""
    header = next((name for kind, name in outputs.files if kind == "header" and name != STDOUT), "motion.h")
    return {
        "csv": lambda: csv_text(planned, dt, counts=counts),
        "json": lambda: json_text(planned, dt),
        "header": lambda: header_text(planned, header, counts=counts),
        "mcap": lambda: mcap_bytes(planned, arm, dt),
    }


def plan_tables(arm: Arm, planned: Trajectory, limits: JointLimits) -> tuple[Table, Table]:
    """When each pose is passed, and the peaks beside the limits that were kept."""
    joints = Column("joint", planned.joint_names, key="joint_names")
    poses = [
        Column(f"at {number(time, 3)}\N{NO-BREAK SPACE}s", pose, arm.units)
        for time, pose in zip(planned.times, planned.waypoints, strict=True)
    ]
    peaks = []
    for order, per, word in ((1, "/s", "velocity"), (2, "/s²", "acceleration")):
        limit = getattr(limits, word)
        peaks.append(Column(f"peak {word}", planned.peak(order), arm.units, per))
        peaks.append(Column(f"{word} limit", limit, arm.units, per, people=bool(np.isfinite(limit).any())))
    return Table(f"{arm.name}: {number(planned.duration, 3)} s", [joints, *poses]), Table("", [joints, *peaks], "")


def active_limits_table(active: Sequence[ActiveLimit]) -> Table:
    """The limit that each stretch of a motion uses most. People see the longest stretches, in time order."""
    longest = sorted(range(len(active)), key=lambda i: active[i].begin - active[i].end)[:MOST_STRETCHES]
    left = len(active) - len(longest)
    columns = [
        Column("begin", [each.begin for each in active], "s", digits=3),
        Column("end", [each.end for each in active], "s", digits=3),
        Column("rate", [each.rate for each in active], text=[each.describe() for each in active]),
        *(Column(name, [getattr(each, name) for each in active], people=False) for name in ("owner", "name")),
        Column("share", [each.share for each in active], text=[f"{each.share:.0%}" for each in active]),
    ]
    title = "limits used most" + (f" ({left} shorter stretches are in --json)" if left else "")
    return Table(title, columns, "active_limits", rows=sorted(longest))
