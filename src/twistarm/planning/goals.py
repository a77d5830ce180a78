"""Goals: the configuration at the end of a move, and the curve that leads there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..ik.solution import in_one_line
from ..ik.solve import solve_ik
from ..ik.targets import KINDS, AnyTarget, Approach, Pose, Position, shape_hint, target_for
from ..ik.task_space import Tolerances
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError, NotConvergedError, UnknownNameError
from ..support.messages import joined
from ..theory import rotations, screws
from .configurations import are_wide
from .curves import Curve, MovingTarget, arc, line, screw
from .segments import CONSTRAINED, ArcMove, Constrained, JointMove, LineMove, ScrewMove
from .waypoints import as_tolerances
from .within import require_waypoints

Curved = LineMove | ScrewMove | ArcMove
CURVED = (LineMove, ScrewMove, ArcMove)


@dataclass(frozen=True, eq=False)
class Goals:
    """The ends of an arm's moves. `where` names a segment in errors.

    With `unwrap`, joints go to configurations by the shorter way, by whole turns. `exactly`: curves are met exactly
    where they can be, unless the tolerances are wide.
    """

    arm: Arm
    limits: JointLimits
    unwrap: bool = False
    exactly: bool = True

    def tolerances(self, move: JointMove | Curved) -> Tolerances:
        """Return how far off the targets of a move still count as met."""
        return as_tolerances(move.position_tol, move.orientation_tol)

    def configuration(self, move: JointMove | Curved, theta: Array, where: str) -> Array:
        """Return the end of a move from theta (n,). Joints that a mapping leaves out stay."""
        goal: Any = move.to
        met = self.tolerances(move)
        if isinstance(goal, KINDS):
            solution = solve_ik(self.arm, goal, theta, **met.keywords, posture="theta0")
            if not solution.converged:
                raise NotConvergedError(joined(": ", [where, in_one_line(solution)]), solution)
            return solution.theta
        if isinstance(goal, Mapping):
            goal = {**self.arm.theta_to_dict(theta), **goal}
        try:
            end = self.arm.theta_from(goal, name="its goal")
        except (InputError, UnknownNameError) as error:
            raise type(error)(joined("", [f"{where}: ", error.message, shape_hint(goal)])) from error
        if end.ndim != 1:
            raise InputError(f"{where}: a goal must be one configuration ({self.arm.n},); got {end.shape}")
        require_waypoints(end[None], self.limits, self.arm.joint_names, self.arm.units, where)
        return end

    def moving(self, move: Curved, start: Array, where: str) -> list[MovingTarget]:
        """Return what to follow from start (n,), best first; nothing if the move ends there."""
        g0, met = self.arm.fk(start), self.tolerances(move)
        leeway = None if self.exactly and not are_wide(met) else met
        if move.to is None:
            found = [MovingTarget(_free_curve(move, g0), like, met, leeway) for like in self._likes(move.constrain, g0)]
        else:
            likes, g1 = self._goal_pose(move, g0, start, where)
            try:
                found = [MovingTarget(_curve_to(move, g0, g1), like, met, leeway) for like in likes]
            except InputError as error:
                raise InputError(joined(": ", [where, error.message])) from error
        return [each for each in found if not each.is_still]

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
            g1[:3, :3] = _shortest_turn(g0[:3, :3] @ target.axis, target.direction) @ g0[:3, :3]
            return [target], g1
        return [target], target.g

    def _likes(self, constrain: Constrained | None, g: Array) -> list[AnyTarget]:
        """Return what to follow of a pose. By default arms of fewer than six joints follow as much as they can."""
        if constrain is not None:
            return [_like(self.arm, constrain, g)]
        return [_like(self.arm, each, g) for each in (CONSTRAINED if self.arm.n < 6 else CONSTRAINED[:1])]


def _free_curve(move: Curved, g0: Array) -> Curve:
    """Return the curve of a move without a goal."""
    if isinstance(move, LineMove):
        offset = np.asarray(move.offset)
        return line(g0, _with_position(g0, g0[:3, 3] + (g0[:3, :3] @ offset if move.frame == "tool" else offset)))
    assert move.twist is not None
    if isinstance(move, ArcMove) and not move.turn:
        return Curve(g0, move.twist, np.zeros(3))
    return screw(g0, move.twist)


def _curve_to(move: Curved, g0: Array, g1: Array) -> Curve:
    if isinstance(move, LineMove):
        return line(g0, g1)
    if isinstance(move, ScrewMove):
        return screw(g0, screws.log(g1 @ screws.inverse(g0)))
    return arc(g0, np.asarray(move.via), g1)


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
    """Return the rotation (3, 3) by the least angle from the unit vector a to b."""
    axis = np.cross(a, b)
    sine, cosine = float(np.linalg.norm(axis)), float(a @ b)
    if sine < 1e-12:
        if cosine > 0.0:
            return np.eye(3)
        axis = np.cross(a, np.eye(3)[int(np.abs(a).argmin())])
    return rotations.from_axis_angle(axis / np.linalg.norm(axis), float(np.arctan2(sine, cosine)))
