"""plan_joint: a motion through joint-space waypoints inside the joint limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.usual_limits import defaults_line, with_defaults
from ..ik.explain import in_one_line
from ..ik.solve import solve_ik
from ..ik.targets import KINDS as TARGETS
from ..ik.targets import TargetLike
from ..ik.task_space import Tolerances
from ..limits.joint_limits import JointLimits
from ..support.checks import (
    Array,
    RealArray,
    Row,
    as_flag,
    as_floats,
    as_positive,
    as_reals,
    require_callback,
    require_choice,
)
from ..support.errors import InputError, NotConvergedError, shown
from ..support.messages import joined
from . import spline, timing
from .pulling_in import pulled_in
from .spans import LONGEST, SHORTEST, Progress
from .time_laws import PathBounds
from .tolerances import decided, rounding_note
from .trajectory import Trajectory
from .unwrapping import unwrapped
from .waypoint_laws import Motion, double_s_rests, fastest_along_spline, fastest_rests
from .waypoint_smoothing import smoothed
from .within import require_rates, require_waypoints

if TYPE_CHECKING:
    from ..collision import Scene

Kind = Literal["cubic", "quintic", "trapezoid", "time_optimal", "s_curve"]
KINDS: tuple[Kind, ...] = ("cubic", "quintic", "trapezoid", "time_optimal", "s_curve")

BY_LAW = ("time_optimal", "s_curve")
"""Kinds that keep every limit by construction, at given times too."""

MERGE_TOL = 1e-6
"""Consecutive waypoints nearer than this [rad, m] in every joint are one. The tolerance of IK is no finer."""

STAY, STAY_SHARE, STAY_WIDTH = 15, 5.0, 1.9
"""A stay: its least number of waypoints, how many times the usual density, within how many tolerances."""

MOST_NAMED = 12
"""Greatest number of merged waypoints that a note names."""

LEAST_SEGMENT = 1e-7
"""Times closer than this share of the duration are a mistake. No spline can be computed for them."""

FITS = {
    ("cubic", False): spline.cubic,
    ("quintic", False): spline.quintic,
    ("cubic", True): spline.cubic_rests,
    ("quintic", True): spline.quintic_rests,
}
"""The spline of each kind: through the waypoints, or resting at each."""

DEGREES = {"cubic": 3, "quintic": 5}
"""Of the polynomials of each kind of spline."""

Waypoints = RealArray | Sequence[Row | Mapping[str, float] | str | TargetLike]
"""Configurations as arrays, mappings {joint: value} or names of states, and targets of the tool."""


def plan_joint(
    arm: Arm,
    waypoints: Waypoints,
    *,
    kind: Kind = "cubic",
    limits: JointLimits | Mapping[str, Any] | None = None,
    times: ArrayLike | None = None,
    stop_at_waypoints: bool = False,
    position_tol: float | None = None,
    orientation_tol: float | None = None,
    unwrap: bool = False,
    smooth: float | None = None,
    scene: Scene | None = None,
    progress: Progress | None = None,
) -> Trajectory:
    """Plan a motion through `waypoints`, from rest to rest, inside the joint limits.

    A waypoint is a configuration or a target: `Pose`, `Position`, `Approach`, `TolerancedPose` or a pose (4, 4).
    `solve_ik` finds the configuration of a target from the waypoint before it, or from `arm.ready`. Joints that can
    turn by 2π go to a target by the shorter way. To a configuration they go as written: from 0 to 2π by a full turn.
    `unwrap` chooses the shorter way there too: from 3.1 to −3.1 by 0.08 rad, to 3.18.

    - `cubic`: the C² spline; acceleration jumps at the start and the end only.
    - `quintic`: the C⁴ spline, acceleration zero at both ends. It is smoother and swings wider between waypoints.
    - Either is pulled in where it would leave the position limits. Extra pieces slow or stop the joint near those
      waypoints. The cubic stays C² and the quintic C⁴.
    - `trapezoid`: straight from waypoint to waypoint, stopping at each. All joints accelerate, coast and brake
      together. Jerk is not limited.
    - `time_optimal`: the shortest motion along a cubic spline through the waypoints. Some velocity or acceleration
      is always at its limit. Jerk is not limited. It takes no `times`.
    - `s_curve`: straight from stop to stop in the shortest time within velocity, acceleration and jerk. A joint without
      a jerk limit takes 0.1 s to its acceleration limit. Each joint has a separate profile and all arrive together.
      Joints that share a motor move in proportion.

    Limits of the arm's motors (`arm.actuators`) hold as well. The exact extremes of the polynomials are checked, to
    1e-9.

    Without `times` the motion just meets one velocity, acceleration or given jerk limit. Joints without a velocity or
    acceleration limit get the usual one (1 rad/s, 0.25 m/s, 3 rad/s², 1 m/s²). Motions that stop at each waypoint are
    then the shortest. Splines are within 1 % of the shortest. Pulled-in ones are typically within 2 % (cubic) and 15 %
    (quintic). Where a path turns back, stopping may be faster. Consecutive waypoints nearer than 1e-6 are merged; if
    one remains, the motion has duration 0. With `times`, missing limits are not checked. `notes` tell what was assumed,
    merged, unwrapped or smoothed away.

    Source: Lynch & Park, Modern Robotics, §9.2 and §9.3.

    Args:
        arm: The arm.
        waypoints: One or more arrays (n,) [rad, m], mappings {joint: value}, pose names (`arm.configurations`) or
            targets.
        kind: "cubic", "quintic", "trapezoid", "time_optimal" or "s_curve".
        limits: By default those of the arm; a `JointLimits`, or changes such as {"velocity": 1.0, "acceleration":
            {"elbow": 2.0}} [rad/s, m/s and so on].
        times: Times of the waypoints (k,) [s], increasing from 0. None: as short as the limits allow.
        stop_at_waypoints: Whether cubic and quintic move straight and rest at every waypoint. Without it a spline may
            swing beyond its waypoints, inside the limits.
        position_tol: Tolerance of a target [m]; 1e-6 by default.
        orientation_tol: Tolerance of its rotation [rad], likewise.
        unwrap: Whether these joints go to configurations by the shorter way too.
        smooth: How far [rad, m] each joint may deviate from recorded waypoints: 0.01 for two decimals. Third
            differences become as small as that allows, and a stay is passed once. The first and the last waypoint are
            kept. None: all are passed exactly.
        scene: A `Scene` of the arm, or None. The motion is then proven free of collisions, without gaps.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`, a piecewise polynomial in time.

    Raises:
        LimitError: A waypoint lies outside the position limits, or the times are too short. The message gives joint,
            limit, value and place.
        InputError: An argument does not fit the arm.
        UnknownNameError: No such pose or joint.
        NotConvergedError: A target is not met; the message names the waypoint and explains why.
        PathError: The motion collides; the message gives time and pair.
    """
    require_choice(kind, KINDS, "kind")
    as_flag(stop_at_waypoints, "stop_at_waypoints")
    require_callback(progress, "progress", "(fraction)")
    as_flag(unwrap, "unwrap")
    points, turned = as_waypoints(require_arm(arm), waypoints, decided(arm, position_tol, orientation_tol), unwrap)
    free = times is None or kind == "s_curve"
    bounds, notes = completed(arm, limits) if free else (as_limits(arm, limits), ())
    require_waypoints(points, bounds, arm.joint_names, arm.units)
    points, merged = _prepared(points, None if smooth is None else as_positive(smooth, "smooth"), bounds, times is None)
    inside = PathBounds(bounds, arm.actuators)
    timed = _timed(points, kind, stop_at_waypoints, times, inside, progress)
    motion = Trajectory(
        arm.joint_names, arm.units, points, *timed, arm.actuators, notes=(*notes, *turned, *merged), limits=bounds
    )
    if times is not None and kind not in BY_LAW:
        require_rates(motion, bounds)
        if arm.actuators is not None:
            require_rates(motion.to_motors(), arm.actuators.limits, "motor")
    if scene is not None:
        from .in_scene import require_free

        require_free(scene, arm, motion)
    if progress is not None:
        progress(1.0)
    return motion


def as_waypoints(arm: Arm, waypoints: Waypoints, met: Tolerances, unwrap: bool) -> tuple[Array, list[str]]:
    """Return waypoints (k, n), k ≥ 1, from arrays, {joint: value} mappings, names and targets; and notes."""
    if isinstance(waypoints, str | Mapping) or not np.iterable(waypoints):
        raise InputError(f"waypoints must be a sequence of configurations; got {shown(waypoints)}")
    points: list[Array] = []
    notes: list[str] = []
    for i, waypoint in enumerate(waypoints):
        theta = _waypoint(arm, waypoint, i, points[-1] if points else arm.ready, met)
        notes += rounding_note(arm, waypoint, theta, f"waypoint {i} (counted from 0)", met)
        if points:
            theta, said = unwrapped(arm, theta, points[-1], f"waypoint {i} (counted from 0)", unwrap)
            notes += said
        points.append(theta)
    if not points:
        raise InputError("waypoints must be at least one configuration; got none")
    return np.array(points), notes


def as_limits(arm: Arm, limits: JointLimits | Mapping[str, Any] | None) -> JointLimits:
    """Return the arm's limits, those given instead, or the arm's with the given changes."""
    if limits is None:
        return arm.limits
    if isinstance(limits, Mapping):
        return arm.limits.with_(limits, arm.joint_names)
    if not isinstance(limits, JointLimits) or len(limits.lower) != arm.n:
        raise InputError(
            f"limits must be JointLimits of {arm.n} joints or a mapping such as dict(velocity=1.0); got {shown(limits)}"
        )
    return limits


def completed(arm: Arm, limits: JointLimits | Mapping[str, Any] | None) -> tuple[JointLimits, tuple[str, ...]]:
    """Return the limits that time a motion, completed by usual ones, and notes on these."""
    given = as_limits(arm, limits)
    said = defaults_line(arm, given)
    return with_defaults(arm, given), (said,) if said else ()


def _waypoint(arm: Arm, waypoint: Any, index: int, near: Array, met: Tolerances) -> Array:
    """The configuration (n,) of a waypoint. For a target, the one nearest to `near` (n,)."""
    if isinstance(waypoint, TARGETS) or _is_pose(waypoint):
        solution = solve_ik(arm, waypoint, near, **met.keywords, posture="theta0")
        if not solution.converged:
            why = joined(": ", [f"waypoint {index} (counted from 0)", in_one_line(solution)])
            raise NotConvergedError(why, solution)
        return np.array(solution.theta)
    theta = arm.theta_from(waypoint, name=f"waypoint {index}")
    if theta.ndim != 1:
        raise InputError(f"waypoint {index} must be one configuration ({arm.n},); got {theta.shape}")
    return theta


def _is_pose(waypoint: Any) -> bool:
    if isinstance(waypoint, str | Mapping) or waypoint is None:
        return False
    numbers = waypoint if isinstance(waypoint, np.ndarray) else as_reals(waypoint, "a waypoint")
    return numbers.shape == (4, 4)


def _as_times(times: ArrayLike, count: int) -> Array:
    when = as_floats(times, "times")
    if when.shape != (count,):
        raise InputError(f"times must be one instant per waypoint, ({count},); got {when.shape}")
    if when[0] != 0 or not (np.diff(when) > 0).all():
        raise InputError(f"times must start at 0 and increase strictly; got {when.tolist()}")
    if count == 1:
        return when
    least = float(np.diff(when).min())
    if least < LEAST_SEGMENT * when[-1] or not SHORTEST <= when[-1] <= LONGEST:
        raise InputError(
            f"times must span {SHORTEST:g} s to {LONGEST:g} s with no segment under {LEAST_SEGMENT:g} of "
            f"the whole; got a segment of {least:.3g} s in {when[-1]:.3g} s"
        )
    return when


def _distinct(points: Array) -> tuple[Array, Array]:
    """Waypoints (j, n) without repetitions, and for each given one its index."""
    kept, owner = [0], [0]
    for i in range(1, len(points)):
        if np.abs(points[i] - points[kept[-1]]).max(initial=0.0) > MERGE_TOL:
            kept.append(i)
        owner.append(len(kept) - 1)
    kept[-1] = len(points) - 1
    return points[kept], np.array(owner)


def _prepared(points: Array, smooth: float | None, limits: JointLimits, merge: bool) -> tuple[Array, list[str]]:
    """Return the waypoints (k, n) to pass, smoothed or not, and notes on merged ones."""
    spare, stays = np.full(points.shape, smooth or 0.0), list[tuple[int, int]]()
    if smooth is not None:
        stays, given = _stays(points, STAY_WIDTH * smooth), points
        points = points.copy()
        for first, last in stays:
            within = slice(first, last + 1)
            low, high = given[within].min(axis=0), given[within].max(axis=0)
            points[within], spare[within] = 0.5 * (low + high), smooth - 0.5 * (high - low)
    kept, owner = _distinct(points)
    doubled = np.setdiff1d(np.flatnonzero(np.diff(owner) == 0) + 1, [i for a, b in stays for i in range(a, b + 1)])
    if smooth is not None:
        eased = smoothed(kept, spare[np.searchsorted(owner, np.arange(len(kept)))])
        points = np.clip(eased, limits.lower, limits.upper)[owner]
    notes = []
    if stays:
        which = _named([f"{first} to {last}" for first, last in stays])
        notes.append(f"stays at one place within the tolerance: waypoints {which} (counted from 0)")
    if merge and len(doubled):
        which = _named(list(map(str, doubled)))
        notes.append(f"merged with the waypoint before, which is at the same place: {which} (counted from 0)")
    return points, notes


def _named(each: Sequence[str]) -> str:
    return ", ".join(each[:MOST_NAMED]) + ", …" * (len(each) > MOST_NAMED)


def _stays(points: Array, width: float) -> list[tuple[int, int]]:
    """Return first and last of waypoints that stay within `width` far longer than others."""
    runs, start = [], 0
    low = high = points[0]
    for i, point in enumerate(points):
        lowest, highest = np.minimum(low, point), np.maximum(high, point)
        if (highest - lowest).max(initial=0.0) > width:
            runs.append((start, i - 1))
            start, lowest, highest = i, point, point
        low, high = lowest, highest
    runs.append((start, len(points) - 1))
    usual = float(np.median([last - first + 1 for first, last in runs]))
    least = max(STAY, STAY_SHARE * usual)
    return [(max(a, 1), min(b, len(points) - 2)) for a, b in runs if b - a + 1 >= least]


def _timed(
    points: Array, kind: Kind, stop: bool, times: ArrayLike | None, bounds: PathBounds, progress: Progress | None
) -> Motion:
    """Return the motion at the given times, or else the shortest found."""
    if times is not None:
        if kind == "time_optimal":
            raise InputError("a time_optimal motion takes no times: it is as fast as it can be; other kinds take them")
        when = _as_times(times, len(points))
        if len(points) == 1:
            return when, np.zeros(2), points[None]
        if kind == "s_curve":
            return double_s_rests(points, bounds, when)
        if kind == "trapezoid":
            return when, *spline.trapezoid(points, when, timing.trapezoid_ramps(points, when, bounds))
        return when, *pulled_in(FITS[kind, stop](points, when), when, points, bounds.limits)
    kept, owner = _distinct(points)
    if len(kept) == 1:
        return np.zeros(len(points)), np.zeros(2), kept[None]
    kept_times, breakpoints, coefficients = _fastest(kept, kind, stop, bounds, progress)
    return kept_times[owner], breakpoints, coefficients


def _fastest(points: Array, kind: Kind, stop: bool, bounds: PathBounds, progress: Progress | None) -> Motion:
    """Return the shortest motion found through waypoints that all differ from the one before."""
    if kind == "trapezoid":
        times, ramps = timing.fastest_trapezoid(points, bounds)
        return times, *spline.trapezoid(points, times, ramps)
    if kind == "s_curve":
        return double_s_rests(points, bounds)
    if kind == "time_optimal":
        return fastest_rests(points, bounds) if stop else fastest_along_spline(points, bounds, progress)
    fit = FITS[kind, stop]
    if stop:
        times = timing.fastest_rests(points, fit, bounds)
        return times, times, fit(points, times)
    return timing.fastest_spline(points, DEGREES[kind], fit, bounds, progress)
