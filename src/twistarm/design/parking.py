"""Which tasks of a panel an arm does, and why it fails at others. Where the rover parks best."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm, require_arm
from ..collision import Scene, require_scene
from ..ik import reachable, solve_ik
from ..ik.solution import in_one_line
from ..ik.targets import Approach
from ..planning import FreeMove, JointMove, PathError, Segment, Trajectory, plan
from ..planning.configurations import branches
from ..support.checks import Array, Matrix, Progress, as_frame, as_pose, reporting, require
from ..support.display import Brief
from ..support.errors import InputError
from ..support.messages import joined
from ..theory import screws
from ..theory.manipulability import scaled_jacobian
from .panel import Panel, PanelTask

# Configurations of a task that are measured, starts that are tried, and the margin [rad, m] that is enough.
SAMPLES, BRANCHES, ROOM = 101, 8, 0.1
# About how many poses each of the two grids has, and that by tasks, at most; and how many poses are checked.
POSES, TARGETS, CANDIDATES = 4000, 100_000, 3
YAW, FINEST = np.radians(15.0), 0.02  # The steps of a grid: in yaw, and at least in x and y [m].
# Codes for reasons of `PathError`. Those of the others are their words.
CODES = {"limit": "blocked_by_limits", "collision": "in_collision"}
# Words for the checkpoints of a task.
POINTS = "in front of it", "at its place", "half-way", "at its end", "away from it"


@dataclass(frozen=True, eq=False, repr=False)
class TaskResult(Brief):
    """Whether the arm does a task. `code` is "done", or why not, and `why` says it in a sentence.

    `code` is a name of `StopReason` in small letters, such as "out_of_reach", "singular" or "leap". Of a task that is
    done, `theta` (101, n) is the way from the configuration in front of the place and back to one. In these `margin`
    [rad, m] is the least distance of a joint from its limits, that of `joint`. `condition` is the greatest condition
    number of the Jacobian; `clearance` [m] the least distance from a collision, inf without a scene. NaN if not done.
    """

    task: PanelTask
    code: str
    why: str
    theta: Array
    margin: float = np.nan
    joint: str = ""
    condition: float = np.nan
    clearance: float = np.nan


@dataclass(frozen=True, eq=False, repr=False)
class PanelReport(Brief):
    """The tasks of a panel with the arm's base at `base` (4, 4), as `plan` does them one by one.

    `places` (p, 4) are the parking poses x, y [m], yaw [rad] that were looked at. The last column says how many tasks
    the arm may do from there, by a few points of each.
    """

    arm: Arm
    panel: Panel
    base: Array
    results: tuple[TaskResult, ...]
    scene: Scene | None
    places: Array

    @property
    def done(self) -> tuple[TaskResult, ...]:
        """The results of the tasks that the arm does."""
        return tuple(result for result in self.results if result.code == "done")

    @property
    def margin(self) -> float:
        """The least margin [rad, m] of a task that is done, NaN if none is."""
        return min((result.margin for result in self.done), default=np.nan)

    def motion(self, **options: Any) -> Trajectory:
        """Plan one motion through all tasks that are done, each labelled at the end of its screw.

        Between tasks the arm goes straight in joint space, or round everything if there is a scene.

        Args:
            **options: Those of `plan`: start, limits, kind and so on.

        Raises:
            InputError: No task is done.
            PathError: The way from one task to another collides.
        """
        if not self.done:
            raise InputError(
                "no task of the panel is done, so there is no motion; `why` of each result gives the reason"
            )
        to = JointMove if self.scene is None else FreeMove
        g, segments = screws.inverse(self.base) @ self.panel.pose, list[Segment]()
        for result in self.done:
            moves = result.task.seen_from(g).moves(self.arm.tool_axis, self.panel.clearance)
            segments += [to(result.theta[0]), *moves]
        return plan(self.arm, segments, **{"scene": self.scene, **self.panel.tolerances, **options})


def check_panel(
    arm: Arm, panel: Panel, base: Matrix | None = None, scene: Scene | None = None, progress: Progress | None = None
) -> PanelReport:
    """Try every task of a panel from one base pose, as `plan` does it.

    A task begins in front of its place, where the whole of it can be followed with the least joint motion. In a scene
    it begins where nothing collides on it, without gaps.

    Args:
        arm: The arm.
        panel: What `load_panel` read.
        base: The pose (4, 4) of the arm's base in the world. None for the origin.
        scene: A `Scene` of the arm, or None. Its obstacles ride on the rover. A panel with a size is a box in it.
        progress: Called with the fraction done, or None.

    Raises:
        InputError: An argument cannot be used.
    """
    inside, results = _scene(arm, panel, scene), []
    report_progress = reporting(progress)
    origin = as_frame(as_pose(np.eye(4) if base is None else base, "base"), "base")
    g = screws.inverse(origin) @ panel.pose
    if inside is not None and panel.size is not None:
        inside.find_allowed_pairs()
        inside = copy(inside)
        behind = np.eye(4)
        behind[2, 3] = -panel.gap - 0.5 * panel.size[2]
        inside.add_box("panel", panel.size, g @ behind)
    for k, task in enumerate(panel.tasks):
        results.append(_result(arm, panel, task, g, inside))
        report_progress((k + 1) / len(panel.tasks))
    return PanelReport(arm, panel, origin, tuple(results), inside, np.empty((0, 4)))


def best_parking(arm: Arm, panel: Panel, scene: Scene | None = None, progress: Progress | None = None) -> PanelReport:
    """The base pose in the panel's ranges from which the arm does most tasks, with the greatest least margin.

    `reachable` estimates a grid over x, y and yaw at five points of each task. Of this grid, and of a finer one around
    the best, three poses are checked as by `check_panel`. So the report is proven for its base. A better pose may have
    been missed. Whether the rover itself hits the panel is not tested: the ranges must exclude it.

    Args:
        arm: The arm.
        panel: What `load_panel` read.
        scene: As in `check_panel`.
        progress: Called with the fraction done, or None.

    Raises:
        InputError: An argument cannot be used.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    inside = _scene(arm, panel, scene)
    report_progress = reporting(progress)
    around = ranges = _within_reach(arm, panel)
    seen, best, most = np.empty((0, 4)), ranges.mean(axis=1), (-1, 0.0)
    for grid in range(2):
        places, step = _grid(panel, around)
        reached, margin = _estimated(arm, panel, places)
        counts = reached.sum(axis=0)
        seen = np.vstack([seen, np.column_stack([places, counts])])
        order = np.lexsort((margin, counts))[::-1]
        for k in range(CANDIDATES):
            if len(order) and counts[order[0]] >= max(most[0], 1):
                at = places[order[0]]
                tasks = tuple(panel.tasks[i] for i in np.flatnonzero(reached[:, order[0]]))
                found = check_panel(arm, replace(panel, tasks=tasks), panel.base_at(*at), inside)
                score = len(found.done), found.margin
                if score > most:
                    best, most = at, score
                order = order[(np.abs(places[order] - at) > 1.5 * step).any(axis=1)]  # no neighbours of it
            report_progress((grid + (k + 1) / CANDIDATES) / 3.0)
        around = np.clip(np.stack([best - step, best + step], axis=-1), ranges[:, :1], ranges[:, 1:])
    last = check_panel(arm, panel, panel.base_at(*best), inside, lambda part: report_progress((2.0 + part) / 3.0))
    return replace(last, places=seen)


