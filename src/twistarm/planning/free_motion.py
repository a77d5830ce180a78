"""Motions in a scene: free moves avoid obstacles, and the whole motion is proven free."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arm.arm import Arm
from ..collision import Scene, require_scene
from ..ik import solve_ik
from ..ik.solution import in_one_line
from ..ik.targets import KINDS
from ..support.checks import Array
from ..support.errors import NotConvergedError
from ..support.messages import Text, joined
from .cartesian.refusal import PathError
from .free_path import free_path
from .goals import Goals
from .segments import FreeMove, Move, Segment, place
from .trajectory import Trajectory
from .unwrapping import UNWRAP, unwrapped

ROUNDED, LARGEST = 0.45, 0.1
"""Radius of a rounded corner: greatest share of the way to the nearer neighbour, and of the arm's reach."""

Planner = Callable[[Sequence[Segment], Sequence[int]], Trajectory]
"""Plans segments from the start of the motion. The numbers tell which segments of the caller they belong to."""


def planned_in(
    scene: Scene, arm: Arm, segments: list[Segment], origin: Array, goals: Goals, max_time: float, plan: Planner
) -> Trajectory:
    """The motion of `plan` through `segments`, every `FreeMove` replaced by joint moves round obstacles.

    Corners are rounded if the motion stays free then. A start in collision may be left: its pairs may come no nearer.
    Raises PathError, with time, segment and pair, for a collision.
    """
    around = scene.leaving(origin)
    ways = _ways(around, arm, segments, origin, goals, max_time, plan)
    for rounded in (True, False):
        motion = _through(arm, segments, ways, plan, rounded=rounded)
        hit = first_collision(around, motion)
        if hit is None:
            break
    if hit is not None:
        raise PathError(
            f"{hit}; let a free move go round, or choose another goal", theta=hit.theta, reason="collision",
            segment=hit.leg, place=place(hit.leg, segments[hit.leg]),
        )  # fmt: skip
    if around is not scene and (contacts := scene.contacts(motion.waypoints[-1])):
        raise PathError(f"the motion ends in collision, as it began: {contacts[0]}", reason="collision")
    return motion


def _through(
    arm: Arm, segments: Sequence[Segment], ways: Sequence[Array], plan: Planner, *, rounded: bool
) -> Trajectory:
    """The motion along the ways. Its waypoints are the ends of the segments, without the corners of free moves."""
    expanded, numbers = _expanded(arm, segments, ways, rounded)
    motion = plan(expanded, numbers)
    ends = [0, *(k for k in range(1, len(numbers) + 1) if k == len(numbers) or numbers[k] != numbers[k - 1])]
    return replace(motion, waypoints=motion.waypoints[ends], times=motion.times[ends])


def _ways(
    scene: Scene, arm: Arm, segments: list[Segment], origin: Array, goals: Goals, max_time: float, plan: Planner
) -> list[Array]:
    """Per segment the waypoints (k, n) of its free path with both ends; (0, n) for other moves."""
    ways: list[Array] = []
    at, known = origin, 0
    for i, segment in enumerate(segments):
        if not isinstance(segment, FreeMove):
            ways.append(np.empty((0, arm.n)))
            continue
        if known < i:
            before = segments[i - 1]
            if isinstance(before, Move):  # the way round begins at its end, so nothing is rounded there
                segments[i - 1] = replace(before, blend=0.0)
            at = _through(arm, segments[:i], ways, plan, rounded=False).waypoints[-1]
        goal = _goal(scene, segment, at, goals, place(i, segment))
        try:
            way = free_path(scene, at, goal, goals.limits, max_time)
        except PathError as error:
            nearer = unwrapped(goals.arm, goal, at, "", asked=True)[0]
            hint = Text("; {unwrap} takes a nearer turn of the goal", unwrap=UNWRAP)
            what = error.message if (nearer == goal).all() else joined("", [error.message, hint])
            raise PathError(what, theta=at, reason="collision", segment=i, place=place(i, segment)) from error
        ways.append(way)
        at, known = way[-1], i + 1
    return ways


def _goal(scene: Scene, segment: FreeMove, at: Array, goals: Goals, where: str) -> Array:
    """The configuration (n,) at which a free move ends: that of its target nearest to `at` that is free."""
    if not isinstance(segment.to, KINDS):
        return unwrapped(goals.arm, goals.configuration(segment, at, where), at, where, goals.unwrap)[0]
    found = solve_ik(goals.arm, segment.to, at, scene=scene, **goals.tolerances(segment).keywords)
    if not found.converged:
        raise NotConvergedError(joined(": ", [where, in_one_line(found)]), found)
    return found.theta


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


@dataclass(frozen=True, eq=False)
class Hit:
    """A collision of a motion: on the way to waypoint `leg` + 1, at `theta` (n,), in words."""

    leg: int
    theta: Array
    words: str

    def __str__(self) -> str:
        return self.words


def first_collision(scene: Scene, motion: Trajectory) -> Hit | None:
    """The first collision of a motion, or None."""
    found = scene.first_collision(motion.breakpoints, motion.coefficients)
    if found is None:
        return None
    leg = int(np.clip(np.searchsorted(motion.times, found.time, side="right") - 1, 0, max(len(motion.times) - 2, 0)))
    pairs = ", ".join(map(str, found.contacts[:2])) or "a near miss"
    return Hit(leg, found.theta, f"it collides {found.time:.2f} s after the start: {pairs}")


def require_free(scene: Scene, arm: Arm, motion: Trajectory) -> None:
    """Raise PathError if a motion through waypoints collides; a start in collision may be left."""
    hit = first_collision(require_scene(scene, arm).leaving(motion.waypoints[0]), motion)
    if hit is not None:
        place = f"the way from waypoint {hit.leg} to {hit.leg + 1} (counted from 0)"
        raise PathError(
            f"{hit}; add waypoints round it", theta=hit.theta, reason="collision", segment=hit.leg, place=place
        )
