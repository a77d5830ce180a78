"""Route: the joint paths of a motion's segments, one after the other, without time."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..ik.explain import in_one_line
from ..ik.solve import solve_ik
from ..ik.targets import KINDS, AnyTarget, Approach, Pose, Position, target_for
from ..limits.joint_limits import JointLimits
from ..model.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError, NotConvergedError, UnknownNameError
from ..theory import rotations, screws
from .cartesian.branches import branches
from .cartesian.curves import Arc, Curve, Line, Screw
from .cartesian.following import Blocked, Followed, follow
from .cartesian.moving_target import MovingTarget
from .cartesian.refusal import refusal
from .joint_path import JointPath
from .segments import CONSTRAINED, ArcMove, Constrained, Dwell, Goal, JointMove, LineMove, ScrewMove, Segment, place
from .within import require_waypoints

Curved = LineMove | ScrewMove | ArcMove

MOST_BRANCHES = 48
"""Configurations in which a run of curves may begin that are tried, the nearest first."""

SAME = 1e-6
"""Efforts that differ by a smaller share are one: the nearer start is taken, whose other joints move least."""

COMPARED = 3
"""After the first of them from which the curves can be followed so many more are compared with it."""


@dataclass(frozen=True, eq=False)
class Leg:
    """What segment `index` makes: a joint path, or None for a dwell and where the arm is already."""

    index: int
    segment: Segment
    end: Array
    path: JointPath | None


class _BlockedError(Exception):
    """Curve `index` is blocked from `start` (n,) on; nobody has asked yet what would help."""

    def __init__(self, index: int, moving: MovingTarget, blocked: Blocked, start: Array) -> None:
        super().__init__(index)
        self.index, self.moving, self.blocked, self.start = index, moving, blocked, start

    @property
    def reached(self) -> float:
        """Segments done, and the share of the one that is blocked."""
        return self.index + self.blocked.share


class Router:
    """Finds the legs of a motion. `done(k)` is told how many segments have theirs."""

    def __init__(
        self, arm: Arm, segments: Sequence[Segment], limits: JointLimits, done: Callable[[int], object]
    ) -> None:
        self.arm, self.segments, self.limits, self.done = arm, segments, limits, done

    def legs(self, origin: Array) -> list[Leg]:
        """The legs from `origin` (n,) on; PathError, LimitError or NotConvergedError where there are none."""
        try:
            return self._legs(origin)
        except _BlockedError as error:
            words = refusal(self.arm, error.moving, error.blocked, error.start)
            raise words.within(error.index, self._place(error.index)) from None

    def _legs(self, origin: Array) -> list[Leg]:
        legs: list[Leg] = []
        theta = origin
        while len(legs) < len(self.segments):
            i = len(legs)
            segment = self.segments[i]
            run = self._curves_after(i)
            if isinstance(segment, JointMove) and isinstance(segment.to, KINDS) and run > i + 1:
                legs += self._to_target_and_on(i, run, theta)
            else:
                legs.append(self._leg(i, theta))
            theta = legs[-1].end
            self.done(len(legs))
        return legs

    def _curves_after(self, i: int) -> int:
        """The end of the run of curves and dwells that follows segment i."""
        end = i + 1
        while end < len(self.segments) and not isinstance(self.segments[end], JointMove):
            end += 1
        return end

    def _to_target_and_on(self, i: int, end: int, theta: Array) -> list[Leg]:
        """A joint move to a target and the curves after it, in the branch that takes the least joint motion."""
        move = self.segments[i]
        assert isinstance(move, JointMove)
        target = target_for(self.arm, move.to)
        starts = branches(self.arm, target, theta)
        if not len(starts):
            return [self._leg(i, theta)]  # which says why not
        best, least, farthest, compared = None, np.inf, None, 0
        for start in starts[:MOST_BRANCHES]:
            compared += best is not None
            if self._effort(theta, start) >= least or compared > COMPARED:
                break
            try:
                legs = [self._straight(i, move, theta, start)]
                for k in range(i + 1, end):
                    legs.append(self._leg(k, legs[-1].end))
            except _BlockedError as error:
                if farthest is None or error.reached > farthest.reached:
                    farthest = error
                continue
            effort = sum(self._path_effort(leg.path) for leg in legs if leg.path is not None)
            if effort < least * (1.0 - SAME):
                best, least = legs, effort
        if best is None:
            assert farthest is not None
            raise farthest
        return best

    def _leg(self, i: int, theta: Array) -> Leg:
        segment = self.segments[i]
        if isinstance(segment, Dwell):
            return Leg(i, segment, theta, None)
        if isinstance(segment, JointMove):
            return self._straight(i, segment, theta, self._configuration(i, segment.to, theta))
        return self._curve(i, segment, theta)

    def _straight(self, i: int, move: JointMove, start: Array, end: Array) -> Leg:
        if not np.abs(end - start).any():
            return Leg(i, move, end, None)
        return Leg(i, move, end, JointPath(np.array([0.0, 1.0]), np.stack([end - start, start])[:, None]))

    def _configuration(self, i: int, goal: Goal, theta: Array) -> Array:
        """Where a joint move goes; joints that a mapping leaves out stay."""
        if isinstance(goal, KINDS):
            solution = solve_ik(self.arm, goal, theta, posture="theta0")
            if not solution.converged:
                raise NotConvergedError(f"{self._place(i)}: {in_one_line(solution)}", solution)
            return solution.theta
        if isinstance(goal, Mapping):
            goal = {**self.arm.theta_to_dict(theta), **goal}
        try:
            end = self.arm.theta_from(goal, name="its goal")
        except (InputError, UnknownNameError) as error:
            raise type(error)(f"{self._place(i)}: {error}") from error
        if end.ndim != 1:
            raise InputError(f"{self._place(i)}: a goal must be one configuration ({self.arm.n},); got {end.shape}")
        require_waypoints(end[None], self.limits, self.arm.joint_names, self.arm.units, self._place(i))
        return end

    def _curve(self, i: int, move: Curved, start: Array) -> Leg:
        farthest: _BlockedError | None = None
        ways = [moving for moving in self._moving(i, move, start) if not moving.is_still]
        if not ways:
            raise InputError(f"{self._place(i)}: it ends where it begins: leave it out, or give it another goal")
        for moving in ways:
            result = follow(self.arm, moving, start)
            if isinstance(result, Followed):
                return Leg(i, move, result.path.end, result.path)
            if farthest is None or result.share > farthest.blocked.share:
                farthest = _BlockedError(i, moving, result, start)
        assert farthest is not None
        raise farthest

    def _moving(self, i: int, move: Curved, start: Array) -> list[MovingTarget]:
        """What is to be followed: of several the first that can be."""
        g0 = self.arm.fk(start)
        if move.to is None:
            return [MovingTarget(_free_curve(move, g0), like) for like in self._likes(move.constrain, g0)]
        likes, g1 = self._goal_pose(i, move.to, g0, start)
        try:
            return [MovingTarget(_curve_to(move, g0, g1), like) for like in likes]
        except InputError as error:
            raise InputError(f"{self._place(i)}: {error}") from error

    def _goal_pose(self, i: int, goal: Goal, g0: Array, start: Array) -> tuple[list[AnyTarget], Array]:
        """What the goal constrains, and the pose at the end: what it leaves free turns no more than it must."""
        if not isinstance(goal, KINDS):
            g1 = self.arm.fk(self._configuration(i, goal, start))
            return self._likes(None, g1), g1
        target = target_for(self.arm, goal)
        if isinstance(target, Position):
            return [target], _with_position(g0, target.p)
        if isinstance(target, Approach):
            g1 = _with_position(g0, target.p)
            g1[:3, :3] = _shortest_turn(g0[:3, :3] @ target.axis, target.direction) @ g0[:3, :3]
            return [target], g1
        return [target], target.g

    def _likes(self, constrain: Constrained | None, g: Array) -> list[AnyTarget]:
        """What of a pose is followed; unless it is said, by arms of fewer than six joints as much as they can."""
        if constrain is not None:
            return [_like(self.arm, constrain, g)]
        return [_like(self.arm, each, g) for each in (CONSTRAINED if self.arm.n < 6 else CONSTRAINED[:1])]

    def _effort(self, start: Array, end: Array) -> float:
        """The least time from one configuration to another at the greatest velocities [s]."""
        return float((np.abs(end - start) / self.limits.velocity).max())

    def _path_effort(self, path: JointPath) -> float:
        return path_effort(path, self.limits)

    def _place(self, i: int) -> str:
        return place(i, self.segments[i])


def path_effort(path: JointPath, limits: JointLimits) -> float:
    """The least time along a path at the greatest velocities [s], piece by piece from end to end."""
    points = path(path.breakpoints)
    return float((np.abs(np.diff(points, axis=0)) / limits.velocity).max(axis=1).sum())


def _free_curve(move: Curved, g0: Array) -> Curve:
    """The curve of a move that has no goal but says how it goes."""
    if isinstance(move, LineMove):
        offset = np.asarray(move.offset)
        return Line(g0, _with_position(g0, g0[:3, 3] + (g0[:3, :3] @ offset if move.frame == "tool" else offset)))
    assert move.twist is not None
    if isinstance(move, ArcMove) and not move.turn:
        return Arc(g0, move.twist, g0[:3, :3])
    return Screw(g0, move.twist)


def _curve_to(move: Curved, g0: Array, g1: Array) -> Curve:
    if isinstance(move, LineMove):
        return Line(g0, g1)
    if isinstance(move, ScrewMove):
        return Screw(g0, screws.log(g1 @ screws.inverse(g0)))
    return Arc.through(g0, np.asarray(move.via), g1)


def _like(arm: Arm, constrain: Constrained, g: Array) -> AnyTarget:
    if constrain == "pose":
        return Pose(g)
    if constrain == "approach":
        return Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis, arm.tool_axis)
    return Position(g[:3, 3])


def _with_position(g: Array, p: Any) -> Array:
    moved = np.array(g)
    moved[:3, 3] = p
    return moved


def _shortest_turn(a: Array, b: Array) -> Array:
    """The rotation (3, 3) by the least angle that takes the unit vector a to b; half a turn has many, and takes one."""
    axis = np.cross(a, b)
    sine, cosine = float(np.linalg.norm(axis)), float(a @ b)
    if sine < 1e-12:
        if cosine > 0.0:
            return np.eye(3)
        axis = np.cross(a, np.eye(3)[int(np.abs(a).argmin())])
    turn: Array = rotations.from_axis_angle(axis / np.linalg.norm(axis), float(np.arctan2(sine, cosine)))
    return turn
