"""Motions in a scene: free moves avoid obstacles, and the whole motion is proven free."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..arm.arm import Arm
from ..collision import Scene
from ..ik import solve_ik
from ..ik.targets import KINDS
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import NotConvergedError
from .cartesian.refusal import PathError
from .free_path import free_path
from .segments import FreeMove, Move, Segment, place
from .trajectory import Trajectory
from .within import require_waypoints

ROUNDED, LARGEST = 0.45, 0.1
"""Radius of a rounded corner: greatest share of the way to the nearer neighbour, and of the arm's reach."""

Planner = Callable[[Sequence[Segment]], Trajectory]
"""Plans segments from the start of the motion."""


def planned_in(
    scene: Scene, arm: Arm, segments: list[Segment], origin: Array, limits: JointLimits, max_time: float, plan: Planner
) -> Trajectory:
    """The motion of `plan` through `segments`, every `FreeMove` replaced by joint moves round obstacles.

    Corners are rounded if the motion stays free then. Raises PathError, with time, segment and pair, for a collision.
    """
    ways = _free_paths(scene, arm, segments, origin, limits, max_time, plan)
    for rounded in (True, False):
        expanded, numbers = _expanded(arm, segments, ways, rounded)
        motion = plan(expanded)
        hit = scene.first_collision(motion.breakpoints, motion.coefficients)
        if hit is None:
            return motion
        k = int(np.clip(np.searchsorted(motion.times, hit.time, side="right") - 1, 0, len(numbers) - 1))
        said = f"{place(numbers[k], segments[numbers[k]])} collides {hit.time:.2f} s after the start"
        pairs = ", ".join(map(str, hit.contacts[:2])) or "a near miss"
    raise PathError(f"{said}: {pairs}; let it go round with FreeMove, or choose another goal")


def _free_paths(
    scene: Scene, arm: Arm, segments: list[Segment], origin: Array, limits: JointLimits, max_time: float, plan: Planner
) -> list[Array]:
    """Per segment the waypoints (k, n) of its free path with both ends; (0, n) for other moves."""
    ways: list[Array] = []
    at, known = origin, 0
    for i, segment in enumerate(segments):
        if not isinstance(segment, FreeMove):
            ways.append(np.empty((0, arm.n)))
            continue
        if known < i:
            before, _ = _expanded(arm, segments[:i], ways, rounded=False)
            if isinstance(before[-1], Move):  # the way round begins at its end, so nothing is rounded there
                before[-1] = segments[i - 1] = replace(before[-1], blend=0.0)
            at = plan(before).waypoints[-1]
        try:
            goal = _goal(scene, arm, segment, at)
            require_waypoints(goal[None], limits, arm.joint_names, arm.units, place(i, segment))
            way = free_path(scene, at, goal, limits, max_time)
        except PathError as error:
            raise PathError(f"{place(i, segment)}: {error}") from error
        ways.append(way)
        at, known = way[-1], i + 1
    return ways


def _goal(scene: Scene, arm: Arm, segment: FreeMove, at: Array) -> Array:
    """The configuration (n,) at the end of a free move: the free one nearest to `at`."""
    goal = segment.to
    if not isinstance(goal, KINDS):
        return arm.theta_from(goal)
    found = solve_ik(
        arm, goal, at, scene=scene, position_tol=segment.position_tol or 1e-6,
        orientation_tol=segment.orientation_tol or 1e-6,
    )  # fmt: skip
    try:
        return found.require()
    except NotConvergedError as error:
        raise PathError(str(error)) from error


def _expanded(
    arm: Arm, segments: Sequence[Segment], ways: Sequence[Array], rounded: bool
) -> tuple[list[Segment], list[int]]:
    """The segments with joint moves in place of free moves, and each one's original segment."""
    expanded: list[Segment] = []
    numbers: list[int] = []
    for i, (segment, way) in enumerate(zip(segments, ways, strict=True)):
        if not isinstance(segment, FreeMove):
            expanded.append(segment)
            numbers.append(i)
            continue
        tool = arm.fk(way)[:, :3, 3]
        steps = np.linalg.norm(np.diff(tool, axis=0), axis=1)
        for k, theta in enumerate(way[1:], 1):
            last = k == len(way) - 1
            radius = 0.0 if last else min(ROUNDED * float(steps[k - 1 : k + 1].min()), LARGEST * arm.reach)
            corner = segment.blend if last else rounded * radius
            move = FreeMove(
                theta, blend=corner, velocity_scaling=segment.velocity_scaling, linear_speed=segment.linear_speed,
                angular_speed=segment.angular_speed, label=segment.label if last else "",
            )  # fmt: skip
            expanded.append(move)
            numbers.append(i)
    return expanded, numbers
