"""The program of recorded poses: edit the list, go to a pose, plan a motion through them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...arm.usual_limits import defaults_line, with_defaults
from ...collision import Scene
from ...ik.targets import Position
from ...limits.joint_limits import JointLimits
from ...planning.configurations import LONGEST_JUMP
from ...planning.goals import Curved, Goals
from ...planning.joint_space import LAWS, plan_joint
from ...planning.keep import AS_AT_START
from ...planning.motion import plan
from ...planning.refusal import PathError
from ...planning.segments import ArcMove, FreeMove, JointMove, LineMove, ScrewMove
from ...planning.trajectory import Trajectory
from ...support.checks import Array, Progress
from ...support.directions import value_in_words
from ...support.errors import InputError
from ..jobs import Job, Memo, same
from ..messages import Message, page_words
from .arm_data import NO_PATH, distinct_points, tool_path
from .pose_list import FREE, PoseList, RecordedPose
from .show import Part, Playback, Route, Show

KEEP_TOL = np.radians(3.0)  # How far off the tool may be of what a free move keeps.
POINTS = 60  # Points of the ideal path from a pose to the next.


def segments(arm: Arm, poses: Sequence[RecordedPose], corner: float) -> list[JointMove | Curved]:
    """The segments through all poses, with corners rounded within `corner` [m].

    Raises InputError for an arc's via pose without the arc's end.
    """
    made: list[JointMove | Curved] = []
    for i, pose in enumerate(poses[1:], start=1):
        blend = corner if i + 1 < len(poses) else 0.0
        if poses[i - 1].by == "via" and i > 1:
            made.append(ArcMove(Position(arm.fk(poses[i - 1].theta)[:3, 3]), pose.theta, blend=blend))
        elif pose.by == "joint":
            made.append(JointMove(pose.theta, blend=blend))
        elif pose.by in FREE:
            keep = AS_AT_START[pose.by](tol=KEEP_TOL) if pose.by in AS_AT_START else None
            made.append(FreeMove(pose.theta, blend=blend, keep=keep))
        elif pose.by != "via":
            made.append((LineMove if pose.by == "line" else ScrewMove)(pose.theta, blend=blend))
        if pose.by == "via" and (i + 1 == len(poses) or poses[i + 1].by == "via"):
            raise InputError(
                f"the arc through '{pose.name}' ends at the next pose: record one, and choose a move other than arc"
            )
    return made


def ideal_path(arm: Arm, poses: Sequence[RecordedPose]) -> list[list[float]]:
    """Points [m] of the way that the segments describe, corners and all."""
    s, goals, at, parts = np.linspace(0.0, 1.0, POINTS), Goals(arm, arm.limits), poses[0].theta, list[Array]()
    for move in segments(arm, poses, 0.0):
        end: Any = move.to
        if isinstance(move, JointMove):
            parts.append(arm.fk(at + s[:, None] * (end - at))[:, :3, 3])
        else:
            parts += [moving.curve(s)[:, :3, 3] for moving in goals.moving(move, at, "the way")[:1]]
        at = end
    return distinct_points(arm, np.concatenate(parts)) if parts else []


STALE = "The list has changed since this motion was planned: plan again."

# Note on a motion that stops at each pose. "Straight" could be read as the tool's path.
STRAIGHT = "straight in joint space between the poses; the tool moves on a curve"
# Short words for reasons of a PathError. Other reasons are words themselves.
WHY = {"leap": "a joint would jump", "limit": "joint limits prevent it", "singular": "singular configuration"}
MOST_GHOSTS = 12  # Most poses at which the arm is drawn faintly, evenly chosen.


class MotionRequest(NamedTuple):
    """A requested motion: kind, stops or corner radius [m], the tool's speed limit [m/s] (0: none), payload [kg]."""

    kind: Any
    stop: bool
    corner: float
    linear_speed: float
    torques: bool
    payload: float

    def through_joints(self, poses: Sequence[RecordedPose]) -> bool:
        """Whether joint waypoints say it all, so that a spline may lead through them."""
        return all(pose.by == "joint" for pose in poses[1:]) and not self.linear_speed and self.kind in LAWS


