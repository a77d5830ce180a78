"""Segments for `plan` from a list of recorded poses, and the ideal path."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arm.arm import Arm
from ...ik.targets import Position
from ...planning.cartesian.curves import Curve, arc, line, screw
from ...planning.segments import ArcMove, FreeMove, JointMove, LineMove, ScrewMove, Segment
from ...support.checks import Array
from ...support.errors import InputError
from ...theory import screws
from .pose_list import RecordedPose
from .tool_path import drawn

POINTS = 60
"""Points of the ideal path from a pose to the next."""


def segments(arm: Arm, poses: Sequence[RecordedPose], corner: float) -> list[Segment]:
    """The segments through all poses, with corners rounded within `corner` [m].

    Raises InputError for an arc's via pose without the arc's end.
    """
    made: list[Segment] = []
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
    s = np.linspace(0.0, 1.0, POINTS)
    ways: list[Array] = []
    for i, pose in enumerate(poses[1:], start=1):
        last = poses[i - 1]
        through = last.by == "via" and i > 1
        if pose.by == "via" and not through:
            continue
        if pose.by in ("joint", "free") and not through:
            g = arm.fk(last.theta + s[:, None] * (pose.theta - last.theta))
        else:
            g = _curve(arm, poses[i - 2 if through else i - 1], last if through else None, pose)(s)
        ways.append(g[:, :3, 3])
    return drawn(arm, np.concatenate(ways)) if ways else []


def _curve(arm: Arm, start: RecordedPose, via: RecordedPose | None, end: RecordedPose) -> Curve:
    g0, g1 = arm.fk(start.theta), arm.fk(end.theta)
    if via is not None:
        return arc(g0, arm.fk(via.theta)[:3, 3], g1)
    return line(g0, g1) if end.by == "line" else screw(g0, screws.log(g1 @ screws.inverse(g0)))
