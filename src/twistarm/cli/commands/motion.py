"""Motions of a file or to typed goals. `plan` writes them to a table and to files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from ... import planning
from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, with_defaults
from ...collision import Scene
from ...limits.joint_limits import JointLimits
from ...planning.keep import AS_AT_START, Keep
from ...planning.motion import MotionKind, came_nearer
from ...planning.segments import CLEARANCE, OPTIONAL, as_segments
from ...planning.trajectory import Writing
from ...planning.trajectory_files import FORMATS, written
from ...support.checks import Progress
from ...support.errors import InputError
from ..numbers import JointValues, OfJoints, argument, joint_values, of_joints, option, quantity, switch
from ..options import ArmArgument, Avoid, Offset, answers, avoided
from ..output import STDOUT, Contents, Outputs, entries, note, progress_bar, refuse
from ..rows import OrientationTol, PositionTol, TargetOptions
from ..tables import Column, Table, number, theta_values

CAP = "At most this for every joint, or for those in its unit; the arm's own or assumed limits hold as well."
# Follows assumed limits.
HOW_TO_CHANGE = "an arm.toml gives others; --velocity and --acceleration only lower them"
Velocity = Annotated[OfJoints | None, quantity("rad/s m/s", CAP)]
Acceleration = Annotated[OfJoints | None, quantity("rad/s² m/s²", CAP)]

MAX_TIME = 5.0  # Seconds for the way of a free move.


def planned(
    arm: Arm, asked: planning.MotionFile, limits: JointLimits, scene: Scene | None, max_time: float, progress: Progress,
    clearance: float = CLEARANCE,
) -> tuple[planning.Trajectory, list[planning.Segment]]:  # fmt: skip
    """The motion of a motion.toml or of typed goals. Its segments have what holds for all of them."""
    segments = as_segments(asked.segments, **{name: getattr(asked, name) for name in OPTIONAL})
    how: dict[str, Any] = {"kind": asked.kind or "s_curve", "unwrap": asked.unwrap, "scene": scene}
    how |= {"torques": asked.torques, "payload": asked.payload}
    how |= {"max_time": max_time, "clearance": clearance, "limits": limits, "start": asked.start, "progress": progress}
    return planning.plan(arm, segments, **how), segments


def motion_of_file(
    arm: Arm, path: Path, velocity: OfJoints | None = None, acceleration: OfJoints | None = None
) -> tuple[Arm, planning.Trajectory]:
    """The motion of a file, or of the segments of a *.toml, and the arm with its limits."""
    if path.suffix.lower() != ".toml":
        driven = replace(arm, limits=capped(arm, velocity, acceleration))
        return driven, planning.load_trajectory(driven, path)
    asked = planning.load_motion(path, arm)
    driven = replace(arm, limits=capped(arm, velocity, acceleration, asked.limits))
    scene = avoided(driven, asked.scene)
    with progress_bar("planning") as progress:
        return driven, planned(driven, asked, with_defaults(driven), scene, MAX_TIME, progress)[0]


def capped(
    arm: Arm, velocity: OfJoints | None, acceleration: OfJoints | None, changes: Mapping[str, Any] | None = None
) -> JointLimits:
    """The arm's limits, each at most the typed value. A missing limit takes it where it is not above the default."""
    limits = arm.limits.with_(changes or {}, arm.joint_names)
    usual = with_defaults(arm, limits)
    caps = {"velocity": velocity, "acceleration": acceleration}
    typed = {name: of_joints(arm, cap, np.inf, f"--{name}") for name, cap in caps.items() if cap is not None}
    lowered = {
        name: np.where(each <= getattr(usual, name), each, getattr(limits, name)) for name, each in typed.items()
    }
    return limits.with_(lowered, arm.joint_names)


MOST_STRETCHES = 8  # So many rows of active limits are shown; --json has them all.
# The kinds of files that hold a motion.
MOTION_KINDS = {kind: form.endings for kind, form in FORMATS.items() if form.write}

