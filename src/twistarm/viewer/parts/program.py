"""Program of recorded poses: the list is edited, one is gone to, a motion is planned through all of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...model.usual_limits import defaults_line, with_defaults
from ...planning.joint_space import Kind, plan_joint
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.errors import InputError
from ..protocol.jobs import Job, Progress
from ..protocol.message_cache import Message
from ..protocol.messages import Request
from .part import Show
from .pose_list import PoseList, RecordedPose
from .tool_path import tool_path

STALE = "The list has changed since this motion was planned: plan again."

STRAIGHT = "straight in joint space between the poses: the tool's way is a curve"
"""What is said of a motion that stops at each pose: straight, people take for the tool's way."""


class Program:
    """The list of poses, and which of its states was planned."""

    requests = frozenset({"record", "rename", "reorder", "delete", "go", "poses", "plan"})

    def __init__(self, arm: Arm) -> None:
        self.list = PoseList(arm)
        self.limits = with_defaults(arm)
        self._usual = defaults_line(arm)
        self._motion: Trajectory | None = None
        self._through: tuple[int, ...] = ()
        self._asked: tuple[Kind | None, bool] = (None, False)
        self._shown: tuple[Any, ...] = ()
        self._message: Message = {}

    def handle(self, request: Request, show: Show, now: float) -> Job | None:
        """Do what a page asks for; a plan is a job. TwistarmError, and nothing changed, where it cannot."""
        kind, fields = request.kind, request.fields
        if kind == "plan":
            return self._plan(fields["kind"], fields["stop"], show)
        if kind == "record":
            self.list.record(fields["name"], show.theta)
        elif kind == "rename":
            self.list.rename(fields["id"], fields["name"])
        elif kind == "reorder":
            self.list.reorder(fields["id"], fields["place"])
        elif kind == "delete":
            self.list.delete(fields["id"])
        elif kind == "go":
            show.go(self.list.theta(fields["id"]), fields["ease"], now)
        else:
            self.list.replace(fields["joints"], fields["poses"])
        return None

    def messages(self, show: Show) -> Iterator[Message]:
        """The list, and whether the trajectory that is loaded is the one through it."""
        at = show.playback
        loaded = None if at is None else at.trajectory
        shown = (self.list.poses, loaded)
        if len(self._shown) != 2 or any(old is not new for old, new in zip(self._shown, shown, strict=True)):
            self._shown, self._message = shown, self._words(loaded is not None and loaded is self._motion)
        yield self._message

    def follow(self, other: Program) -> None:
        """Take over which motion `other` planned, and through which poses: the list is the same or it is not."""
        poses = [(pose.name, pose.theta.tolist()) for pose in self.list.poses]
        self._motion = other._motion
        if poses == [(pose.name, pose.theta.tolist()) for pose in other.list.poses]:
            self._through = _ids(self.list.poses) if other._through == _ids(other.list.poses) else ()

    def _words(self, ours: bool) -> Message:
        current = ours and self._through == _ids(self.list.poses)
        poses = [{"id": pose.id, "name": pose.name, "theta": pose.theta.tolist()} for pose in self.list.poses]
        kind, stop = self._asked if ours else (None, False)
        straight = STRAIGHT if stop or kind == "trapezoid" else ""
        note = ("; ".join(filter(None, (straight, self._usual))) if current else STALE) if ours else ""
        return {"type": "program", "poses": poses, "planned": current, "kind": kind, "stop": stop, "note": note}

    def _plan(self, kind: Kind, stop: bool, show: Show) -> Job:
        poses = self.list.poses
        if len(poses) < 2:
            raise InputError(f"a motion needs at least two poses; the list has {len(poses)}: record another")
        points = np.array([pose.theta for pose in poses])
        if not np.ptp(points, axis=0).any():
            raise InputError("the poses of the list are all the same: there is no motion between them")
        work = partial(self._work, show.arm, points, kind, stop)
        return Job("plan", "planning the motion", work, partial(self._finish, show, poses, (kind, stop)))

    def _work(
        self, arm: Arm, points: Array, kind: Kind, stop: bool, progress: Progress
    ) -> tuple[Trajectory, dict[str, Any]]:
        """In a thread: the motion, and the way of the tool."""
        motion = plan_joint(arm, points, kind=kind, limits=self.limits, stop_at_waypoints=stop, progress=progress)
        return motion, tool_path(arm, motion)

    def _finish(
        self,
        show: Show,
        poses: tuple[RecordedPose, ...],
        asked: tuple[Kind, bool],
        result: tuple[Trajectory, dict[str, Any]],
    ) -> None:
        if show.driven:
            raise InputError("the motion was planned and not loaded: a servo drives the arm meanwhile")
        self._motion, path = result
        self._through, self._asked = _ids(poses), asked
        show.stand_by(self._motion, self.limits)
        show.draw_path(path)


def _ids(poses: tuple[RecordedPose, ...]) -> tuple[int, ...]:
    return tuple(pose.id for pose in poses)