NO_REQUEST = MotionRequest("", False, 0.0, 0.0, False, 0.0)

Planned = tuple[Trajectory | PathError, dict[str, Any]]  # A motion, or why there is none, and the tool's path.


class Program(Part):
    """The list of poses, and which of its states was planned."""

    def __init__(self, arm: Arm, poses: PoseList) -> None:
        self.list = poses
        self._arm, self.limits = arm, with_defaults(arm)
        self._usual = defaults_line(arm)
        self._motion: Trajectory | None = None
        self._through: tuple[tuple[int, str], ...] = ()
        self._request = NO_REQUEST
        self._message = Memo(self._described)
        self.routes = {
            "record": Route(lambda show, now, name: poses.record(name, show.theta)),
            "rename": Route(lambda show, now, id, name: poses.rename(id, name)),
            "move": Route(lambda show, now, id, by: poses.move(id, by)),
            "reorder": Route(lambda show, now, id, place: poses.reorder(id, place)),
            "delete": Route(lambda show, now, id: poses.delete(id)),
            "poses": Route(lambda show, now, joints, poses: self.list.replace(joints, poses)),
            "undo": Route(lambda show, now: poses.go_back("undo")),
            "redo": Route(lambda show, now: poses.go_back("redo")),
            "go": Route(lambda show, now, id, ease: show.go(poses.theta(id), ease, now), moves=True),
            "plan": Route(self._plan, moves=True),
        }

    def messages(self, show: Show) -> Iterator[Message]:
        """The list, its last changes, and whether the trajectory that is loaded is the one through it."""
        yield self._message(self.list.poses, None if show.playback is None else show.playback.trajectory)
        yield {"type": "history", **self.list.next_steps()}

    def _described(self, listed: tuple[RecordedPose, ...], loaded: Trajectory | None) -> Message:
        ours = loaded is not None and loaded is self._motion
        current = ours and self._through == _moves(listed)
        poses = [{"id": pose.id, **pose.entry()} for pose in listed]
        request = self._request if ours else NO_REQUEST
        straight = STRAIGHT if request.stop and request.through_joints(listed) else ""
        notes = self._motion.notes if current and self._motion else ()
        arrivals = _other_configurations(self._arm, self._motion, listed) if current and self._motion else ()
        words = [*arrivals, straight, *(_of_poses(note, listed) for note in notes), self._usual]
        sentences = " ".join(f"{text[0].upper()}{text[1:]}." for text in words if text)
        note = (sentences if current else STALE) if ours else ""
        message = {"type": "program", "poses": poses, "planned": current, "note": note}
        return {**message, **request._asdict(), "kind": request.kind or None}

    def _plan(self, show: Show, now: float, **fields: Any) -> Job:
        request, poses = MotionRequest(**fields), self.list.poses
        if len(poses) < 2:
            raise InputError(f"a motion needs at least two poses; the list has {len(poses)}: record another")
        if not np.ptp([pose.theta for pose in poses], axis=0).any():
            raise InputError("the poses of the list are all the same: there is no motion between them")
        if request.corner < 0.0 or request.linear_speed < 0.0:
            raise InputError("Round corners and Tool at most must be 0 or more: change them in the Poses panel")
        if show.scene is None and any(pose.by in FREE for pose in poses[1:]):
            raise InputError("to go round obstacles, turn on the layer Collision first")
        scene = copy(show.scene)  # obstacles may move meanwhile
        work = partial(_planned, show.arm, poses, request, self.limits, show.tolerances, scene)
        return Job("plan", "planning the motion", work, partial(self._finish, show, request, self._cause(show)))

    def _cause(self, show: Show) -> tuple[Any, ...]:
        """What a plan follows from: the list, the tolerances and the obstacles."""
        return self.list.poses, show.tolerances, *(() if show.scene is None else show.scene.obstacles.values())

    def _finish(self, show: Show, request: MotionRequest, cause: tuple[Any, ...], result: Planned) -> None:
        poses, (planned, path) = cause[0], result
        if isinstance(planned, PathError):
            show.draw_path(path, lambda: same(cause, self._cause(show)))
            end = _ends(poses)[-1 if planned.segment is None else planned.segment].name
            more = ", or choose another move for it" if planned.reason == "not kept" else ""
            raise InputError(f"on the way to '{end}' {page_words(planned.detail)}{more}")
        if show.driven:
            raise InputError("the motion is not loaded: a servo drives the arm; end it, then plan again")
        self._motion = planned
        self._through, self._request = _moves(poses), request
        before = show.playback or Playback(planned)
        show.load(planned, before.speed, before.loop)
        show.draw_path(NO_PATH)  # the path that shows again once another motion is loaded
        show.draw_path(path, lambda: show.playback is not None and show.playback.trajectory is planned)


