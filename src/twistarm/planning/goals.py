"""Goals: the configuration at the end of a move, and the curve that leads there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..ik.targets import KINDS, AnyTarget, Approach, Pose, Position, shape_hint, target_for
from ..ik.task_space import Tolerances
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError, UnknownNameError
from ..support.messages import joined
from ..theory import rotations, screws
from ..theory.lines import least_turn
from .curves import Curve, MovingTarget, arc, line
from .segments import CONSTRAINED, ArcMove, Constrained, JointMove, LineMove, ScrewMove
from .waypoints import as_tolerances, solved
from .within import on_limits

Curved = LineMove | ScrewMove | ArcMove
CURVED = (LineMove, ScrewMove, ArcMove)


@dataclass(frozen=True, eq=False)
class Goals:
    """The ends of an arm's moves. `where` names a segment in errors.

    With `unwrap`, joints go to configurations by the shorter way, by whole turns. `exactly`: curves are met exactly
    where they can be, otherwise within the tolerances from the first.
    """

    arm: Arm
    limits: JointLimits
    unwrap: bool = False
    exactly: bool = True

    def tolerances(self, move: JointMove | Curved) -> Tolerances:
        """Return how far off the targets of a move still count as reached."""
        return as_tolerances(move.position_tol, move.orientation_tol)

    def configuration(self, move: JointMove | Curved, theta: Array, where: str) -> Array:
        """Return the end of a move from theta (n,). Joints that a mapping leaves out stay."""
        goal: Any = move.to
        tolerances = self.tolerances(move)
        if isinstance(goal, KINDS):
            return solved(self.arm, goal, theta, where, **tolerances.keywords, posture="theta0")
        if isinstance(goal, Mapping):
            goal = {**self.arm.theta_to_dict(theta), **goal}
        try:
            end = self.arm.theta_from(goal, name="its goal")
        except (InputError, UnknownNameError) as error:
            raise type(error)(joined("", [f"{where}: ", error.message, shape_hint(goal)])) from error
        if end.ndim != 1:
            raise InputError(f"{where}: a goal must be one configuration ({self.arm.n},); got {end.shape}")
        inside: Array = on_limits(end[None], self.limits, self.arm.joint_names, self.arm.units, where)[0]
        return inside

    def moving(self, move: Curved, start: Array, where: str) -> list[MovingTarget]:
        """Return what to follow from start (n,), best first; nothing if the move ends there."""
        g0, tolerances = self.arm.fk(start), self.tolerances(move)
        if move.to is None:
            likes, g1 = self._likes(move.constrain, g0), None
        else:
            likes, g1 = self._goal_pose(move, g0, start, where)
        try:
            curve = _curve(move, g0, g1)
        except InputError as error:
            raise InputError(joined(": ", [where, error.message])) from error
        found = [MovingTarget(curve, like, tolerances, self.exactly) for like in likes]
        return [moving for moving in found if not moving.is_still]

    def _goal_pose(self, move: Curved, g0: Array, start: Array, where: str) -> tuple[list[AnyTarget], Array]:
        """Return the goal's target, and an end pose with the least turn of its free parts."""
        if not isinstance(move.to, KINDS):
            g1 = self.arm.fk(self.configuration(move, start, where))
            return self._likes(None, g1), g1
        target = target_for(self.arm, move.to)
        if isinstance(target, Position):
            return [target], _with_position(g0, target.p)
        if isinstance(target, Approach):
            g1 = _with_position(g0, target.p)
            g1[:3, :3] = rotations.exp(least_turn(g0[:3, :3] @ target.axis, target.direction)) @ g0[:3, :3]
            return [target], g1
        return [target], target.g

    def _likes(self, constrain: Constrained | None, g: Array) -> list[AnyTarget]:
        """Return what to follow of a pose. By default arms of fewer than six joints follow as much as they can."""
        p, axis = g[:3, 3], self.arm.tool_axis
        likes: list[AnyTarget] = [Pose(g), Approach(p, g[:3, :3] @ axis, axis), Position(p)]
        if constrain is None:
            return likes if self.arm.n < 6 else likes[:1]
        return [likes[CONSTRAINED.index(constrain)]]


def _curve(move: Curved, g0: Array, g1: Array | None) -> Curve:
    """Return the curve of a move from pose g0 to g1 (4, 4). Without a goal the move says how far it goes."""
    if isinstance(move, LineMove):
        if g1 is None:
            offset = np.asarray(move.offset)
            g1 = _with_position(g0, g0[:3, 3] + (g0[:3, :3] @ offset if move.frame == "tool" else offset))
        return line(g0, g1)
    if isinstance(move, ArcMove) and g1 is not None:
        return arc(g0, np.asarray(move.via), g1)
    twist = np.asarray(move.twist) if g1 is None else screws.log(g1 @ screws.inverse(g0))  # MLS §2.3.3
    return Curve(g0, twist, np.zeros(3) if isinstance(move, ArcMove) and not move.turn else twist[3:])


def _with_position(g: Array, p: Any) -> Array:
    moved = np.array(g)
    moved[:3, 3] = p
    return moved