Written = Annotated[
    Outputs,
    answers(
        "output form force rad json",
        MOTION_KINDS,
        output="Write time, position, velocity and acceleration to *.csv, a ROS JointTrajectory to *.json, ROS 2 "
        "messages to *.mcap, a C99 and C++17 header to *.h; with [actuators] what the motors do and their drives count "
        "as well, but in *.mcap. - is standard output; repeat it.",
    ),
]
TIMING = option(
    None, "How it is timed: s_curve unless given, or time_optimal; with --line, --xyz or a motion.toml also quintic."
)
Start = Annotated[
    JointValues | None, joint_values("Where it starts, as --to; unless given, the configuration ready.", "--from")
]
Motion = Annotated[str | None, argument("[MOTION]", "A motion.toml; twistarm init --motion writes one.")]
Through = Annotated[
    list[Any] | None,
    joint_values(
        "Joint values (0 30 -45 …), joint=value for those that move, or a configuration's name; may be repeated.",
        "--to",
    ),
]
Line = Annotated[bool, switch("The tool goes along straight lines between the configurations.", "--line")]
Blend = Annotated[
    float | None,
    quantity("m", "Round the corners of --line or --xyz inside this radius; without it: stop there.", zero=True),
]
ToolSpeed = Annotated[float | None, quantity("m/s", "The tool goes no faster, with --line, --xyz or a motion.toml.")]
Unwrap = Annotated[
    bool,
    switch("Continuous joints go to --to by the shorter way, by whole turns; to --xyz they always do.", "--unwrap"),
]
Torques = Annotated[
    bool, switch("The efforts of joints and motors limit the motion too, by the masses of the arm.", "--torques")
]
Mass = Annotated[float | None, quantity("kg", "With --torques: what the tool carries.", zero=True)]
Smooth = Annotated[
    float | None,
    quantity(
        "rad",
        "How far the path may leave the configurations of --to, recorded ones with noise, to be smooth [°, or rad with "
        "--rad; a slide by as many m as rad].",
    ),
]
MaxTime = Annotated[float, quantity("s", "With --avoid: give up the way to a goal after so many seconds.")]
Clearance = Annotated[float, quantity("m", "With --avoid: the distance that states of the search keep; a note tells if "
                                           "the motion comes nearer.", zero=True)]  # fmt: skip
Kept = Annotated[
    Literal["level", "direction", "orientation"] | None,
    option(
        None,
        "With --avoid: what the tool keeps as at the start: level (turning about the vertical is free), the direction "
        "of its axis, or its orientation; a motion.toml can keep more.",
        "--keep",
    ),
]
KeepTol = Annotated[
    float | None, quantity("rad", "How far off --keep the tool may be [°, or rad with --rad]; 3° unless given.")
]
Counts = Annotated[
    bool, switch("Write what the motors' drives count alone, for firmware that knows no joints.", "--counts")
]
Step = Annotated[float, quantity("s", "Time step of the files.")]


