"""The motion of a command line: its options, its typed goals and their plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arm.arm import Arm
from ..arm.usual_limits import with_defaults
from ..limits.joint_limits import JointLimits
from ..planning import FreeMove, JointMove, LineMove, MotionFile, Trajectory, load_motion, load_trajectory, plan_joint
from ..planning import plan as plan_segments
from ..planning.motion import LAWS, as_segments
from ..planning.segments import Segment
from ..planning.spans import Progress
from ..support.checks import Array, as_positive
from ..support.errors import InputError
from .options import avoided
from .output import progress_bar
from .quantities import OfJoints, of_joints
from .targets import Target, typed_orientation
from .typed import parse_numbers, parse_theta

if TYPE_CHECKING:
    from ..collision import Scene

Caps = Mapping[str, OfJoints | None]
"""The greatest velocity and acceleration of joints, as typed."""

Planned = tuple[Trajectory, list[Segment]]
"""A motion, and the segments that it was planned by."""


@dataclass(frozen=True)
class Typed:
    """The arm, the typed start and the options. None and False mean not typed."""

    arm: Arm
    start: str | None = None
    radians: bool = False
    line: bool = False
    stop: bool = False
    blend: float | None = None
    linear_speed: float | None = None
    kind: str | None = None
    tolerances: Mapping[str, Any] = field(default_factory=dict)
    unwrap: bool = False
    scene: Scene | None = None
    max_time: float = 5.0

    def require_fitting(self, *, by_file: bool, by_joints: bool, goals: int) -> None:
        """Raise InputError for an option that has no effect beside the others."""
        typed = {"--line": self.line, "--stop": self.stop, "--blend": self.blend is not None}
        idle = [option for option, is_typed in typed.items() if is_typed]
        if by_file and idle:
            raise InputError(f"a motion.toml says itself how it goes to each goal: leave out {' and '.join(idle)}")
        if self.stop and self.blend is not None:
            raise InputError("--stop comes to rest at every pose, --blend rounds the corners there: give one of them")
        tool = {"--blend": self.blend is not None, "--linear-speed": self.linear_speed is not None}
        tool |= {f"--{name.replace('_', '-')}": True for name in self.tolerances}
        about_tool = [option for option, is_typed in tool.items() if is_typed]
        if not by_file and by_joints and about_tool:
            raise InputError(f"{about_tool[0]} is about the way of the tool: add --line, or give positions by --xyz")
        if self.blend is not None and goals < 2:
            raise InputError("--blend rounds the corners between goals: give two of them, or leave it out")
        if self.kind is not None and self.kind not in LAWS and (by_file or not by_joints):
            *others, last = LAWS
            laws = f"{', '.join(others)} or {last}"
            raise InputError(f"--kind {self.kind} leads through the poses of --to alone; on other motions: {laws}")

    def origin(self, file: MotionFile | None = None) -> Any:
        """The start as typed, or of the file; None for the pose ready."""
        return self.start if self.start is not None or file is None else file.start

    def poses(self, typed: Sequence[str] | None) -> list[Array]:
        """The typed start and poses. A joint that a pose leaves out keeps its value of the pose before."""
        poses = [parse_theta(self.arm, "ready" if self.start is None else self.start, self.radians)]
        for text in typed or ():
            poses.append(parse_theta(self.arm, text, self.radians, ("the pose before", poses[-1])))
        return poses

    def of_file(self, content: MotionFile, limits: JointLimits, progress: Progress) -> Planned:
        """The motion of a motion.toml. Typed options win over the file."""
        start: Any = content.start if self.start is None else self.poses(())[0]
        speed = content.linear_speed if self.linear_speed is None else self.linear_speed
        met = {"position_tol": content.position_tol, "orientation_tol": content.orientation_tol, **self.tolerances}
        segments = as_segments(content.segments, speed, content.angular_speed, **met)
        scene = self.scene or avoided(self.arm, None if content.scene is None else str(content.scene))
        how: Any = {"kind": self.kind or content.kind or "s_curve", "unwrap": self.unwrap or content.unwrap}
        how |= {"scene": scene, "max_time": self.max_time}
        return plan_segments(self.arm, segments, start=start, limits=limits, progress=progress, **how), segments

    def by_waypoints(
        self, typed: Sequence[str] | None, smooth: str | None, limits: JointLimits, progress: Progress
    ) -> Planned:
        """A motion that passes the typed poses, or leaves them by up to `smooth` [°, or rad with --rad]."""
        how: Any = {"kind": self.kind or "cubic", "stop_at_waypoints": self.stop, "unwrap": self.unwrap}
        if smooth is not None:
            (angle,) = parse_numbers(smooth, "rad", "--smooth", self.radians)
            how["smooth"] = as_positive(angle, "--smooth")
        return plan_joint(self.arm, self.poses(typed), limits=limits, progress=progress, **how), []

    def through(self, goals: Sequence[Any], limits: JointLimits, progress: Progress) -> Planned:
        """A motion by the same kind of move to each goal."""
        move = LineMove if self.line else JointMove if self.scene is None else FreeMove
        blends = [self.blend or 0.0] * (len(goals) - 1) + [0.0]
        segments: list[Segment] = [
            move(goal, linear_speed=self.linear_speed, blend=blend, **self.tolerances)
            for goal, blend in zip(goals, blends, strict=True)
        ]
        how: Any = {"kind": self.kind or "s_curve", "unwrap": self.unwrap, "start": self.poses(())[0]}
        how |= {"scene": self.scene, "max_time": self.max_time}
        return plan_segments(self.arm, segments, limits=limits, progress=progress, **how), segments


def typed_targets(
    xyz: Sequence[str], rpy: Sequence[str], direction: Sequence[str], axis: str | None, radians: bool
) -> list[Target]:
    """The targets at positions, with one orientation for all or one for each."""
    if (rpy or direction or axis) and not xyz:
        raise InputError("--rpy, --direction and --axis turn the tool at the positions of --xyz: give --xyz too")
    option, turned = ("--rpy", rpy) if rpy else ("--direction", direction)
    if turned and len(turned) not in (1, len(xyz)):
        raise InputError(
            f"give one {option} for all positions, or one for each: {len(turned)} go with {len(xyz)} --xyz"
        )
    targets = []
    for k, text in enumerate(xyz):
        # Both kinds at once are refused where they are read.
        one_rpy, one_direction = (each[k % len(each)] if each else None for each in (rpy, direction))
        orientation = typed_orientation(one_rpy, None, None, one_direction, axis, radians)
        targets.append(orientation.at(parse_numbers(text, "m m m", "--xyz")))
    return targets


def motion_of_file(arm: Arm, path: Path, caps: Caps) -> tuple[Arm, Trajectory]:
    """The motion of a file, or of the segments of a *.toml, and the arm with its limits."""
    if path.suffix.lower() != ".toml":
        driven = replace(arm, limits=capped(arm, caps))
        return driven, load_trajectory(driven, path)
    content = load_motion(path, arm)
    driven = replace(arm, limits=capped(arm, caps, content.limits))
    with progress_bar("planning") as progress:
        motion, _ = Typed(driven).of_file(content, with_defaults(driven), progress)
    return driven, motion


def capped(arm: Arm, caps: Caps, changes: Mapping[str, Any] | None = None) -> JointLimits:
    """The arm's limits, each at most the typed value. A missing limit takes the typed value."""
    limits = arm.limits.with_(changes or {}, arm.joint_names)
    typed = {name: of_joints(arm, cap, np.inf, f"--{name}") for name, cap in caps.items() if cap is not None}
    lowered = {name: np.minimum(getattr(limits, name), each) for name, each in typed.items()}
    return limits.with_(lowered, arm.joint_names)
