"""Segments for `plan` from a list of recorded poses, and the ideal path."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...ik.targets import Position
from ...planning.goals import Curved, Goals
from ...planning.segments import ArcMove, FreeMove, JointMove, LineMove, ScrewMove
from ...support.checks import Array
from ...support.errors import InputError
from .pose_list import RecordedPose
from .tool_path import drawn

POINTS = 60
"""Points of the ideal path from a pose to the next."""


def segments(arm: Arm, poses: Sequence[RecordedPose], corner: float) -> list[JointMove | Curved]:
    """The segments through all poses, with corners rounded within `corner` [m].

    Raises InputError for an arc's via pose without the arc's end.
    """
    made: list[JointMove | Curved] = []
    for i, pose in enumerate(poses[1:], start=1):
        blend = corner if i + 1 < len(poses) else 0.0
        if poses[i - 1].by == "via" and i > 1:
            made.append(ArcMove(Position(arm.fk(poses[i - 1].theta)[:3, 3]), pose.theta, blend=blend))
        elif pose.by in ("joint", "free"):
            made.append((JointMove if pose.by == "joint" else FreeMove)(pose.theta, blend=blend))
        elif pose.by != "via":
            made.append((LineMove if pose.by == "line" else ScrewMove)(pose.theta, blend=blend))
        if pose.by == "via" and (i + 1 == len(poses) or poses[i + 1].by == "via"):
            raise InputError(
                f"an arc leads through '{pose.name}' to the pose after it: that must be there, and be an end itself"
            )
    return made


def ideal_way(arm: Arm, poses: Sequence[RecordedPose]) -> list[list[float]]:
    """Points [m] of the way that the segments describe, corners and all."""
    s, goals, at, ways = np.linspace(0.0, 1.0, POINTS), Goals(arm, arm.limits), poses[0].theta, list[Array]()
    for move in segments(arm, poses, 0.0):
        end: Any = move.to
        if isinstance(move, JointMove):
            ways.append(arm.fk(at + s[:, None] * (end - at))[:, :3, 3])
        else:
            ways += [each.curve(s)[:, :3, 3] for each in goals.moving(move, at, "the way")[:1]]
        at = end
    return drawn(arm, np.concatenate(ways)) if ways else []
