"""Motions that a command is asked for: of a file, or planned to typed goals, within typed limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from ..arm.arm import Arm
from ..arm.usual_limits import with_defaults
from ..limits.joint_limits import JointLimits
from ..planning import MotionFile, Trajectory, load_motion, load_trajectory, plan
from ..planning.segments import Segment, as_segments
from ..planning.trajectory import Progress
from .numbers import OfJoints, of_joints, quantity
from .options import avoided
from .output import progress_bar

if TYPE_CHECKING:
    from ..collision import Scene

CAP = "At most this for every joint, or for those in its unit; the arm's own limits hold as well."
Velocity = Annotated[OfJoints | None, quantity("rad/s m/s", CAP)]
Acceleration = Annotated[OfJoints | None, quantity("rad/s² m/s²", CAP)]

MAX_TIME = 5.0
"""Seconds for the way of a free move."""


def planned(
    arm: Arm, asked: MotionFile, limits: JointLimits, scene: Scene | None, max_time: float, progress: Progress
) -> tuple[Trajectory, list[Segment]]:
    """The motion of a motion.toml, or of typed goals in its place, and the segments with what holds for all of them."""
    segments = as_segments(
        asked.segments, asked.linear_speed, asked.angular_speed, asked.position_tol, asked.orientation_tol
    )
    how: dict[str, Any] = {"kind": asked.kind or "s_curve", "unwrap": asked.unwrap, "scene": scene}
    how |= {"max_time": max_time, "limits": limits, "start": asked.start, "progress": progress}
    return plan(arm, segments, **how), segments


def motion_of_file(
    arm: Arm, path: Path, velocity: OfJoints | None = None, acceleration: OfJoints | None = None
) -> tuple[Arm, Trajectory]:
    """The motion of a file, or of the segments of a *.toml, and the arm with its limits."""
    if path.suffix.lower() != ".toml":
        driven = replace(arm, limits=capped(arm, velocity, acceleration))
        return driven, load_trajectory(driven, path)
    asked = load_motion(path, arm)
    driven = replace(arm, limits=capped(arm, velocity, acceleration, asked.limits))
    scene = avoided(driven, asked.scene)
    with progress_bar("planning") as progress:
        return driven, planned(driven, asked, with_defaults(driven), scene, MAX_TIME, progress)[0]


def capped(
    arm: Arm, velocity: OfJoints | None, acceleration: OfJoints | None, changes: Mapping[str, Any] | None = None
) -> JointLimits:
    """The arm's limits, each at most the typed value. A missing limit takes the typed value."""
    limits = arm.limits.with_(changes or {}, arm.joint_names)
    caps = {"velocity": velocity, "acceleration": acceleration}
    typed = {name: of_joints(arm, cap, np.inf, f"--{name}") for name, cap in caps.items() if cap is not None}
    lowered = {name: np.minimum(getattr(limits, name), each) for name, each in typed.items()}
    return limits.with_(lowered, arm.joint_names)
