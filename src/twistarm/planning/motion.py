"""plan: a motion of joint moves, lines, screws, arcs and dwells, timed to the limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..arm.arm import Arm, require_arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, Row, as_flag, as_positive, require_callback, require_choice
from ..support.errors import InputError, NotConvergedError, shown
from ..support.messages import Argument, Text
from .cartesian.refusal import PathError
from .goals import Goals
from .joint_path import JointPath
from .joint_space import completed
from .piecewise import side_by_side
from .route import Leg, Router
from .segments import SEGMENTS, Dwell, FreeMove, Move, Segment, place
from .spans import Progress
from .stops import best_stops
from .stretches import Corner, path_along, runs
from .time_laws.bounds import PathBounds
from .time_laws.double_s import double_s
from .time_laws.law import TimeLaw, quintic
from .time_laws.s_curve import s_curve
from .time_laws.time_optimal import time_optimal
from .trajectory import Trajectory
from .within import require_waypoints

if TYPE_CHECKING:
    from ..collision import Scene

MotionKind = Literal["s_curve", "time_optimal", "quintic"]
LAWS: dict[str, Callable[[JointPath, PathBounds], TimeLaw]] = {
    "s_curve": s_curve,
    "time_optimal": time_optimal,
    "quintic": quintic,
}


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
    scene: Scene | None = None,
    max_time: float = 5.0,
    progress: Progress | None = None,
) -> Trajectory:
    """Plan a rest-to-rest motion through `segments`, inside the limits of joints and motors.

    Joint moves go straight in joint space. Lines, screws and arcs keep the tool within 0.1 mm and 0.05° of the ideal.
    Wider tolerances replace these. If curves follow a joint move to a target, `plan` chooses the branch. It follows all
    curves with the least joint motion. Between two moves the arm stops, or rounds the corner inside a ball of radius
    `blend`. The corner shrinks until it fits. The arm also stops if that takes less time.

    - `s_curve`: acceleration is continuous and jerk within its limits. A joint without a jerk limit takes 0.1 s to its
      acceleration limit. A joint move that stops at both ends is the shortest possible.
    - `time_optimal`: the shortest time along the path; acceleration jumps.
    - `quintic`: s(t) = 10 u³ − 15 u⁴ + 6 u⁵ along the whole stretch from stop to stop.

    Sources: Biagiotti & Melchiorri 2008, §3.4 (double-S); Pham & Pham 2018 (time-optimal); Lynch & Park 2017, §9.2.

    Args:
        arm: The arm.
        segments: `JointMove`, `FreeMove`, `LineMove`, `ScrewMove`, `ArcMove` and `Dwell`, one or more.
        start: Configuration (n,) [rad, m], {joint: value} or the name of one; by default `arm.ready`.
        limits: By default those of the arm. Or a `JointLimits`, or changes such as {"acceleration": 3.0}.
        kind: "s_curve", "time_optimal" or "quintic".
        linear_speed: Greatest speed of the tool's origin [m/s] where a segment gives none.
        angular_speed: Greatest angular speed of the tool [rad/s] where a segment gives none.
        position_tol: Tolerance of a target [m] where a segment gives none; 1e-5 by default.
        orientation_tol: Tolerance of its rotation [rad]; 5e-5 by default.
        unwrap: Whether joints that can turn by 2π go to configurations by the shorter way, from 3.1 to −3.1 by 0.08
            rad. To targets they always do.
        scene: A `Scene` of the arm, or None. The motion is then proven free without gaps, and a `FreeMove` goes round.
        max_time: Greatest time [s] for the way of one `FreeMove`.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`. Its waypoints are the start and the end of every segment, its labels those of the
            segments. Its `notes` name usual limits used for missing ones, shorter ways by whole turns, and curves that
            do not move.

    Raises:
        PathError: A curve cannot be followed. The message says where it stops, why, and what would help. Or the motion
            collides, or no way round was found.
        LimitError: A goal lies outside the position limits.
        NotConvergedError: The target of a joint move cannot be met; the message says why.
        InputError: An argument does not fit the arm.
        UnknownNameError: No such configuration or joint.
    """
    require_choice(kind, tuple(LAWS), "kind")
    progress = _rising(require_callback(progress, "progress", "(fraction)"))
    moves = as_segments(segments, linear_speed, angular_speed, position_tol, orientation_tol)
    bounds, notes = completed(require_arm(arm), limits)
    planned = _with_ranges(arm, bounds)
    origin = planned.ready if start is None else planned.theta_from(start, name="start")
    if origin.shape != (arm.n,):
        raise InputError(f"start must be one configuration ({arm.n},); got {origin.shape}")
    require_waypoints(origin[None], bounds, arm.joint_names, arm.units, "start")

    turning = as_flag(unwrap, "unwrap")

    def planned_through(segments: Sequence[Segment], numbers: Sequence[int] | None = None) -> Trajectory:
        legs, said = _legs(planned, list(segments), origin, bounds, turning, progress, numbers)
        timed = [each for run in runs(planned, legs, bounds) for each in _fastest(planned, *run, bounds, kind)]
        return _assembled(arm, origin, timed, (*notes, *said, *_unrounded(timed)), bounds)

    if scene is not None:
        from ..collision import require_scene
        from .free_motion import planned_in

        require_scene(scene, arm)
        goals = Goals(planned, bounds, turning)
        motion = planned_in(scene, planned, moves, origin, goals, as_positive(max_time, "max_time"), planned_through)
    elif any(isinstance(move, FreeMove) for move in moves):
        what = "a FreeMove needs a scene, which may be the arm alone: give {scene}"
        raise InputError(Text(what, scene=Argument("scene")))
    else:
        motion = planned_through(moves)
    if progress is not None:
        progress(1.0)
    return motion


def _rising(progress: Progress | None) -> Progress | None:
    """Return the callback without fractions that fall: motions with free moves are planned several times."""
    most = 0.0

    def report(fraction: float) -> None:
        nonlocal most
        if progress is not None and fraction > most:
            most = fraction
            progress(fraction)

    return report if progress is not None else None


def _legs(
    arm: Arm,
    moves: list[Segment],
    origin: Array,
    limits: JointLimits,
    unwrap: bool,
    progress: Progress | None,
    numbers: Sequence[int] | None,
) -> tuple[list[Leg], list[str]]:
    """Return the legs from `origin` (n,) on, and notes. What cannot be followed exactly is within the tolerances."""

    def report(done: int) -> None:
        if progress is not None:
            progress(0.9 * done / len(moves))

    router = Router(arm, moves, limits, report, unwrap, numbers)
    try:
        return router.legs(origin), router.notes
    except PathError as error:
        router = Router(arm, moves, limits, report, unwrap, numbers, exactly=False)
        with suppress(PathError, NotConvergedError):
            return router.legs(origin), router.notes
        raise error from None


def _with_ranges(arm: Arm, limits: JointLimits) -> Arm:
    """Return the arm with these position limits, because inverse kinematics looks at the arm's own."""
    same = all(np.array_equal(getattr(limits, side), getattr(arm.limits, side)) for side in ("lower", "upper"))
    return arm if same else replace(arm, limits=limits)


def as_segments(
    segments: Any,
    linear_speed: float | None = None,
    angular_speed: float | None = None,
    position_tol: float | None = None,
    orientation_tol: float | None = None,
) -> list[Segment]:
    """Return the segments. Moves without a speed of the tool, or a tolerance, take the ones given here."""
    whole: dict[str, Any] = {
        "linear_speed": None if linear_speed is None else as_positive(linear_speed, "linear_speed"),
        "angular_speed": None if angular_speed is None else as_positive(angular_speed, "angular_speed"),
        "position_tol": position_tol,
        "orientation_tol": orientation_tol,
    }
    given = [segments] if isinstance(segments, SEGMENTS) else list(segments) if np.iterable(segments) else None
    if not given or isinstance(segments, str):
        raise InputError(f"segments must be one or more of JointMove, LineMove, …, Dwell; got {shown(segments)}")
    for i, segment in enumerate(given):
        if not isinstance(segment, SEGMENTS):
            raise InputError(
                f"segment {i + 1} must be a JointMove, FreeMove, LineMove, ScrewMove, ArcMove or Dwell; "
                f"got {shown(segment)}"
            )
        if isinstance(segment, Move):
            taken = {name: value for name, value in whole.items() if getattr(segment, name) is None}
            given[i] = replace(segment, **taken)
            if segment.blend and (i + 1 == len(given) or isinstance(given[i + 1], Dwell)):
                raise InputError(f"{place(i, segment)} cannot blend: the arm stops at its end; leave blend out")
    return given


@dataclass(frozen=True, eq=False)
class Timed:
    """Timed legs from stop to stop: breakpoints (m + 1,) [s], coefficients, each leg's end [s]."""

    legs: list[Leg]
    breakpoints: Array
    coefficients: Array
    ends: Array

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.breakpoints[-1])


def _unrounded(timed: list[Timed]) -> list[str]:
    """Return a note on the corners that were to be rounded and at which the arm stops."""
    asked = [
        leg for leg, on in pairwise(leg for each in timed for leg in each.legs)
        if leg.index != on.index and leg.path and on.path and leg.move.blend
    ]  # fmt: skip
    stops = [leg for each in timed for leg in asked if leg is each.legs[-1]]
    where = (
        "every corner" if len(stops) == len(asked) > 1 else ", ".join(place(leg.index, leg.segment) for leg in stops)
    )
    return [f"stops at {where}: no rounding there is faster"] if stops else []


def _fastest(arm: Arm, run: list[Leg], corners: list[Corner], limits: JointLimits, kind: str) -> list[Timed]:
    """Return the legs of a run in time. Corners are rounded unless stopping there is sooner done."""

    @cache
    def timed(i: int, j: int) -> Timed:
        return _timed(arm, run[i:j], corners[i : j - 1], limits, kind)

    stops: tuple[int, ...] = ()
    if len(run) > 1:
        alone = np.array([timed(i, i + 1).duration for i in range(len(run))])
        stops = best_stops(lambda i, j: timed(i, j).duration, alone, timed(0, len(run)).ends)
    return [timed(i, j) for i, j in pairwise([0, *stops, len(run)])]


def _timed(arm: Arm, legs: list[Leg], corners: list[Corner], limits: JointLimits, kind: str) -> Timed:
    """Return the legs in time, all corners between them rounded."""
    segment, theta = legs[0].segment, legs[0].end
    if legs[0].path is None:
        stay = segment.seconds if isinstance(segment, Dwell) else 0.0
        return Timed(legs, np.array([0.0, stay]), theta[None, None], np.array([stay]))
    path, ends, ceiling = path_along(arm, legs, corners, limits)
    bounds = PathBounds(limits, arm.actuators, ceiling)
    # A double-S for each joint would leave the straight line along which the free move was proven.
    straight = isinstance(segment, FreeMove)
    if kind == "s_curve" and ceiling is None and not straight and path.coefficients.shape[:2] == (2, 1):
        breakpoints, coefficients = double_s(path.start, path.end, bounds)
        return Timed(legs, breakpoints, coefficients, breakpoints[-1:])
    law = LAWS[kind](path, bounds)
    return Timed(legs, *law.along(path), law.passes(ends))


def _assembled(arm: Arm, origin: Array, timed: list[Timed], notes: tuple[str, ...], limits: JointLimits) -> Trajectory:
    """Join everything in time to one trajectory."""
    legs = [leg for each in timed for leg in each.legs]
    starts = np.cumsum([0.0, *(each.duration for each in timed)])
    times = np.concatenate([[0.0], *(start + each.ends for start, each in zip(starts, timed, strict=False))])
    moving = [each for each in timed if each.duration]
    steps = np.concatenate([np.diff(each.breakpoints) for each in moving] or [np.zeros(1)])
    breakpoints = np.concatenate([[0.0], np.cumsum(steps)])
    times = np.minimum(times, breakpoints[-1])
    # A dwell's label is due when it begins, the label of a move when it ends.
    due = [(times[i - isinstance(leg.segment, Dwell)], leg.segment.label) for i, leg in enumerate(legs, 1)]
    labels = tuple((float(time), label) for time, label in due if label)
    waypoints = np.array([origin, *(leg.end for leg in legs)])
    pieces = side_by_side([each.coefficients for each in moving] or [origin[None, None]])
    motion = Trajectory(
        arm.joint_names, arm.units, waypoints, times, breakpoints, pieces, arm.actuators, labels, notes, limits
    )
    rounded = np.array([False, *(isinstance(leg.segment, Move) and leg.segment.blend > 0.0 for leg in legs)])
    return replace(motion, waypoints=np.where(rounded[:, None], motion(times), motion.waypoints))
