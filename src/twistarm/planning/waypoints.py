"""Waypoints in joint space: configurations from what a user gives, unwrapped, without repetitions, smoothed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm
from ..ik.ranges import joint_ranges
from ..ik.request import as_orientation_tol, as_tolerance
from ..ik.solution import in_one_line
from ..ik.solve import solve_ik
from ..ik.targets import KINDS as TARGETS
from ..ik.targets import TargetLike
from ..ik.task_space import USUAL, Tolerances
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, RealArray, Row, as_floats, as_reals
from ..support.errors import InputError, NotConvergedError, quote
from ..support.messages import Argument, Quantity, Text, joined
from .spline import scipy
from .within import LONGEST, SHORTEST

MERGE_TOL = 1e-6  # Consecutive waypoints nearer than this [rad, m] in every joint are one.
MOST_NAMED = 12  # So many merged waypoints are named, and about so many joints that turn far.
# Times closer than this share of the duration are a mistake. No spline can be computed for them.
LEAST_SEGMENT = 1e-7
# Greatest power of ten of λ or 1/λ of a smoothing spline, and steps to find it.
STIFFEST, BISECTIONS = 12.0, 30
# Weight of the first and the last waypoint. The spline passes them to rounding, and then they are put in.
PINNED = 1e9
LEAST_STEP = 0.1  # Least distance between two middles, in tolerances.
FEWEST = 5  # A smoothing spline needs so many waypoints.
# A joint that turns farther than this [rad] can reach the same place by a shorter way.
HALF_TURN = np.pi * (1.0 + 1e-9)

UNWRAP = Argument("unwrap", True)

# Configurations as arrays, mappings {joint: value} or names of states, and targets of the tool.
Waypoints = RealArray | Sequence[Row | Mapping[str, float] | str | TargetLike]


def as_tolerances(position_tol: float | None, orientation_tol: float | None) -> Tolerances:
    """Return the tolerances of a motion's targets, the usual ones for None."""
    return Tolerances(
        USUAL.position if position_tol is None else as_tolerance(position_tol, "position_tol [m]"),
        USUAL.orientation if orientation_tol is None else as_orientation_tol(orientation_tol),
    )


def as_waypoints(arm: Arm, waypoints: Waypoints, tolerances: Tolerances, unwrap: bool) -> tuple[Array, list[str]]:
    """Return waypoints (k, n), k ≥ 1, from arrays, {joint: value} mappings, names and targets; and notes."""
    if isinstance(waypoints, str | Mapping) or not np.iterable(waypoints):
        raise InputError(f"waypoints must be a sequence of configurations; got {quote(waypoints)}")
    rows = waypoints if isinstance(waypoints, np.ndarray) else np.zeros(0)
    if rows.shape[1:] == (arm.n,) and len(rows) and (np.abs(np.diff(rows, axis=0)) <= HALF_TURN).all():
        return np.array(arm.theta_from(rows, name="waypoints")), []  # there is nothing to solve or to unwrap
    points: list[Array] = []
    notes: list[str] = []
    for i, waypoint in enumerate(waypoints):
        theta = _configuration(arm, waypoint, i, points[-1] if points else arm.ready, tolerances)
        if points and (unwrap or len(notes) < MOST_NAMED):
            theta, shorter = unwrapped(arm, theta, points[-1], f"waypoint {i} (0 is the start)", unwrap)
            notes += shorter
        points.append(theta)
    if not points:
        raise InputError("waypoints must be at least one configuration; got none")
    if not unwrap and len(notes) >= MOST_NAMED:
        notes.append("later waypoints are not compared with shorter ways by whole turns")
    return np.array(points), notes


def _configuration(arm: Arm, waypoint: Any, index: int, near: Array, tolerances: Tolerances) -> Array:
    """The configuration (n,) of a waypoint. For a target, the one nearest to `near` (n,)."""
    if isinstance(waypoint, TARGETS) or _is_pose(waypoint):
        where = f"waypoint {index} (0 is the start)"
        return np.array(solved(arm, waypoint, near, where, **tolerances.keywords, posture="theta0"))
    theta = arm.theta_from(waypoint, name=f"waypoint {index}")
    if theta.ndim != 1:
        raise InputError(f"waypoint {index} must be one configuration ({arm.n},); got {theta.shape}")
    return theta


def solved(arm: Arm, target: TargetLike, near: Array, where: str, **options: Any) -> Array:
    """Solve for a target near a configuration (n,). Raises NotConvergedError, which names `where`."""
    solution = solve_ik(arm, target, near, **options)
    if not solution.converged:
        raise NotConvergedError(joined(": ", [where, in_one_line(solution)]), solution)
    return solution.theta


def _is_pose(waypoint: Any) -> bool:
    if isinstance(waypoint, str | Mapping) or waypoint is None:
        return False
    numbers = waypoint if isinstance(waypoint, np.ndarray) else as_reals(waypoint, "a waypoint")
    return numbers.shape == (4, 4)


