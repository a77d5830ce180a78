"""plan_joint: a motion through joint-space waypoints inside the joint limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.usual_limits import defaults_line, with_defaults
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, Progress, as_flag, as_positive, require_callback, require_choice
from ..support.errors import InputError, quote
from ..support.messages import Argument, Quantity, Text
from ..support.messages import joined as joined_texts
from . import spline
from .piecewise import JointPath, bernstein, evaluate, rescaled, side_by_side
from .s_curve import double_s, double_s_durations, s_curve
from .time_law import PathBounds
from .time_optimal import line_durations, time_optimal
from .torque_limits import Load, torque_limits
from .trajectory import Trajectory
from .waypoints import Waypoints, as_times, as_tolerances, as_waypoints, distinct, smoothed
from .within import inside_from, on_limits, require_rates, require_span, returning

if TYPE_CHECKING:
    from ..collision import Scene

Kind = Literal["s_curve", "time_optimal", "cubic", "quintic"]
LAWS: tuple[Kind, ...] = ("s_curve", "time_optimal")  # Kinds that find the times of the waypoints.
SPLINES: tuple[Kind, ...] = ("cubic", "quintic")  # Kinds for given times.

# With at most so many waypoints the centripetal spline is a candidate. It is slow on many uneven ones.
FEW_WAYPOINTS = 30
# A path that takes longer than the fastest by this factor without jerk limits gets no s-curve.
WORTH_A_LAW = 1.05
# Through more waypoints only the path of the highest degree gets an s-curve: its law is the shortest, or nearly.
MANY_WAYPOINTS = 300
FIRST_PART = 0.8  # Share of the work when the motion without stops is there.
MOST_STOPS = 16  # Greatest number of stops on the way, unless the motion stops after every leg.
SWING = 0.01  # Share of a joint's range by which it may leave the interval of two waypoints without a note.
SHORT = 0.4  # A leg is short if it takes less than this share of the time of either leg beside it.

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)


class Motion(NamedTuple):
    """When each of k parts ends (k,) [s], breakpoints (p + 1,) from 0 on and coefficients (degree + 1, p, n)."""

    ends: Array
    breakpoints: Array
    coefficients: Array

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.breakpoints[-1])


def plan_joint(
    arm: Arm,
    waypoints: Waypoints,
    *,
    kind: Kind | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    times: ArrayLike | None = None,
    stop_at_waypoints: bool = False,
    position_tol: float | None = None,
    orientation_tol: float | None = None,
    unwrap: bool = False,
    smooth: float | None = None,
    torques: bool = False,
    payload: Load = 0.0,
    scene: Scene | None = None,
    progress: Progress | None = None,
) -> Trajectory:
    """Plan a motion through `waypoints`, from rest to rest, inside the joint limits.

    A waypoint is a configuration or a target: `Pose`, `Position`, `Approach`, `TolerancedPose` or a pose (4, 4).
    `solve_ik` finds the configuration of a target from the waypoint before it, or from `arm.ready`. Joints that can
    turn by 2π go to a target by the shorter way. To a configuration they go as written: from 0 to 2π by a full turn.

    Without `times` a path leads through the waypoints. A time law follows it as fast as the limits allow:

    - `s_curve` (default): acceleration is continuous and jerk within its limits. A joint without a jerk limit takes
      0.1 s to its acceleration limit.
    - `time_optimal`: some velocity or acceleration is always at its limit. Jerk is not limited.

    The path is the best of several splines: C² cubic or C⁴ quintic. The motion stops at a waypoint where that takes
    less time. Between two such stops in a row it is straight. With `stop_at_waypoints` it stops at all. An `s_curve`
    then gives each joint a separate profile, and all arrive together.

    At given `times` the motion is a spline in time, and the limits are checked:

    - `cubic` (default): C²; acceleration jumps at the start and the end only.
    - `quintic`: C⁴, acceleration zero at both ends. It is smoother and swings wider between waypoints.

    With `stop_at_waypoints` these polynomials go straight and rest at every waypoint. A spline is pulled in where it
    would leave the position limits. Extra pieces slow or stop the joint near those waypoints. It stays C² or C⁴.

    Limits of the arm's motors (`arm.actuators`) hold as well. The exact extremes of the polynomials are checked, to
    1e-9. Waypoints are met within 1e-9. `notes` tell what was assumed, merged or unwrapped, and which joints swing far
    past their waypoints.

    - Without `times`, a missing velocity or acceleration limit is the usual one (1 rad/s, 0.25 m/s, 3 rad/s², 1 m/s²).
      Consecutive waypoints nearer than 1e-6 are merged. If one remains, the motion has duration 0.
    - With `times`, missing limits are not checked.

    Source: Lynch & Park, Modern Robotics, §9.2 to §9.4.

    Args:
        arm: The arm.
        waypoints: One or more arrays (n,) [rad, m], mappings {joint: value}, names of `arm.configurations` or
            targets.
        kind: "s_curve" or "time_optimal", and at given times "cubic" or "quintic".
        limits: By default those of the arm. Or a `JointLimits`, or changes such as {"velocity": 1.0, "acceleration":
            {"elbow": 2.0}} [rad/s, m/s and so on].
        times: Times of the waypoints (k,) [s], increasing from 0. None: as short as the limits allow.
        stop_at_waypoints: Whether the motion goes straight and rests at every waypoint. Without it a spline may swing
            beyond its waypoints, inside the limits.
        position_tol: Tolerance of a target [m]; 1e-5 by default.
        orientation_tol: Tolerance of its rotation [rad]; 5e-5 by default.
        unwrap: Whether these joints go to configurations by the shorter way too, from 3.1 by 0.08 rad to −3.1 (3.18).
        smooth: How far [rad, m] each joint may deviate from recorded waypoints: 0.01 for two decimals. They become as
            smooth as that allows. The first and the last waypoint are kept. None: all are passed exactly.
        torques: Whether the efforts of joints and motors limit the motion too, by the masses of the arm.
        payload: What the tool carries then, a mass [kg] or (mass, place (3,) in tool axes [m]).
        scene: A `Scene` of the arm, or None. The motion is then proven free of collisions, without gaps.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`, a piecewise polynomial in time.

    Raises:
        LimitError: A waypoint lies outside the position limits, or the times are too short. Or the efforts do not hold
            arm and payload at rest. The message gives joint, limit, value and place. From a start up to 0.2 rad or
            20 mm outside, the motion returns inside.
        InputError: An argument does not fit the arm, or the kind does not go with `times`.
        UnknownNameError: No such configuration or joint.
        NotConvergedError: A target is not met; the message names the waypoint and explains why.
        PathError: The motion collides; the message gives time and pair.
    """
    chosen = _as_kind(kind, times)
    as_flag(stop_at_waypoints, "stop_at_waypoints")
    require_callback(progress, "progress", "(fraction)")
    as_flag(unwrap, "unwrap")
    points, notes = as_waypoints(require_arm(arm), waypoints, as_tolerances(position_tol, orientation_tol), unwrap)
    bounds, usual = completed(arm, limits) if times is None else (as_limits(arm, limits), ())
    start, back = points[0].copy(), list[Text]()
    if len(points) > 1 or times is None:
        points[0], back = inside_from(start, bounds, arm.joint_names, arm.units)
    points = on_limits(points, bounds, arm.joint_names, arm.units)
    if smooth is not None:
        points = smoothed(points, as_positive(smooth, "smooth"), bounds)
    inside = PathBounds(bounds, arm.actuators, torques=torque_limits(arm, bounds.effort, torques, payload))
    if inside.torques is not None:
        for i, point in enumerate(points):
            inside.torques.require_held(point, f"waypoint {i} (0 is the start)")
    if times is None:
        points, timed, merged = _by_law(points, start if back else None, chosen, inside, stop_at_waypoints, progress)
        notes += merged
    else:
        points[0] = start if back else points[0]
        timed = _at_times(arm, points, times, chosen, bounds, stop_at_waypoints)
    if len(points) > 2 and not stop_at_waypoints:
        notes += swings(arm, points, timed)
    ends, breakpoints, coefficients = timed
    motion = Trajectory(
        arm.joint_names, arm.units, points, ends, breakpoints, coefficients, arm.actuators,
        notes=(*usual, *notes, *back), limits=bounds,
    )  # fmt: skip
    if times is not None:
        _require_kept(motion, inside)
    if scene is not None:
        from .free_moves import require_free  # only here: it loads the collision library

        require_free(scene, arm, motion)
    if progress is not None:
        progress(1.0)
    return motion


def _by_law(
    points: Array, start: Array | None, law: str, bounds: PathBounds, stop: bool, progress: Progress | None
) -> tuple[Array, Motion, list[str]]:
    """Waypoints (k, n), the shortest motion with the time of each, and notes. From a `start` (n,) it returns inside."""
    knots, owner, notes = distinct(points)
    timed = shortest_motion(knots, law, bounds, stop=stop, progress=progress)
    ends = np.append(0.0, timed.ends)[owner]
    if start is not None:
        there, rest = shortest_motion(np.array([start, points[0]]), law, bounds), min(1, len(points) - 1)
        points, ends = np.vstack([start, points[rest:]]), np.append(0.0, ends[rest:] + there.duration)
        timed = joined([there, timed])
    return points, timed._replace(ends=ends), notes


def _at_times(arm: Arm, points: Array, times: ArrayLike, kind: str, bounds: JointLimits, stop: bool) -> Motion:
    """The spline through waypoints (k, n) at their times (k,), inside the position limits."""
    ends = as_times(times, len(points))
    if len(points) == 1:
        return Motion(ends, np.zeros(2), points[None])
    fit = spline.at_times(kind, points, ends, stop)
    return Motion(ends, *spline.pulled_in(fit, ends, points, returning(bounds, points[0], arm.units)))


def _require_kept(motion: Trajectory, bounds: PathBounds) -> None:
    """Raise LimitError where a motion leaves the limits of rates of joints and motors, or their torques."""
    require_rates(motion, bounds.limits)
    if bounds.actuators is not None:
        require_rates(motion.to_motors(), bounds.actuators.limits, "motor")
    if bounds.torques is not None:
        bounds.torques.require_kept(motion.breakpoints, motion.coefficients)


def swings(arm: Arm, points: Array, timed: Motion) -> list[Text]:
    """Return a note on the joints that swing far past the two waypoints (k, n) before and after, if there are any."""
    ends, breakpoints, coefficients = timed
    tau = np.linspace(0.0, 1.0, 17)[:, None] * np.diff(breakpoints)
    leg = np.searchsorted(ends, breakpoints[:-1] + tau).clip(1, len(points) - 1)
    theta = evaluate(coefficients, tau[..., None])
    inside = theta.clip(np.minimum(points[leg - 1], points[leg]), np.maximum(points[leg - 1], points[leg]))
    past, inside = np.abs(theta - inside).reshape(-1, arm.n), inside.reshape(-1, arm.n)
    lower, upper = arm.sampling_bounds
    parts = []
    for j in np.flatnonzero(past.max(axis=0) > SWING * (upper - lower)):
        i = past[:, j].argmax()
        far, value = (Quantity(float(of[i, j]), arm.units[j], 3) for of in (past, inside))
        parts.append(Text("{joint} {far} past {value}", joint=arm.joint_names[j], far=far, value=value))
    stop = Argument("stop_at_waypoints", True)
    text = "joints swing past their waypoints: {parts}; {stop} goes straight from one to the next"
    return [Text(text, parts=joined_texts(", ", parts), stop=stop)] if parts else []


def _as_kind(kind: str | None, times: ArrayLike | None) -> str:
    """Return the kind, or the default one. Laws find times, splines need them."""
    fitting, other = (LAWS, SPLINES) if times is None else (SPLINES, LAWS)
    if isinstance(kind, str) and kind in other:
        laws, splines = (" or ".join(map(repr, kinds)) for kinds in (LAWS, SPLINES))
        raise InputError(f"kind is {laws} without times, {splines} at given times; got {kind!r}")
    return fitting[0] if kind is None else require_choice(kind, fitting, "kind")


def as_limits(arm: Arm, limits: JointLimits | Mapping[str, Any] | None) -> JointLimits:
    """Return the arm's limits, those given instead, or the arm's with the given changes."""
    if limits is None:
        return arm.limits
    if isinstance(limits, Mapping):
        return arm.limits.with_(limits, arm.joint_names)
    if not isinstance(limits, JointLimits) or len(limits.lower) != arm.n:
        raise InputError(
            f"limits must be JointLimits of {arm.n} joints or a mapping such as dict(velocity=1.0); got {quote(limits)}"
        )
    return limits


def completed(arm: Arm, limits: JointLimits | Mapping[str, Any] | None) -> tuple[JointLimits, tuple[str, ...]]:
    """Return the limits that time a motion, completed by usual ones, and notes on these."""
    given = as_limits(arm, limits)
    line = defaults_line(arm, given)
    return with_defaults(arm, given), (line,) if line else ()


def shortest_motion(
    points: Array, law: str, bounds: PathBounds, *, stop: bool = False, progress: Progress | None = None
) -> Motion:
    """Return the shortest motion found through distinct waypoints (k, n), from rest to rest, with k − 1 parts.

    It stops at every waypoint if `stop`, and goes straight then. Otherwise it stops only where that is sooner done.
    Between stops it follows the spline with the shortest law.
    """
    if len(points) == 1:
        return Motion(np.zeros(0), np.zeros(2), points[None])
    ways = np.diff(points, axis=0)
    straight = straight_s_curve if law == "s_curve" else _along_line

    @cache
    def timed(i: int, j: int) -> Motion:
        return straight(points[i], points[j], bounds) if j == i + 1 else _along_spline(points[i : j + 1], law, bounds)

    if bounds.torques is None:
        alone = (double_s_durations if law == "s_curve" else line_durations)(ways, bounds)
    else:
        alone = np.array([timed(i, i + 1).duration for i in range(len(ways))])
    require_span(float(alone.sum()))
    if not stop and progress is not None:
        timed(0, len(alone))
        progress(FIRST_PART)
    stops = range(1, len(alone)) if stop else best_stops(timed, alone)
    return joined([timed(i, j) for i, j in pairwise([0, *stops, len(alone)])])


def best_stops(timed: Callable[[int, int], Motion], alone: Array) -> tuple[int, ...]:
    """Return after which of m legs to stop: none, all, or a few that save time.

    A stop may save time where both legs beside it take longer on the way than from rest to rest. It may save time at
    both ends of a short leg, too. Such stops that do not help are left out one by one.

    Args:
        timed: The motion along legs i … j − 1 from rest to rest, without a stop between them.
        alone: The time of each leg from rest to rest (m,) [s].
    """
    count = len(alone)
    if count == 1:
        return ()

    def whole(stops: Iterable[int]) -> float:
        return sum(alone[i] if j == i + 1 else timed(i, j).duration for i, j in pairwise([0, *stops, count]))

    passed = np.append(0.0, timed(0, count).ends)
    slow = np.flatnonzero(passed[2:] - passed[:-2] > alone[1:] + alone[:-1]) + 1
    short = np.flatnonzero(alone[1:-1] < SHORT * np.minimum(alone[:-2], alone[2:])) + 1
    few = [tuple(stops.tolist()) for stops in (slow, np.union1d(short, short + 1)) if len(stops) <= MOST_STOPS]
    best = min(((), tuple(range(1, count)), *few), key=whole)
    for stop in best if best in few else ():  # over the stops found above, though `best` becomes shorter
        without = tuple(other for other in best if other != stop)
        best = min(best, without, key=whole)
    return best


def joined(motions: Sequence[Motion]) -> Motion:
    """One motion after the other. One of no length adds no piece."""
    starts = np.cumsum([0.0, *(motion.duration for motion in motions)])
    ends = np.concatenate([start + motion.ends for start, motion in zip(starts, motions, strict=False)])
    moving = [(start, motion) for start, motion in zip(starts, motions, strict=False) if motion.duration]
    if not moving:
        return Motion(ends, *motions[0][1:])
    breakpoints = np.concatenate([[0.0], *(start + motion.breakpoints[1:] for start, motion in moving)])
    return Motion(ends, breakpoints, side_by_side([motion.coefficients for _, motion in moving]))


def straight_s_curve(start: Array, goal: Array, bounds: PathBounds, straight: bool = False) -> Motion:
    """The `double_s`. Under torque limits the shorter of a slower one and the s-curve along the straight line."""
    breakpoints, coefficients = double_s(start, goal, bounds, straight)
    slower = 1.0 if bounds.torques is None else max(1.0, bounds.torques.slowing(breakpoints, coefficients))
    if slower > 1.0:
        line = JointPath.straight(start, goal)
        law = s_curve(line, bounds)
        if law.duration < slower * breakpoints[-1]:
            breakpoints, coefficients = law.along(line)
        else:
            breakpoints, coefficients = slower * breakpoints, rescaled(coefficients, 1.0 / slower)
    return Motion(breakpoints[-1:], breakpoints, coefficients)


def _along_line(start: Array, goal: Array, bounds: PathBounds) -> Motion:
    line = JointPath.straight(start, goal)
    breakpoints, coefficients = time_optimal(line, bounds).along(line)
    return Motion(breakpoints[-1:], breakpoints, coefficients)


def _along_spline(points: Array, law: str, bounds: PathBounds) -> Motion:
    """Return the shortest motion along one of the splines through the waypoints, without a stop."""
    paths = spline_paths(points, bounds)
    laws = [time_optimal(path, bounds) for path, _ in paths]
    if law == "s_curve":
        most = WORTH_A_LAW * min(candidate.duration for candidate in laws)
        paths = [path for path, candidate in zip(paths, laws, strict=True) if candidate.duration <= most]
        if len(points) > MANY_WAYPOINTS:
            paths = [max(paths, key=lambda candidate: len(candidate[0].coefficients))]
        laws = [s_curve(path, bounds) for path, _ in paths]
    best = min(range(len(laws)), key=lambda i: laws[i].duration)
    path, places = paths[best]
    return Motion(laws[best].passes(places)[1:], *laws[best].along(path))


def spline_paths(points: Array, bounds: PathBounds) -> list[tuple[JointPath, Array]]:
    """Return candidate paths through distinct waypoints (k, n), k ≥ 3, with the place s of each waypoint (k,).

    Distances are Euclidean in C q / velocity: s counts seconds at full speed. Candidates are the C² cubic by chords and
    the C⁴ quintic by its own arc length. For few waypoints the centripetal C² cubic is one, too (Lee 1989). A path that
    would leave the position limits becomes a natural cubic. Its knots are at the waypoints, and it is pulled inside.
    """
    chords = _length(np.diff(points, axis=0), bounds)
    rough = JointPath(*spline.natural(points, _summed(chords), 5))
    at = _summed(chords)[:-1] + 0.5 * (GAUSS_POINTS[:, None] + 1.0) * chords
    arcs = 0.5 * chords * (GAUSS_WEIGHTS @ _length(rough(at, 1), bounds))
    candidates = [(chords, 3), (arcs, 5), *([(np.sqrt(chords), 3)] if len(points) <= FEW_WAYPOINTS else [])]
    return [_through(points, _summed(steps), degree, bounds) for steps, degree in candidates]


def _through(points: Array, s: Array, degree: int, bounds: PathBounds) -> tuple[JointPath, Array]:
    breakpoints, coefficients = spline.natural(points, s, degree)
    lower, upper = np.minimum(bounds.limits.lower, points.min(0)), np.maximum(bounds.limits.upper, points.max(0))
    if spline.outside(bernstein(coefficients, np.diff(breakpoints)), lower, upper).any():
        _, coefficients = spline.interpolating(points, s, s[1:-1], (2,))
        return JointPath(*spline.pulled_in(coefficients, s, points, bounds.limits)), s
    return JointPath(breakpoints, coefficients).cut_at(s), s


def _length(way: Array, bounds: PathBounds) -> Array:
    """Return the Euclidean length (...) of ways (..., n) in C q / velocity [s]."""
    return np.linalg.norm(way @ bounds.C.T / bounds.velocity, axis=-1)


def _summed(steps: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(steps)])
