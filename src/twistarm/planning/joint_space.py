"""plan_joint: a motion through joint-space waypoints inside the joint limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ..limits.joint_limits import JointLimits
from ..model.arm import Arm, require_arm
from ..support.caller_words import argument
from ..support.checks import Array, RealArray, Row, as_flag, as_floats, require_callback, require_choice
from ..support.errors import InputError, shown
from . import spline, timing
from .timing import Progress
from .trajectory import Trajectory
from .within import require_waypoints, require_within

Kind = Literal["cubic", "quintic", "trapezoid"]
KINDS: tuple[Kind, ...] = ("cubic", "quintic", "trapezoid")

MERGE_TOL = 1e-6
"""Consecutive waypoints nearer than this [rad, m] in every joint are one: IK answers no finer."""

LEAST_SEGMENT = 1e-7
"""Given times are nearer together than this part of the whole by mistake, and no spline could be computed."""

FITS = {
    ("cubic", False): spline.cubic,
    ("quintic", False): spline.quintic,
    ("cubic", True): spline.cubic_rests,
    ("quintic", True): spline.quintic_rests,
}
"""The spline of each kind: through the waypoints, or resting at each."""

Waypoints = RealArray | Sequence[Row | Mapping[str, float] | str]
"""Configurations as arrays, mappings {joint: value} or names of states."""


def plan_joint(
    arm: Arm,
    waypoints: Waypoints,
    *,
    kind: Kind = "cubic",
    limits: JointLimits | Mapping[str, Any] | None = None,
    times: ArrayLike | None = None,
    stop_at_waypoints: bool = False,
    progress: Progress | None = None,
) -> Trajectory:
    """A motion through `waypoints`, at rest at the first and the last, that keeps the joint limits everywhere.

    Waypoints (k, n), k ≥ 2 [rad, m]: arrays, mappings {joint: value} or names of poses (`arm.configurations`). No angle
    is wrapped, not even of a continuous joint: from 0 to 2π is a full turn.

    - `cubic`: the C² spline; acceleration jumps at the start and the end only.
    - `quintic`: the C⁴ spline, acceleration zero at both ends; smoother, and it swings wider between waypoints.
    - `trapezoid`: straight from waypoint to waypoint, stopping at each; all joints accelerate, coast and brake
      together. Its jerk is infinite: a jerk limit is not looked at.

    With `stop_at_waypoints` cubic and quintic rest at each waypoint too (quintic with zero acceleration) and move
    straight from one to the next; without it a spline may swing beyond the range of its waypoints.

    Without `times` the motion is as short as its kind was found to allow: one velocity, acceleration or (where
    given, for cubic and quintic) jerk limit is met exactly, none is exceeded, and velocity and acceleration limits
    must be there for every joint. For segments that stop that is the minimum. The proportions of a spline's
    segments are searched: typically within 2 % of the minimum for cubic and 10 % for quintic, which may be slower
    than stopping where a path turns back. Consecutive waypoints nearer than 1e-6 are merged; if none other
    remains, the motion has duration 0. With `times` (k,) [s], increasing from 0, the motion passes waypoint i at
    times[i], and limits that are missing are not checked.

    The extremes of the polynomials are checked, not samples (to 1e-9). Source: Lynch & Park, Modern Robotics, §9.2 and
    §9.3.

    Args:
        arm: The arm.
        waypoints: Configurations (k, n) [rad, m], k ≥ 2; each an array, a mapping {joint: value} or the name of a pose.
        kind: "cubic", "quintic" or "trapezoid".
        limits: By default those of the arm; a `JointLimits`, or changes to the arm's such as
            {"velocity": 1.0, "acceleration": {"elbow": 2.0}} [rad/s, m/s and so on].
        times: Times of the waypoints (k,) [s], increasing from 0; None for a motion as short as the limits allow.
        stop_at_waypoints: Whether the motion rests at every waypoint.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The `Trajectory`, a piecewise polynomial in time.

    Raises:
        LimitError: A waypoint lies outside the position limits, a spline swings outside them, the times are too short,
            or a needed limit is missing; the message gives joint, limit, value and place.
        InputError: An argument does not fit the arm.
        UnknownNameError: No such pose or joint.
    """
    require_choice(kind, KINDS, "kind")
    as_flag(stop_at_waypoints, "stop_at_waypoints")
    require_callback(progress, "progress", "(fraction)")
    points = as_waypoints(require_arm(arm), waypoints)
    bounds = as_limits(arm, limits)
    require_waypoints(points, bounds, arm.joint_names, arm.units)
    if times is not None:
        when = _as_times(times, len(points))
        breakpoints, coefficients = _at_times(points, kind, stop_at_waypoints, when, bounds)
    else:
        bounds.require(("velocity", "acceleration"), arm.joint_names)
        kept, owner = _distinct(points)
        kept_times, breakpoints, coefficients = _fastest(kept, kind, stop_at_waypoints, bounds, progress)
        when = kept_times[owner]
    motion = Trajectory(arm.joint_names, arm.units, points, when, breakpoints, coefficients, arm.actuators)
    rest = argument("stop_at_waypoints", True)
    require_within(motion, bounds, f"use {rest}, which goes straight from waypoint to waypoint, or add waypoints")
    if progress is not None:
        progress(1.0)
    return motion


def as_waypoints(arm: Arm, waypoints: Waypoints) -> Array:
    """Waypoints (k, n), k ≥ 2, from arrays, {joint: value} mappings and names of states."""
    if isinstance(waypoints, str | Mapping) or not np.iterable(waypoints):
        raise InputError(f"waypoints must be a sequence of at least two configurations; got {shown(waypoints)}")
    points = [_waypoint(arm, waypoint, i) for i, waypoint in enumerate(waypoints)]
    if len(points) < 2:
        raise InputError(f"waypoints must be at least two configurations, start and goal; got {len(points)}")
    return np.array(points)


def as_limits(arm: Arm, limits: JointLimits | Mapping[str, Any] | None) -> JointLimits:
    """The arm's limits, those given in their place, or the arm's with the changes given."""
    if limits is None:
        return arm.limits
    if isinstance(limits, Mapping):
        return arm.limits.with_(limits, arm.joint_names)
    if not isinstance(limits, JointLimits) or len(limits.lower) != arm.n:
        raise InputError(
            f"limits must be JointLimits of {arm.n} joints or a mapping such as dict(velocity=1.0); got {shown(limits)}"
        )
    return limits


def _waypoint(arm: Arm, waypoint: Any, index: int) -> Array:
    theta = arm.theta_from(waypoint, name=f"waypoint {index}")
    if theta.ndim != 1:
        raise InputError(f"waypoint {index} must be one configuration ({arm.n},); got {theta.shape}")
    return theta


def _as_times(times: ArrayLike, count: int) -> Array:
    when = as_floats(times, "times")
    if when.shape != (count,):
        raise InputError(f"times must be one instant per waypoint, ({count},); got {when.shape}")
    if when[0] != 0 or not (np.diff(when) > 0).all():
        raise InputError(f"times must start at 0 and increase strictly; got {when.tolist()}")
    least = float(np.diff(when).min())
    if least < LEAST_SEGMENT * when[-1] or not timing.SHORTEST <= when[-1] <= timing.LONGEST:
        raise InputError(
            f"times must span {timing.SHORTEST:g} s to {timing.LONGEST:g} s with no segment under {LEAST_SEGMENT:g} of "
            f"the whole; got a segment of {least:.3g} s in {when[-1]:.3g} s"
        )
    return when


def _distinct(points: Array) -> tuple[Array, Array]:
    """The waypoints that differ from their predecessor, (j, n), and which of them stands for each given, (k,)."""
    kept, owner = [0], [0]
    for i in range(1, len(points)):
        if np.abs(points[i] - points[kept[-1]]).max(initial=0.0) > MERGE_TOL:
            kept.append(i)
        owner.append(len(kept) - 1)
    kept[-1] = len(points) - 1
    return points[kept], np.array(owner)


def _at_times(points: Array, kind: Kind, stop: bool, times: Array, limits: JointLimits) -> tuple[Array, Array]:
    """Breakpoints and coefficients of a motion that passes each waypoint at its time."""
    if kind == "trapezoid":
        return spline.trapezoid(points, times, timing.trapezoid_ramps(points, times, limits))
    return times, FITS[kind, stop](points, times)


def _fastest(
    points: Array, kind: Kind, stop: bool, limits: JointLimits, progress: Progress | None
) -> tuple[Array, Array, Array]:
    """Times of the waypoints, breakpoints and coefficients of the shortest motion found."""
    if len(points) == 1:
        return np.zeros(1), np.zeros(2), points[None]
    if kind == "trapezoid":
        times, ramps = timing.fastest_trapezoid(points, limits)
        return times, *spline.trapezoid(points, times, ramps)
    fit = FITS[kind, stop]
    if stop:
        times = timing.fastest_rests(points, fit, limits)
        return times, times, fit(points, times)
    times, coefficients = timing.fastest_spline(points, fit, limits, progress)
    return times, times, coefficients