def _planned(
    arm: Arm,
    poses: tuple[RecordedPose, ...],
    request: MotionRequest,
    limits: JointLimits,
    tolerances: Mapping[str, Any],
    scene: Scene | None,
    progress: Progress,
) -> Planned:
    """Plan in a thread."""
    drawn = {"ideal": ideal_path(arm, poses), **_ghosts(poses)}
    shared: dict[str, Any] = {"kind": request.kind, "limits": limits, "scene": scene, "progress": progress}
    shared |= {"torques": request.torques, "payload": request.payload}
    try:
        if request.through_joints(poses):
            points = np.array([pose.theta for pose in poses])
            motion = plan_joint(arm, points, stop_at_waypoints=request.stop, **shared)
        else:
            moves = segments(arm, poses, 0.0 if request.stop else request.corner)
            speed = request.linear_speed or None
            motion = plan(arm, moves, start=poses[0].theta, linear_speed=speed, **tolerances, **shared)
    except PathError as error:
        return error, {**tool_path(arm, poses[0].theta[None]), **drawn, "stopped": _stop(arm, error, scene)}
    return motion, {**tool_path(arm, motion), **drawn}


def _stop(arm: Arm, error: PathError, scene: Scene | None) -> dict[str, Any] | None:
    """Where a segment ends early: the tool's position, the reason, and the configuration."""
    if error.theta is None:
        return None
    position = np.round(arm.fk(error.theta)[:3, 3], 6).tolist()
    why = f"{error.joint} at its limit" if error.joint else WHY.get(error.reason, error.reason)
    words = f"stops at {100.0 * error.share:.0f} %: {why}" if error.reason != "not kept" else "not kept here"
    if error.reason == "collision":
        words = "collides" if scene is not None and scene.collides(error.theta) else "no free path from here"
    return {"position": position, "words": words, "arm": error.theta.tolist()}


def _ghosts(poses: Sequence[RecordedPose]) -> dict[str, Any]:
    """Configurations of MOST_GHOSTS of the recorded poses or fewer, and the numbers of these poses."""
    chosen = np.unique(np.linspace(0, len(poses) - 1, min(len(poses), MOST_GHOSTS)).round().astype(int))
    return {"waypoints": [poses[i].theta.tolist() for i in chosen], "ids": [poses[i].id for i in chosen]}


def _ends(poses: Sequence[RecordedPose]) -> list[RecordedPose]:
    """The poses at which the segments end."""
    return [pose for pose in poses[1:] if pose.by != "via"]


def _other_configurations(arm: Arm, motion: Trajectory, poses: Sequence[RecordedPose]) -> Iterator[str]:
    """The poses that the motion meets with the tool, and not in the recorded configuration."""
    for pose, theta in zip(_ends(poses), motion.waypoints[1:], strict=False):
        j = int(np.abs(theta - pose.theta).argmax())
        if abs(off := float(theta[j] - pose.theta[j])) > LONGEST_JUMP:
            by = value_in_words(off, arm.units[j])
            yield f"'{pose.name}' is reached in another configuration: {arm.joint_names[j]} differs by {by}"


def _of_poses(note: str, poses: Sequence[RecordedPose]) -> str:
    """The planner's note with poses in place of segments."""
    return re.sub(r"segment (\d+) \(\w+\)", lambda found: f"'{_ends(poses)[int(found[1]) - 1].name}'", page_words(note))


def _moves(poses: Sequence[RecordedPose]) -> tuple[tuple[int, str], ...]:
    """What the plan depends on: the poses in order and the move to each."""
    return tuple((pose.id, pose.by if i else "") for i, pose in enumerate(poses))