def plan(
    source: ArmArgument,
    out: Written,
    at: TargetOptions,
    motion: Motion = None,
    to: Through = None,
    line: Line = False,
    start: Start = None,
    kind: Annotated[MotionKind | None, TIMING] = None,
    velocity: Velocity = None,
    acceleration: Acceleration = None,
    linear_speed: ToolSpeed = None,
    stop: Annotated[bool, switch("Come to rest at every configuration.", "--stop")] = False,
    blend: Blend = None,
    smooth: Smooth = None,
    unwrap: Unwrap = False,
    position_tol: PositionTol = None,
    orientation_tol: OrientationTol = None,
    torques: Torques = False,
    mass: Mass = None,
    offset: Offset = None,
    avoid: Avoid = None,
    max_time: MaxTime = MAX_TIME,
    clearance: Clearance = CLEARANCE,
    keep: Kept = None,
    keep_tol: KeepTol = None,
    counts: Counts = False,
    dt: Step = 0.01,
) -> None:
    """Plan the fastest motion through configurations, targets or the segments of a file, within the limits."""
    arm = source.load()
    about_tool = {"linear_speed": linear_speed, "position_tol": position_tol, "orientation_tol": orientation_tol}
    typed: dict[str, Any] = {name: value for name, value in about_tool.items() if value is not None}
    targets = at.all()
    _require_fitting(motion, to, targets, line, avoid, stop, blend, smooth, kind, typed)
    kept = _kept(keep, keep_tol, avoid is not None and not line and motion is None)
    if counts and not all(FORMATS[kind].counts for kind, _ in out.files):
        raise InputError("--counts goes with *.csv and *.h: a JointTrajectory is in rad and m")
    if counts and arm.actuators is None:
        raise InputError(f"--counts is about motors: describe those of {arm.name} as [actuators.NAME] in its arm.toml")
    if offset is not None and mass is None:
        raise InputError("--offset is where the mass of --mass is: give both")
    waypoints = [arm.ready if start is None else start.of(arm)]
    for values in to or ():
        waypoints.append(values.of(arm, ("the configuration before", waypoints[-1])))
    if motion is not None:
        asked = planning.load_motion(motion, arm)
    else:
        move = planning.LineMove if line else partial(planning.FreeMove, keep=kept) if avoid else planning.JointMove
        *corners, last = targets or waypoints[1:]
        asked = planning.MotionFile((*(move(goal, blend=blend or 0.0) for goal in corners), move(last)))
    typed |= {} if start is None else {"start": waypoints[0]}
    typed |= {} if mass is None else {"payload": mass if offset is None else (mass, offset)}
    asked = replace(
        asked, **typed, kind=kind or asked.kind, unwrap=unwrap or asked.unwrap, torques=torques or asked.torques
    )
    efforts: dict[str, Any] = {"torques": asked.torques, "payload": asked.payload}
    scene = avoided(arm, avoid or asked.scene)
    given = capped(arm, velocity, acceleration, asked.limits)
    limits = with_defaults(arm, given)
    segments: list[planning.Segment] = []
    with progress_bar("planning") as progress:
        if to and not line and scene is None:  # a spline passes them without a stop; moves would stop at each
            how: dict[str, Any] = {"kind": kind or "s_curve", "stop_at_waypoints": stop, "unwrap": unwrap, **efforts}
            how |= {} if smooth is None else {"smooth": smooth}
            found = planning.plan_joint(arm, waypoints, limits=limits, progress=progress, **how)
        else:
            found, segments = planned(arm, asked, limits, scene, max_time, progress, clearance)
    # A start that nobody typed is told, because the arm may stand elsewhere.
    origin = asked.start if start is None else start.text
    if origin is None:
        which = "computed" if arm.ready_name is None else f"the one named {arm.ready_name!r}"
        note(f'starts at ready ({which}): --from "{theta_values(arm, arm.ready, out.radians)}"')
    nearest = None if scene is None else scene.clearance(found)
    if nearest is not None and any(isinstance(move, planning.FreeMove) for move in segments):
        found = replace(found, notes=tuple(dict.fromkeys([*found.notes, *came_nearer(nearest, clearance)])))
    for remark in found.notes:
        note(remark, radians=out.radians)
    assumed = defaults_line(arm, given)
    data = {"arm": arm, "start": origin or "ready", "assumed": assumed or None, "nearest": nearest}
    out.show(
        data | entries(found, "duration times waypoints notes"),
        *([f"{assumed} ({HOW_TO_CHANGE})"] if assumed else []),
        *plan_tables(arm, found, limits),
        active_limits_table(planning.active_limits(arm, found, limits=limits, segments=segments, **efforts)),
        *([] if nearest is None else [f"nearest: {nearest}"]),
        files=motion_texts(arm, found, out, dt, counts=counts),
    )


