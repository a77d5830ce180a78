"""`plan`: a trajectory through poses or targets, or of a motion.toml, to a table and to files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...limits.joint_limits import JointLimits
from ...model.arm import Arm
from ...model.ready_pose import named_ready
from ...model.usual_limits import defaults_line, with_defaults
from ...planning import (
    Binding,
    JointMove,
    LineMove,
    MotionFile,
    Trajectory,
    binding_limits,
    load_motion,
    load_trajectory,
    plan_joint,
)
from ...planning import plan as plan_segments
from ...planning.files.c_header import SUFFIXES, header_text
from ...planning.files.csv_file import csv_text
from ...planning.files.joint_trajectory import json_text, yaml_text
from ...planning.motion import as_segments
from ...planning.segments import Segment
from ...planning.spans import Progress
from ...support.checks import Array, as_positive
from ...support.errors import InputError
from ..options import Json, Radians, takes_arm
from ..output import console, note, number, print_json, progress_bar, say, shown, table, theta_values, units
from ..outputs import STDOUT, Force, Format, outputs_of
from ..targets import Axis, Direction, Rpy, typed_orientation
from ..typed import POSE, XYZ, parse_numbers, parse_theta

MOST_STRETCHES = 8
"""So many rows of binding limits are shown; --json has them all."""

COUNTED = ("csv", "header")
"""The kinds of files that may hold what drives count in place of the joints."""


class Kind(str, Enum):
    """The kind of motion."""

    cubic = "cubic"
    quintic = "quintic"
    trapezoid = "trapezoid"
    time_optimal = "time_optimal"
    s_curve = "s_curve"


Start = Annotated[
    str | None, typer.Option("--from", metavar=POSE, help="Where it starts, as --to; unless given, the ready pose.")
]
Motion = Annotated[
    str | None,
    typer.Argument(metavar="[MOTION]", help="A motion.toml; twistarm init --motion writes one."),
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
Blend = Annotated[float, typer.Option(metavar="M", help="Round the corners of --line or --xyz inside this radius.")]
ToolSpeed = Annotated[
    float | None, typer.Option("--tool-speed", metavar="M/S", help="The tool goes no faster, with --line or --xyz.")
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
        help="Write time, position, velocity and acceleration to *.csv, or a ROS JointTrajectory to *.json or *.yaml, "
        "a C99 and C++17 header to *.h; with [actuators] what the motors do and their drives count as well. - is "
        "standard output; repeat it.",
    ),
]
Counts = Annotated[
    bool, typer.Option("--counts", help="Write what the motors' drives count alone, for firmware that knows no joints.")
]
Step = Annotated[float, typer.Option(help="Time step of the files, in seconds.")]


@takes_arm
def plan(
    arm: Arm,
    motion: Motion = None,
    to: Through = None,
    xyz: Positions = None,
    rpy: Rpy = None,
    direction: Direction = None,
    axis: Axis = None,
    line: Line = False,
    blend: Blend = 0.0,
    tool_speed: ToolSpeed = None,
    start: Start = None,
    kind: Annotated[Kind | None, typer.Option(help="cubic unless given; with curves of the tool s_curve.")] = None,
    velocity: Rate = None,
    acceleration: Rate = None,
    stop: Annotated[bool, typer.Option("--stop", help="Come to rest at every pose.")] = False,
    output: Output = None,
    form: Format = None,
    force: Force = False,
    counts: Counts = False,
    dt: Step = 0.01,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Plan the fastest motion through poses, targets or the segments of a file, under the limits or the usual ones."""
    if [motion is not None, bool(to), bool(xyz)].count(True) != 1:
        raise InputError("give poses by --to, positions by --xyz, or a motion.toml")
    file = None if motion is None else load_motion(motion, arm)
    given = capped(arm, {"velocity": velocity, "acceleration": acceleration}, {} if file is None else file.limits)
    limits = with_defaults(arm, given)
    outputs = outputs_of(
        output,
        {"csv": (".csv",), "json": (".json",), "yaml": (".yaml", ".yml"), "header": SUFFIXES},
        form,
        force=force,
        json=json,
    )
    if counts and any(kind not in COUNTED for kind, _ in outputs.files):
        raise InputError("--counts goes with *.csv and *.h: a JointTrajectory is in rad and m")
    orientation = typed_orientation(rpy, None, None, direction, axis, rad)
    if orientation.is_given and not xyz:
        raise InputError("--rpy and --direction turn the tool at the positions of --xyz: give --xyz too")
    origin = "ready" if start is None else start
    asked = Asked(arm, limits, None if kind is None else kind.value, start, rad)
    with progress_bar("planning") as progress:
        if file is not None:
            planned, segments = asked.of_file(file, progress)
        elif xyz or line:
            goals = [orientation.at(parse_numbers(text, 3, "--xyz")) for text in xyz] if xyz else asked.poses(to)[1:]
            options: dict[str, Any] = {"tool_speed": tool_speed, "blend": 0.0 if stop else blend}
            planned, segments = asked.through(goals, LineMove if line else JointMove, options, progress)
        else:
            poses = asked.poses(to)
            how: Any = "cubic" if kind is None else kind.value
            planned = plan_joint(arm, poses, kind=how, limits=limits, stop_at_waypoints=stop, progress=progress)
            segments = []
    if start is None and motion is None:
        note(_start(arm, rad))
    header = next((name for kind, name in outputs.files if kind == "header" and name != STDOUT), "motion.h")
    written = outputs.write(
        {
            "csv": lambda: csv_text(planned, dt, counts=counts),
            "json": lambda: json_text(planned, dt),
            "yaml": lambda: yaml_text(planned, dt),
            "header": lambda: header_text(planned, header, counts=counts),
        }
    )
    binding = binding_limits(arm, planned, limits=limits, segments=segments)
    if json:
        said = {"start": origin, "assumed": defaults_line(arm, given) or None}
        print_json({**_as_json(arm, planned, written), **said, "binding": [asdict(each) for each in binding]})
        return
    if assumed := defaults_line(arm, given):
        say(f"{assumed} (--velocity, --acceleration)", file=outputs.words)
    console(outputs.words).print(plan_table(arm, planned, rad, limits))
    if binding:
        console(outputs.words).print(binding_table(binding))
    outputs.say(written)