def unwrapped(arm: Arm, theta: Array, near: Array, where: str, asked: bool) -> tuple[Array, list[str]]:
    """Return theta (n,) and notes. If `asked`, whole turns bring it nearest to `near` (n,) within the limits.

    It moves only joints that come back to the same place after a whole turn.
    """
    if (np.abs(theta - near) <= HALF_TURN).all():
        return theta, []
    nearest = joint_ranges(arm).wrapped(theta, near)
    shorter = np.abs(nearest - near) < np.minimum(np.abs(theta - near), HALF_TURN)
    notes: list[str] = []
    for j in np.flatnonzero(shorter & (np.abs(theta - near) > HALF_TURN)):
        unit = arm.units[j]
        given, chosen = Quantity(float(theta[j]), unit), Quantity(float(nearest[j]), unit)
        long, short = (Quantity(abs(float(value - near[j])), unit, 4) for value in (theta[j], nearest[j]))
        offered = Text("turns by {long}; {unwrap} makes that {short}", long=long, short=short, unwrap=UNWRAP)
        done = Text("goes to {chosen} in place of {given}, by whole turns", chosen=chosen, given=given)
        does = done if asked else offered
        notes.append(Text("{where}: joint {joint!r} {does}", where=where, joint=arm.joint_names[j], does=does))
    return np.where(shorter, nearest, theta) if asked else theta, notes


def as_times(times: ArrayLike, count: int) -> Array:
    """Return the times (k,) [s] of so many waypoints, which begin at 0 and increase."""
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


def distinct(points: Array) -> tuple[Array, Array, list[str]]:
    """Return waypoints (j, n) without repetitions, for each given one its index among them, and notes."""
    kept, owner = [0], [0]
    for i in range(1, len(points)):
        if np.abs(points[i] - points[kept[-1]]).max(initial=0.0) > MERGE_TOL:
            kept.append(i)
        owner.append(len(kept) - 1)
    kept[-1] = len(points) - 1  # the motion ends at the last waypoint exactly, even if it was merged
    merged = [str(i) for i in range(1, len(points)) if owner[i] == owner[i - 1]]
    which = ", ".join(merged[:MOST_NAMED]) + (", …" if len(merged) > MOST_NAMED else "")
    notes = [f"at the place of the waypoint before, and left out: {which} (0 is the start)"] if merged else []
    return points[kept], np.array(owner), notes


def smoothed(points: Array, most: float, limits: JointLimits) -> Array:
    """Return the smoothest waypoints (k, n) inside the limits that deviate by at most `most` [rad, m].

    Consecutive waypoints in a box of width `most` become its middle, so a stay is passed once. The cubic smoothing
    spline over the distances of the m middles y minimizes Σ |z_i − y_i|² + λ ∫ z''² ds. λ is the greatest that keeps
    `most`. The first and the last waypoint stay. Source: Green & Silverman, Nonparametric Regression and Generalized
    Linear Models, chapter 2.
    """
    box = _boxes(points, most)
    first = np.flatnonzero(np.diff(box, prepend=-1))
    low, high = (np.minimum.reduceat(points, first), np.maximum.reduceat(points, first))
    middles = 0.5 * (low + high)
    middles[0], middles[-1] = points[0], points[-1]
    if len(middles) < FEWEST:
        return middles[box]
    # A recording that begins or ends with a stay has two middles at one place, and s must increase.
    steps = np.maximum(np.linalg.norm(np.diff(middles, axis=0), axis=1), LEAST_STEP * most)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    s *= len(s) / s[-1]
    make, weight = scipy("interpolate").make_smoothing_spline, np.ones(len(s))
    weight[[0, -1]] = PINNED
    best, least, greatest = middles, -STIFFEST, STIFFEST
    for _ in range(BISECTIONS):
        exponent = 0.5 * (least + greatest)
        columns = [make(s, column, w=weight, lam=10.0**exponent)(s) for column in middles.T]
        z = np.clip(np.stack(columns, axis=1), limits.lower, limits.upper)
        z[[0, -1]] = middles[[0, -1]]
        if np.maximum(z - low, high - z)[1:-1].max() <= most:
            best, least = z, exponent
        else:
            greatest = exponent
    return best[box]


def _boxes(points: Array, width: float) -> NDArray[np.intp]:
    """Return the number of each waypoint's box (k,). The first and the last waypoint have one of their own."""
    numbers, low, high = np.zeros(len(points), dtype=np.intp), points[0], points[0]
    for i in range(1, len(points)):
        low, high = np.minimum(low, points[i]), np.maximum(high, points[i])
        new = i in (1, len(points) - 1) or bool((high - low > width).any())
        numbers[i] = numbers[i - 1] + new
        if new:
            low = high = points[i]
    return numbers
