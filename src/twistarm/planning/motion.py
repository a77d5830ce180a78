"""plan: a motion of joint moves, lines, screws, arcs and dwells, timed to the limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..arm.arm import Arm, require_arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, Progress, Row, as_flag, as_number, as_positive, require_callback, require_choice
from ..support.errors import InputError, NotConvergedError
from ..support.messages import Argument, Quantity, Text
from .goals import Goals
from .joint_space import Motion, best_stops, completed, joined, straight_s_curve
from .piecewise import JointPath
from .refusal import PathError
from .route import PathPart, Router
from .s_curve import s_curve
from .segments import CLEARANCE, Dwell, FreeMove, JointMove, Segment, as_segments, place
from .stretches import Corner, path_along, runs
from .time_law import PathBounds, TimeLaw, quintic
from .time_optimal import time_optimal
from .torque_limits import HELD, Load, torque_limits
from .trajectory import Trajectory
from .within import inside_from

if TYPE_CHECKING:
    from ..collision import Distance, Scene
    from .keep import Constraint

MotionKind = Literal["s_curve", "time_optimal", "quintic"]
LAWS: dict[str, Callable[[JointPath, PathBounds], TimeLaw]] = {
    "s_curve": s_curve,
    "time_optimal": time_optimal,
    "quintic": quintic,
}
WAYS_SHARE = 0.5  # The share of the work when all ways are found.


def plan(
    arm: Arm,
    segments: Sequence[Segment] | Segment,
    *,
    start: Row | Mapping[str, float] | str | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    kind: MotionKind = "s_curve",
    linear_speed: float | None = None,
    angular_speed: float | None = None,
    position_tol: float | None = None,
    orientation_tol: float | None = None,
    unwrap: bool = False,
    torques: bool = False,
    payload: Load = 0.0,
    scene: Scene | None = None,
    max_time: float = 5.0,
    clearance: float = CLEARANCE,
    progress: Progress | None = None,
) -> Trajectory:
    """Plan a rest-to-rest motion through `segments`, inside the limits of joints and motors.

    Joint moves go straight in joint space. Lines, screws and arcs keep the tool within 0.1 mm and 0.05° of the ideal.
    Wider tolerances replace these. If curves follow a joint move to a target, it ends in the branch from which all can
    be followed with the least joint motion. Between two moves the arm stops, or rounds the corner inside a ball of
    radius `blend`. The corner shrinks until it fits. The arm also stops if that takes less time.

    - `s_curve`, `time_optimal`: as for `plan_joint`. A joint move that stops at both ends is the shortest possible.
    - `quintic`: s(t) = 10 u³ − 15 u⁴ + 6 u⁵ along the whole stretch from stop to stop.

    Sources: Biagiotti & Melchiorri 2008, §3.4 (double-S); Pham & Pham 2018 (time-optimal); Lynch & Park 2017, §9.2.

    Args:
        arm: The arm.
        segments: `JointMove`, `FreeMove`, `LineMove`, `ScrewMove`, `ArcMove` and `Dwell`, one or more.
        start: Configuration (n,) [rad, m], {joint: value} or the name of one; by default `arm.ready`. A measured one
            may be up to 0.2 rad or 20 mm beyond the limits. The motion then first returns inside, with a note.
        limits: By default those of the arm. Or a `JointLimits`, or changes such as {"acceleration": 3.0}.
        kind: "s_curve", "time_optimal" or "quintic".
        linear_speed: Greatest speed of the tool's origin [m/s] where a segment gives none.
        angular_speed: Greatest angular speed of the tool [rad/s] where a segment gives none.
        position_tol: Tolerance of a target [m] where a segment gives none; 1e-5 by default.
        orientation_tol: Tolerance of its rotation [rad]; 5e-5 by default.
        unwrap: Whether joints that can turn by 2π go to configurations by the shorter way, from 3.1 to −3.1 by 0.08
            rad. To targets they always do.
        torques: Whether the efforts of joints and motors limit the motion too, by the masses of the arm.
        payload: What the tool carries then, a mass [kg] or (mass, place (3,) in tool axes [m]).
        scene: A `Scene` of the arm, or None. The motion is then proven free without gaps, and a `FreeMove` goes round.
        max_time: Greatest wall time [s] for the path of one `FreeMove`. A busy computer searches less in it.
        clearance: How far [m] states of a `FreeMove` keep from everything; less beside ends that are nearer. A
            twentieth of it in the second half of `max_time`, for narrow gaps.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`. Its waypoints are the start and the end of every segment, its labels those of the segments.
            Its `notes` name usual limits for missing ones, shorter ways by whole turns, curves without motion, and
            where free moves come nearer than a `clearance` above the default.

    Raises:
        PathError: A curve cannot be followed. The message says where it stops, why, and what would help. Or the motion
            collides, or no free path was found.
        LimitError: A goal lies outside the position limits. Or the efforts do not hold arm and payload at rest.
        NotConvergedError: The target of a joint move cannot be met; the message says why.
        InputError: An argument does not fit the arm.
        UnknownNameError: No such configuration or joint.
    """
    require_choice(kind, tuple(LAWS), "kind")
    require_callback(progress, "progress", "(fraction)")
    moves = as_segments(
        segments, linear_speed=linear_speed, angular_speed=angular_speed, position_tol=position_tol,
        orientation_tol=orientation_tol,
    )  # fmt: skip
    bounds, notes = completed(require_arm(arm), limits)
    ranged = _with_range(arm, bounds)
    origin = ranged.ready if start is None else ranged.theta_from(start, name="start")
    if origin.shape != (arm.n,):
        raise InputError(f"start must be one configuration ({arm.n},); got {origin.shape}")
    inside, back = inside_from(origin, bounds, arm.joint_names, arm.units)
    how = {"max_time": as_positive(max_time, "max_time"), "clearance": as_number(clearance, "clearance", 0.0)}
    rates = PathBounds(bounds, arm.actuators, torques=torque_limits(arm, bounds.effort, torques, payload))
    around, ways = _obstacles(arm, moves, origin, scene, {"limits": bounds, **how})
    goals, report = Goals(ranged, bounds, as_flag(unwrap, "unwrap")), _onward(progress)
    router = Router(ranged, moves, goals, lambda done: report(WAYS_SHARE * done / len(moves)), around, *ways)
    try:
        parts, route_notes = _route(router, inside)
        if back:
            parts.insert(0, PathPart(0, JointMove(inside), inside, JointPath.straight(origin, inside), last=False))
        notes = (*notes, *back, *route_notes)
        timed = partial(_in_time, ranged, origin if back else inside, rates, kind, notes)
        motion = timed(parts) if around is None else _free(around, timed, parts, router, advise=around is scene)
    except PathError as error:
        if scene is None or around is scene or error.reason != "collision":
            raise
        raise _from_collision(error, f"the start collides: {scene.contacts(origin)[0]}") from error
    if scene is not None and around is not scene and (contacts := scene.contacts(motion.waypoints[-1])):
        raise PathError(f"the motion ends in collision, as it began: {contacts[0]}", reason="collision")
    report(1.0)
    # Measured only for who asks for more than the default: to measure may take as long as to plan.
    if around is not None and clearance > CLEARANCE and any(isinstance(move, FreeMove) for move in moves):
        motion = replace(motion, notes=(*motion.notes, *came_nearer(around.clearance(motion), clearance)))
    return motion


def _with_range(arm: Arm, limits: JointLimits) -> Arm:
    """The arm with these limits if its positions change. Inverse kinematics looks at the arm's own limits."""
    same = all(np.array_equal(getattr(limits, side), getattr(arm.limits, side)) for side in ("lower", "upper"))
    return arm if same else replace(arm, limits=limits)


def _from_collision(error: PathError, start: str) -> PathError:
    """The same error, with its attributes, which says too that the start collides, and what to do about that."""
    make, (why, *known) = error.__reduce__()
    why = why if why == start else Text("{why}; {start}", why=why, start=start)
    what = "{why}; move the arm away first, or take out obstacles that are not there, as points of the arm itself"
    return make(Text(what, why=why), *known)


def came_nearer(nearest: Distance, clearance: float) -> list[str]:
    """The note of a motion that comes nearer than its `clearance` [m], which only states of its search keep."""
    what = "comes nearer than {clearance}: {nearest}; a scene's margin is kept everywhere"
    note = Text(what, clearance=Argument("clearance", Quantity(clearance, "m")), nearest=nearest)
    return [note] if nearest.metres < clearance else []


def _onward(progress: Progress | None) -> Callable[[float], None]:
    """Report each fraction that is more than any before: a route that is tried again begins anew."""
    reported = [0.0]

    def report(done: float) -> None:
        if progress is not None and done > reported[0]:
            reported[0] = done
            progress(done)

    return report


def _route(router: Router, origin: Array) -> tuple[list[PathPart], list[str]]:
    """Return the parts from `origin` (n,) on, and notes. What cannot be followed exactly is within the tolerances."""
    try:
        return router.parts(origin), router.notes
    except PathError as error:
        if error.reason == "collision":
            raise
        loose = replace(router, goals=replace(router.goals, exactly=False), notes=[])
        with suppress(PathError, NotConvergedError):
            return loose.parts(origin), loose.notes
        raise error from None


def _obstacles(
    arm: Arm, moves: list[Segment], origin: Array, scene: Scene | None, how: Mapping[str, Any]
) -> tuple[Scene | None, tuple[Callable[..., Any] | None, Callable[..., Any] | None]]:
    """Return the scene and the searches for paths in it: a free one, one that keeps something.

    A start in collision may be left: its pairs come no nearer.
    """
    if scene is None:
        if any(isinstance(move, FreeMove) for move in moves):
            what = "a FreeMove needs a scene, which may be the arm alone: give {scene}"
            raise InputError(Text(what, scene=Argument("scene")))
        return None, (None, None)
    from ..collision import require_scene  # only here: it loads the collision library
    from .free_moves import free_path
    from .keeping_path import keeping_path

    around = require_scene(scene, arm).leaving(origin)
    return around, (partial(free_path, around, **how), partial(keeping_path, around, **how))


def _free(
    around: Scene, timed: Callable[[list[PathPart]], Trajectory], parts: list[PathPart], router: Router, *, advise: bool
) -> Trajectory:
    """The motion along the parts, proven free. If it collides, the ways of free moves get sharp corners.

    It stops at an end of a free move if a rounded corner would not keep enough. `advise`: a free move may go round.
    """
    from .free_moves import first_collision

    motion, stops = timed(parts), list[str]()
    for before in (0, 1):  # the corner at the end of such a move, then that at its beginning
        left = {k - before for k, constraint in router.constraints.items() if not _keeps(constraint, motion, k)}
        sharp = [part for part in parts if part.last and part.blend and part.index in left]
        if sharp:
            parts = [replace(part, blend=0.0) if part in sharp else part for part in parts]
            motion, stops = timed(parts), [*stops, *(place(part.index, part.segment) for part in sharp)]
    hit = first_collision(around, motion)
    if hit is not None and any(isinstance(part.segment, FreeMove) for part in parts):
        motion = timed([part if part.last else replace(part, blend=0.0) for part in parts])
        hit = first_collision(around, motion)
    if hit is not None:
        remedy = "; let a free move go round, or choose another goal" if advise else ""
        where = place(hit.leg, router.segments[hit.leg])
        raise PathError(f"{hit}{remedy}", hit.share, hit.theta, "collision", segment=hit.leg, place=where)
    if stops:
        note = f"stops at {', '.join(stops)}: a rounded corner would not keep what a free move keeps"
        motion = replace(motion, notes=(*motion.notes, note))
    return motion


def _keeps(constraint: Constraint, motion: Trajectory, k: int) -> bool:
    """Whether a motion is proven to keep all in its segment k."""
    begin, end = motion.times[k : k + 2]
    middle = 0.5 * (motion.breakpoints[:-1] + motion.breakpoints[1:])
    piece = (middle > begin) & (middle < end)
    return not constraint.unproven(motion.coefficients[:, piece], np.diff(motion.breakpoints)[piece]).any()


def _in_time(
    arm: Arm, origin: Array, bounds: PathBounds, kind: str, notes: tuple[str, ...], parts: list[PathPart]
) -> Trajectory:
    """Return the motion along the parts, from stop to stop as fast as the limits allow."""
    motions, stopped, limits = list[Motion](), list[PathPart](), bounds.limits
    if bounds.torques is not None:
        for part in parts:
            path = part.path
            at = part.end[None] if path is None else path(np.linspace(0.0, path.length, HELD))
            bounds.torques.require_held(at, place(part.index, part.segment))
    for run, corners in runs(arm, parts, limits):
        timed = cache(partial(_timed, arm, run, corners, bounds, kind))
        stops = best_stops(timed, np.array([timed(i, i + 1).duration for i in range(len(run))]))
        stretches = list(pairwise([0, *stops, len(run)]))
        motions += [timed(i, j) for i, j in stretches]
        stopped += [run[j - 1] for _, j in stretches]
    ends, breakpoints, coefficients = joined(motions)
    whole = [k for k, part in enumerate(parts) if part.last]
    times = np.append(0.0, ends[whole])
    # A dwell's label is due when it begins, the label of a move when it ends.
    due = [(times[i - isinstance(parts[k].segment, Dwell)], parts[k].segment.label) for i, k in enumerate(whole, 1)]
    labels = tuple((float(time), label) for time, label in due if label)
    waypoints = np.array([origin, *(parts[k].end for k in whole)])
    notes = (*notes, *_stops_noted(parts, stopped))
    motion = Trajectory(
        arm.joint_names, arm.units, waypoints, times, breakpoints, coefficients, arm.actuators, labels, notes, limits
    )
    rounded = np.array([False, *(parts[k].blend > 0.0 for k in whole)])
    return replace(motion, waypoints=np.where(rounded[:, None], motion(times), motion.waypoints))


def _timed(
    arm: Arm, run: list[PathPart], corners: list[Corner], bounds: PathBounds, kind: str, i: int, j: int
) -> Motion:
    """Return the motion along the parts i … j − 1 of a run, all corners between them rounded."""
    segment, theta, own = run[i].segment, run[i].end, run[i].path
    if own is None:
        stay = segment.seconds if isinstance(segment, Dwell) else 0.0
        return Motion(np.array([stay]), np.array([0.0, stay]), theta[None, None])
    if kind == "s_curve" and j == i + 1 and not run[i].move.slowed and own.coefficients.shape[:2] == (2, 1):
        # A double-S for each joint would leave the straight line along which the free move was proven.
        return straight_s_curve(own.start, own.end, bounds, straight=isinstance(segment, FreeMove))
    path, ends, ceiling = path_along(arm, run[i:j], corners[i : j - 1], bounds.limits)
    law = LAWS[kind](path, bounds.capped(ceiling))
    return Motion(law.passes(ends), *law.along(path))


def _stops_noted(parts: list[PathPart], stopped: list[PathPart]) -> list[str]:
    """Return a note on the corners that were to be rounded and at which the arm stops."""
    corners = [part for part, following in pairwise(parts) if part.last and part.path and following.path and part.blend]
    stops = [part for part in corners if part in stopped]
    every = len(stops) == len(corners) > 1
    where = "every corner" if every else ", ".join(place(part.index, part.segment) for part in stops)
    blends = {part.blend for part in stops}
    corner = f"a corner within {blends.pop():g} m" if len(blends) == 1 else "a corner"
    return [f"stops at {where}: {corner} would save no time"] if stops else []