def _scene(arm: Arm, panel: Panel, scene: Scene | None) -> Scene | None:
    """The scene, which a panel with a size needs."""
    require_arm(arm)
    require(panel, Panel, "panel", "which load_panel reads")
    if scene is not None:
        return require_scene(scene, arm)
    return None if panel.size is None else Scene(arm)


def _result(arm: Arm, panel: Panel, task: PanelTask, g: Array, scene: Scene | None) -> TaskResult:
    """The task of the panel at g (4, 4), from the first start with room in all joints, or with the most room."""
    places, directions = task.seen_from(g).checkpoints(panel.clearance)
    targets = [Approach(p, d).of(arm) for p, d in zip(places, directions, strict=True)]
    for point, target in zip(POINTS, targets, strict=True):
        at = solve_ik(arm, target, **dict[str, Any](panel.tolerances))
        if not at.converged:
            return TaskResult(task, at.stop.name.lower(), joined(": ", [point, in_one_line(at)]), np.empty((0, arm.n)))
    results = [_begun_at(targets[0], arm, panel, task, g, scene)]
    if results[0].margin >= ROOM or results[0].code not in {"done", "in_collision"}:  # plan has tried all starts
        return results[0]
    for start in _free_starts(arm, targets[0], scene):
        results.append(_begun_at(start, arm, panel, task, g, scene))
        if results[-1].margin >= ROOM:
            break
    return max((result for result in results if result.code == "done"), key=lambda it: it.margin, default=results[0])


def _free_starts(arm: Arm, target: Approach, scene: Scene | None) -> Array:
    """Some of the configurations that meet the target, free of collisions."""
    found = branches(arm, target, arm.ready)
    if scene is not None and len(found):
        found = found[~scene.collides(found)]
    return found[np.unique(np.linspace(0, len(found) - 1, BRANCHES).astype(int))] if len(found) else found