def _require_fitting(
    motion: str | None, to: Any, xyz: Any, line: bool, avoid: Any, stop: bool, blend: float | None, smooth: Any,
    kind: str | None, about_tool: dict[str, Any],
) -> None:  # fmt: skip
    """Raise InputError for an option that has no effect beside the others."""
    by_joints = bool(to) and not (line or avoid)
    refuse({
        f"give configurations by --to, positions by --xyz, or a motion.toml{f'; got {motion!r} too' if motion else ''}":
            bool(motion) + bool(to) + bool(xyz) != 1,
        "--smooth is about configurations on the way: it goes with --to alone": smooth is not None and not by_joints,
        "a motion.toml says how it goes to each goal: leave out --line, --stop and --blend":
            bool(motion) and (line or stop or blend is not None),
        "--stop comes to rest at every configuration, --blend rounds the corners there: give one of them":
            stop and blend is not None,
        "--blend, --linear-speed, --position-tol and --orientation-tol are about the way of the tool: add --line, or "
        "give positions by --xyz": by_joints and (blend is not None or bool(about_tool)),
        "--blend rounds the corners between goals: give two of them, or leave it out":
            blend is not None and len(to or xyz) < 2,
        "--kind quintic is for moves of the tool; through --to: s_curve or time_optimal":
            kind == "quintic" and by_joints,
    })  # fmt: skip


def _kept(keep: str | None, tol: float | None, free: bool) -> Keep | None:
    """What --keep keeps, which goes with free moves."""
    if keep is None:
        if tol is not None:
            raise InputError("--keep-tol goes with --keep, which says what is kept")
        return None
    if not free:
        raise InputError("--keep goes with --avoid, without --line; in a motion.toml, keep stands beside free")
    # 3° in place of the library's 0.05 rad: a round number in the unit that is typed.
    return AS_AT_START[keep](tol=np.radians(3.0) if tol is None else tol)


def motion_texts(
    arm: Arm, planned: planning.Trajectory, outputs: Outputs, dt: float, *, counts: bool = False
) -> Contents:
    """What writes a motion of the arm, by the kind of file."""
    header = next((name for kind, name in outputs.files if kind == "header" and name != STDOUT), "motion.h")
    how = Writing(dt, arm, counts=counts, name=header)
    return {kind: partial(written, planned, kind, how) for kind in MOTION_KINDS}


def plan_tables(arm: Arm, planned: planning.Trajectory, limits: JointLimits) -> tuple[Table, Table]:
    """When each waypoint is passed, and the peaks beside the limits that were kept."""
    joints = Column("joint", planned.joint_names, key="joint_names")
    waypoints = [
        Column(f"at {number(time, 3)}\N{NO-BREAK SPACE}s", theta, arm.units)
        for time, theta in dict(zip(planned.times.tolist(), planned.waypoints, strict=True)).items()  # each time once
    ]
    peaks = []
    for order, per, word in ((1, "/s", "velocity"), (2, "/s²", "acceleration")):
        limit = getattr(limits, word)
        peaks.append(Column(f"peak {word}", planned.peak(order), arm.units, per))
        peaks.append(Column(f"{word} limit", limit, arm.units, per, people=bool(np.isfinite(limit).any())))
    return Table(f"{arm.name}: {number(planned.duration, 3)} s", [joints, *waypoints]), Table("", [joints, *peaks], "")


def active_limits_table(active: Sequence[planning.ActiveLimit]) -> Table:
    """The limit that each stretch of a motion uses most. People see the longest stretches, in time order."""
    longest = sorted(range(len(active)), key=lambda i: active[i].begin - active[i].end)[:MOST_STRETCHES]
    left = len(active) - len(longest)
    columns = [
        Column("begin", [stretch.begin for stretch in active], "s", digits=3),
        Column("end", [stretch.end for stretch in active], "s", digits=3),
        Column("rate", [stretch.rate for stretch in active], text=[stretch.describe() for stretch in active]),
        *(Column(name, [getattr(stretch, name) for stretch in active], people=False) for name in ("owner", "name")),
        Column("share", [stretch.share for stretch in active], text=[f"{stretch.share:.0%}" for stretch in active]),
    ]
    title = "limits used most" + (f" ({left} shorter stretches are in --json)" if left else "")
    return Table(title, columns, "active_limits", rows=sorted(longest))