Caps = Mapping[str, float | None]
"""The greatest velocity and acceleration of any joint, as typed."""

Planned = tuple[Trajectory, list[Segment]]
"""A motion, and the segments that it was planned by."""


@dataclass(frozen=True)
class Asked:
    """What is asked of every motion: the arm, its limits, the kind, and where it starts as typed."""

    arm: Arm
    limits: JointLimits
    kind: str | None
    start: str | None
    radians: bool

    def poses(self, typed: Sequence[str] | None) -> list[Array]:
        """The start and the poses as typed; a joint that one leaves out stays where the pose before it has it."""
        poses = [parse_theta(self.arm, "ready" if self.start is None else self.start, self.radians)]
        for text in typed or ():
            poses.append(parse_theta(self.arm, text, self.radians, ("the pose before", poses[-1])))
        return poses

    def of_file(self, content: MotionFile, progress: Progress) -> Planned:
        """The motion of a motion.toml; what is typed beside it goes before what it says."""
        start: Any = content.start if self.start is None else self.poses(())[0]
        kind: Any = self.kind or content.kind or "s_curve"
        segments = as_segments(content.segments, content.tool_speed, content.turn_speed)
        return self._planned(segments, start, kind, progress)

    def through(
        self, goals: Sequence[Any], move: type[JointMove | LineMove], options: dict[str, Any], progress: Progress
    ) -> Planned:
        """A motion by the same kind of move to each goal."""
        last = {**options, "blend": 0.0}
        segments: list[Segment] = []
        for i, goal in enumerate(goals):
            segments.append(move(goal, **(last if i + 1 == len(goals) else options)))
        return self._planned(segments, self.poses(())[0], self.kind or "s_curve", progress)

    def _planned(self, segments: list[Segment], start: Any, kind: Any, progress: Progress) -> Planned:
        motion = plan_segments(self.arm, segments, start=start, limits=self.limits, kind=kind, progress=progress)
        return motion, segments


def motion_of_file(arm: Arm, path: Path, caps: Caps) -> tuple[Arm, Trajectory]:
    """The motion that a file holds, or that its segments describe (*.toml), and the arm with the limits it keeps."""
    if path.suffix.lower() != ".toml":
        driven = replace(arm, limits=capped(arm, caps))
        return driven, load_trajectory(driven, path)
    content = load_motion(path, arm)
    driven = replace(arm, limits=capped(arm, caps, content.limits))
    with progress_bar("planning") as progress:
        motion, _ = Asked(driven, with_defaults(driven), None, None, False).of_file(content, progress)
    return driven, motion


def capped(arm: Arm, caps: Caps, changes: Mapping[str, Any] | None = None) -> JointLimits:
    """The arm's limits with `changes`, none above what was typed; a limit that was not given takes the typed value."""
    limits = arm.limits.with_(changes or {}, arm.joint_names)
    for name, cap in caps.items():
        if cap is not None:
            as_positive(cap, f"--{name}")
    lowered = {name: np.minimum(getattr(limits, name), cap) for name, cap in caps.items() if cap is not None}
    return limits.with_(lowered, arm.joint_names)


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


def binding_table(binding: Sequence[Binding]) -> Any:
    """The limit that each stretch of a motion uses most; of many, the longest in the order of time."""
    longest = sorted(binding, key=lambda each: each.begin - each.end)[:MOST_STRETCHES]
    rows = [
        [number(each.begin, 3), number(each.end, 3), each.describe(), f"{100.0 * each.share:.0f} %"]
        for each in sorted(longest, key=lambda each: each.begin)
    ]
    left = len(binding) - len(longest)
    title = "limits used most" + (f" ({left} shorter stretches are in --json)" if left else "")
    return table(title, ["from [s]", "to [s]", "limit", "used"], rows, text=["limit"])


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