def _begun_at(
    start: Approach | Array, arm: Arm, panel: Panel, task: PanelTask, g: Array, scene: Scene | None
) -> TaskResult:
    """The task of the panel at g (4, 4), from a configuration in front of it, or from any that meets a target."""
    moves = task.seen_from(g).moves(arm.tool_axis, panel.clearance)
    try:
        motion = plan(arm, [JointMove(start), *moves], **dict[str, Any](panel.tolerances))
    except PathError as error:
        code = CODES.get(error.reason, error.reason.replace(" ", "_"))
        return TaskResult(task, code, f"on the way: {error.detail}", np.empty((0, arm.n)))
    first = int(np.searchsorted(motion.breakpoints, motion.times[1] - 1e-9))  # 1e-9 s: rounding
    hit = None if scene is None else scene.first_collision(motion.breakpoints[first:], motion.coefficients[:, first:])
    if hit is not None:
        why = f"it collides: {', '.join(map(str, hit.contacts[:2])) or 'a near miss'}"
        return TaskResult(task, "in_collision", why, np.empty((0, arm.n)))
    theta = motion(np.linspace(motion.times[1], motion.duration, SAMPLES))
    room = np.minimum(theta - arm.limits.lower, arm.limits.upper - theta).min(axis=0)
    sigma = np.linalg.svd(scaled_jacobian(arm.body_jacobian(theta), arm.prismatic, arm.reach), compute_uv=False)
    worst = float((sigma[:, 0] / np.maximum(sigma[:, -1], 1e-15)).max())  # finite also at a singularity
    joint = arm.joint_names[int(room.argmin())]
    clearance = np.inf if scene is None else min(scene.distance(x).metres for x in theta)
    return TaskResult(task, "done", "", theta, float(room.min()), joint, worst, clearance)


def _within_reach(arm: Arm, panel: Panel) -> Array:
    """The ranges (3, 2) of x, y and yaw, without places from which every task is too far away."""
    ranges = np.array([panel.x, panel.y, panel.yaw])
    far = 1.1 * np.linalg.norm(arm.fk(arm.random_theta(0, 1000))[:, :3, 3], axis=1).max()
    tasks = np.array([(panel.pose @ np.append(task.place, 1.0))[:2] for task in panel.tasks])
    near = np.clip(ranges[:2].T, tasks.min(axis=0) - far, tasks.max(axis=0) + far).T
    ranges[:2] = np.clip(near, ranges[:2, :1], ranges[:2, 1:])
    return ranges


def _grid(panel: Panel, ranges: Array) -> tuple[Array, Array]:
    """Poses (p, 3) in ranges (3, 2), and their steps (3,). Yaws in which the base faces the panel are among them."""
    spans = ranges[:, 1] - ranges[:, 0]
    yaws = _even(ranges[2], YAW)
    facing = np.arctan2(*-panel.pose[1::-1, 2]) + 2.0 * np.pi * np.arange(-2, 3)
    yaws = np.union1d(yaws, facing[(facing > ranges[2, 0]) & (facing < ranges[2, 1])])
    share = len(yaws) / min(POSES, TARGETS // len(panel.tasks))
    step = max(FINEST, float(np.sqrt(spans[0] * spans[1] * share)), spans[:2].max() * share)
    x, y = _even(ranges[0], step), _even(ranges[1], step)
    steps = [span / max(len(values) - 1, 1) for span, values in zip(spans, (x, y, yaws), strict=True)]
    return np.stack(np.meshgrid(x, y, yaws), axis=-1).reshape(-1, 3), np.array(steps)


def _even(ends: Array, step: float) -> Array:
    """Values from end to end (2,), with steps of at most `step`."""
    lower, upper = ends.tolist()
    return np.linspace(lower, upper, int(np.ceil((upper - lower) / step - 1e-9)) + 1)


def _estimated(arm: Arm, panel: Panel, places: Array) -> tuple[NDArray[np.bool_], Array]:
    """Which tasks have all points reached from places (p, 3): (tasks, p); and the least margin at these points (p,)."""
    g = screws.inverse(np.array([panel.base_at(*place) for place in places])) @ panel.pose
    points = [task.checkpoints(panel.clearance) for task in panel.tasks]
    p, d = (np.concatenate(of_tasks)[:, None] for of_tasks in zip(*points, strict=True))
    at, towards = (g[:, :3, :3] @ p[..., None])[..., 0] + g[:, :3, 3], (g[:, :3, :3] @ d[..., None])[..., 0]
    found = reachable(arm, at.reshape(-1, 3), direction=towards.reshape(-1, 3), **dict[str, Any](panel.tolerances))
    done: NDArray[np.bool_] = np.all(found.converged.reshape(len(panel.tasks), -1, len(places)), axis=1)
    room = np.minimum(found.theta - arm.limits.lower, arm.limits.upper - found.theta).min(axis=-1)
    least = room.reshape(len(panel.tasks), -1, len(places)).min(axis=1)
    return done, np.where(done, least, np.inf).min(axis=0)
