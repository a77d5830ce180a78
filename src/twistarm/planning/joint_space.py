"""plan_joint: a motion through joint-space waypoints inside the joint limits."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.usual_limits import defaults_line, with_defaults
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, as_flag, as_positive, require_callback, require_choice
from ..support.errors import InputError, shown
from . import spline
from .time_laws.law import PathBounds
from .tolerances import decided
from .trajectory import Progress, Trajectory
from .waypoint_motion import Motion, shortest_motion
from .waypoints import Waypoints, as_times, as_waypoints, distinct, smoothed
from .within import require_rates, require_waypoints

if TYPE_CHECKING:
    from ..collision import Scene

Kind = Literal["s_curve", "time_optimal", "cubic", "quintic"]
LAWS: tuple[Kind, ...] = ("s_curve", "time_optimal")
"""Kinds that find the times of the waypoints."""

SPLINES: tuple[Kind, ...] = ("cubic", "quintic")
"""Kinds for given times."""

FITS = {
    ("cubic", False): spline.cubic,
    ("quintic", False): spline.quintic,
    ("cubic", True): spline.cubic_rests,
    ("quintic", True): spline.quintic_rests,
}
"""The spline of each kind: through the waypoints, or resting at each."""


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
    scene: Scene | None = None,
    progress: Progress | None = None,
) -> Trajectory:
    """Plan a motion through `waypoints`, from rest to rest, inside the joint limits.

    A waypoint is a configuration or a target: `Pose`, `Position`, `Approach`, `TolerancedPose` or a pose (4, 4).
    `solve_ik` finds the configuration of a target from the waypoint before it, or from `arm.ready`. Joints that can
    turn by 2π go to a target by the shorter way. To a configuration they go as written: from 0 to 2π by a full turn.
    `unwrap` chooses the shorter way there too: from 3.1 to −3.1 by 0.08 rad, to 3.18.

    Without `times` a path leads through the waypoints, and a time law follows it as fast as the limits allow:

    - `s_curve` (default): acceleration is continuous and jerk within its limits. A joint without a jerk limit takes
      0.1 s to its acceleration limit.
    - `time_optimal`: some velocity or acceleration is always at its limit. Jerk is not limited.

    The path is the best of several splines: C² cubic or C⁴ quintic. The motion stops at a waypoint where that is
    sooner done. It goes straight to and from such stops that follow one another. With `stop_at_waypoints` it stops at
    all. An `s_curve` then gives each joint a separate profile, and all arrive together.

    At given `times` the motion is a spline in time, and the limits are checked:

    - `cubic` (default): C²; acceleration jumps at the start and the end only.
    - `quintic`: C⁴, acceleration zero at both ends. It is smoother and swings wider between waypoints.

    With `stop_at_waypoints` these polynomials go straight and rest at every waypoint. A spline is pulled in where it
    would leave the position limits: extra pieces slow or stop the joint near those waypoints. It stays C² or C⁴.

    Limits of the arm's motors (`arm.actuators`) hold as well. The exact extremes of the polynomials are checked, to
    1e-9. Without `times`, joints without a velocity or acceleration limit get the usual one (1 rad/s, 0.25 m/s, 3
    rad/s², 1 m/s²). With `times`, missing limits are not checked. Without `times`, consecutive waypoints nearer than
    1e-6 are merged. If one remains, the motion has duration 0. All others are met within 1e-9. `notes` tell what was
    assumed, merged or unwrapped.

    Source: Lynch & Park, Modern Robotics, §9.2 to §9.4.

    Args:
        arm: The arm.
        waypoints: One or more arrays (n,) [rad, m], mappings {joint: value}, pose names (`arm.configurations`) or
            targets.
        kind: "s_curve" or "time_optimal", and at given times "cubic" or "quintic".
        limits: By default those of the arm; a `JointLimits`, or changes such as {"velocity": 1.0, "acceleration":
            {"elbow": 2.0}} [rad/s, m/s and so on].
        times: Times of the waypoints (k,) [s], increasing from 0. None: as short as the limits allow.
        stop_at_waypoints: Whether the motion goes straight and rests at every waypoint. Without it a spline may swing
            beyond its waypoints, inside the limits.
        position_tol: Tolerance of a target [m]; 1e-5 by default.
        orientation_tol: Tolerance of its rotation [rad]; 5e-5 by default.
        unwrap: Whether these joints go to configurations by the shorter way too.
        smooth: How far [rad, m] each joint may deviate from recorded waypoints: 0.01 for two decimals. They become as
            smooth as that allows. The first and the last waypoint are kept. None: all are passed exactly.
        scene: A `Scene` of the arm, or None. The motion is then proven free of collisions, without gaps.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`, a piecewise polynomial in time.

    Raises:
        LimitError: A waypoint lies outside the position limits, or the times are too short. The message gives joint,
            limit, value and place.
        InputError: An argument does not fit the arm, or the kind does not go with `times`.
        UnknownNameError: No such pose or joint.
        NotConvergedError: A target is not met; the message names the waypoint and explains why.
        PathError: The motion collides; the message gives time and pair.
    """
    chosen = _as_kind(kind, times)
    as_flag(stop_at_waypoints, "stop_at_waypoints")
    require_callback(progress, "progress", "(fraction)")
    as_flag(unwrap, "unwrap")
    points, said = as_waypoints(require_arm(arm), waypoints, decided(position_tol, orientation_tol), unwrap)
    bounds, notes = completed(arm, limits) if times is None else (as_limits(arm, limits), ())
    require_waypoints(points, bounds, arm.joint_names, arm.units)
    if smooth is not None:
        points = smoothed(points, as_positive(smooth, "smooth"), bounds)
    inside = PathBounds(bounds, arm.actuators)
    if times is None:
        knots, owner, merged = distinct(points)
        said += merged
        timed = _timed_by_law(knots, chosen, stop_at_waypoints, inside, progress)
        timed = timed[0][owner], *timed[1:]
    else:
        timed = _at_times(points, chosen, stop_at_waypoints, as_times(times, len(points)), inside)
    motion = Trajectory(arm.joint_names, arm.units, points, *timed, arm.actuators, notes=(*notes, *said), limits=bounds)
    if times is not None:
        require_rates(motion, bounds)
        if arm.actuators is not None:
            require_rates(motion.to_motors(), arm.actuators.limits, "motor")
    if scene is not None:
        from .free_moves import require_free

        require_free(scene, arm, motion)
    if progress is not None:
        progress(1.0)
    return motion


def _as_kind(kind: str | None, times: ArrayLike | None) -> str:
    """Return the kind, or the default one. Laws find times, splines need them."""
    fitting, other = (LAWS, SPLINES) if times is None else (SPLINES, LAWS)
    if isinstance(kind, str) and kind in other:
        laws, splines = (" or ".join(map(repr, kinds)) for kinds in (LAWS, SPLINES))
        raise InputError(f"kind is {laws} without times, {splines} at given times; got {kind!r}")
    return fitting[0] if kind is None else require_choice(kind, fitting, "kind")


def _timed_by_law(knots: Array, kind: str, stop: bool, bounds: PathBounds, progress: Progress | None) -> Motion:
    if len(knots) == 1:
        return np.zeros(1), np.zeros(2), knots[None]
    return shortest_motion(knots, kind, bounds, stop=stop, progress=progress)


def _at_times(points: Array, kind: str, stop: bool, times: Array, bounds: PathBounds) -> Motion:
    if len(points) == 1:
        return times, np.zeros(2), points[None]
    return times, *spline.pulled_in(FITS[kind, stop](points, times), times, points, bounds.limits)


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
