"""Limits of joints, checked at the exact extremes of a motion, limits of its duration, and their errors."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError, LimitError
from ..support.messages import Argument, Quantity, Remedies, Text, joined
from ..support.units import theta_hint
from .piecewise import derivative, extremes, largest
from .trajectory import RATE_UNITS, Trajectory

# Excess over a position limit [rad, m] that is rounding of a motion that ends on the limit.
POSITION_TOL = 1e-9
# How far beyond a position limit [rad, m] a given configuration, or that of a file, counts as on the limit.
GIVEN_TOL = 1e-6
# How far beyond its limits a measured start may be. The motion then returns inside first.
RETURN = {"rad": 0.2, "m": 0.02}
RATE_TOL = 1e-9  # Relative excess over a rate limit that is rounding of a motion timed to meet it exactly.
MARGIN = 1e-10  # Times exceed the limits' least times by this share, so that rounding falls on the safe side.
SHORTEST, LONGEST = 1e-9, 1e9  # Lengths [s] of motions whose coefficients keep clear of overflow.

RATES = ("velocity", "acceleration", "jerk")


def stretch_needed(coefficients: Array, durations: Array, limits: JointLimits) -> Array:
    """Return the factor (s,) by which each segment must be slowed; 1 just meets a limit.

    A motion slowed by `f` has 1/f of the velocity, 1/f² of the acceleration, 1/f³ of the jerk.
    """
    worst = np.zeros(len(durations))
    for order, limit in _limited(limits):
        _, values = extremes(derivative(coefficients, order), durations)
        worst = np.maximum(worst, (np.abs(values).max(0) / limit).max(-1) ** (1.0 / order))
    return worst


def slowed_by(coefficients: Array, durations: Array, limits: JointLimits) -> float:
    """Return the largest `stretch_needed` of all segments, to 1e-10, looking closely at few of them."""
    used = (
        largest(derivative(coefficients, order) / limit, durations) ** (1.0 / order)
        for order, limit in _limited(limits)
    )
    return max(used, default=0.0)


def _limited(limits: JointLimits) -> Iterator[tuple[int, Array]]:
    """Yield order and limit (n,) of each rate that any joint limits."""
    for order, rate in enumerate(RATES, 1):
        limit: Array = getattr(limits, rate)
        if np.isfinite(limit).any():
            yield order, limit


def farthest_outside(theta: Array, limits: JointLimits) -> tuple[tuple[int, ...], float, str]:
    """Where theta (..., n) is farthest beyond a position limit, by how much [rad, m], and the side."""
    beyond = np.maximum(limits.lower - theta, theta - limits.upper)
    at = tuple(int(index) for index in np.unravel_index(np.argmax(beyond), beyond.shape))
    return at, float(beyond[at]), "lower" if theta[at] < limits.lower[at[-1]] else "upper"


def require_within(trajectory: Trajectory, limits: JointLimits, advice: str = "plan it again") -> None:
    """Raise LimitError naming joint, limit, value and time where `trajectory` leaves `limits`.

    `advice` tells a user what to do about an excursion beyond a position limit. Only motions planned elsewhere have
    one.
    """
    require_positions(trajectory, limits, advice)
    require_rates(trajectory, limits)


def require_positions(
    trajectory: Trajectory, limits: JointLimits, advice: str, tolerance: float = POSITION_TOL
) -> None:
    """Raise LimitError where `trajectory` leaves the position limits by more than the tolerance [rad, m]."""
    tau, values = extremes(trajectory.coefficients, np.diff(trajectory.breakpoints))
    (c, s, j), beyond, side = farthest_outside(values, limits)
    if beyond > tolerance:
        unit, time = trajectory.units[j], trajectory.breakpoints[s] + tau[c, s, j]
        raise LimitError(
            Text(
                "between its waypoints joint {joint!r} would swing to {value} at t = {time:.4g} s, {beyond} beyond its "
                "{side} limit {limit}: {advice}",
                joint=trajectory.joint_names[j],
                value=Quantity(values[c, s, j], unit),
                time=time,
                beyond=Quantity(beyond, unit),
                side=side,
                limit=Quantity(getattr(limits, side)[j], unit),
                advice=advice,
            )
        )


def require_rates(trajectory: Trajectory, limits: JointLimits, moved: str = "joint") -> None:
    """Raise LimitError with joint, limit, value and time if a rate of `trajectory` is too high.

    `moved` is the word for what moves: "motor" for a `Trajectory.to_motors`.
    """
    durations = np.diff(trajectory.breakpoints)
    for order, limit in _limited(limits):
        tau, values = extremes(derivative(trajectory.coefficients, order), durations)
        ratio = np.abs(values) / limit
        c, s, j = np.unravel_index(np.argmax(ratio), ratio.shape)
        if ratio[c, s, j] <= 1.0 + RATE_TOL:
            continue
        unit, time = trajectory.units[j] + RATE_UNITS[order], trajectory.breakpoints[s] + tau[c, s, j]
        factor = stretch_needed(trajectory.coefficients, durations, limits).max()
        raise LimitError(
            Text(
                "{moved} {joint!r} would need {value} at t = {time:.4g} s; its {rate} limit is {limit}: multiply times "
                "by {factor:.4g}, or leave times out",
                moved=moved,
                joint=trajectory.joint_names[j],
                value=Quantity(abs(values[c, s, j]), unit),
                time=time,
                rate=RATES[order - 1],
                limit=Quantity(limit[j], unit),
                factor=factor * (1 + 5e-4),
            )
        )


def on_limits(
    waypoints: Array, limits: JointLimits, names: Sequence[str], units: Sequence[str], what: str = ""
) -> Array:
    """Return waypoints (k, n), on the limit where they are beyond it by rounding.

    Raises LimitError with waypoint (or `what`), joint and limit, where one is outside.
    """
    (i, j), beyond, side = farthest_outside(waypoints, limits)
    if beyond > GIVEN_TOL:
        remedy = "move the waypoint"
        where = what or f"waypoint {i} (0 is the start)"
        raise _beyond(waypoints[i], j, side, limits, names, units, where, remedy)
    return np.clip(waypoints, limits.lower, limits.upper)


def inside_from(
    start: Array, limits: JointLimits, names: Sequence[str], units: Sequence[str]
) -> tuple[Array, list[Text]]:
    """Return where a motion from a measured start (n,) is inside the limits. A note says if it returns there first.

    Raises LimitError if a joint is farther beyond its limit than `RETURN`.
    """
    inside = np.clip(start, limits.lower, limits.upper)
    beyond = np.abs(start - inside)
    allowed = np.array([RETURN[unit] for unit in units])
    j = int(np.argmax(beyond / allowed))
    if beyond[j] > allowed[j]:
        most, side = Quantity(RETURN[units[j]], units[j]), "lower" if start[j] < inside[j] else "upper"
        remedy = Text(
            "a motion returns by itself from at most {most} beyond; bring the joint nearer by hand", most=most
        )
        raise _beyond(start, j, side, limits, names, units, "the start", remedy)
    out = np.flatnonzero(beyond > GIVEN_TOL).tolist()
    excesses = [Text("{joint} by {beyond}", joint=names[k], beyond=Quantity(float(beyond[k]), units[k])) for k in out]
    template = "the start is beyond the limits, {excesses}: the motion first returns inside, straight in joint space"
    return inside, [Text(template, excesses=joined(", ", excesses))] if excesses else []


def returning(limits: JointLimits, start: Array, units: Sequence[str]) -> JointLimits:
    """Return the limits of positions that a motion from `start` (n,) keeps to: from beyond it may return."""
    near = np.array([RETURN[unit] for unit in units])
    lower = np.minimum(limits.lower, np.maximum(start, limits.lower - near)) - GIVEN_TOL
    upper = np.maximum(limits.upper, np.minimum(start, limits.upper + near)) + GIVEN_TOL
    return replace(limits, lower=lower, upper=upper)


def _beyond(
    theta: Array, j: int, side: str, limits: JointLimits, names: Sequence[str], units: Sequence[str], what: str,
    remedy: str | Text,
) -> LimitError:  # fmt: skip
    """The error for joint j of theta (n,), which is beyond its limit on this side."""
    limit, hint = getattr(limits, side)[j], theta_hint(theta[None], units, limits.lower, limits.upper)
    return LimitError(
        Text(
            "{what} puts joint {joint!r} at {value}, {beyond} beyond its {side} limit {limit}: {remedies}{hint}",
            what=what,
            joint=names[j],
            value=Quantity(theta[j], units[j]),
            beyond=Quantity(abs(float(theta[j] - limit)), units[j]),
            side=side,
            limit=Quantity(limit, units[j]),
            remedies=Remedies(
                (remedy, Text("correct the limit by {limits} if the robot goes farther", limits=Argument("limits")))
            ),
            hint=Text(" ({hint})", hint=hint) if hint else "",
        )
    )


def require_span(duration: float) -> None:
    """Raise InputError where a motion of this duration [s] is too short or too long."""
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(
            f"this path and these limits make a motion of {duration:.3g} s; {SHORTEST:g} s to {LONGEST:g} s can be "
            "planned: check the units of both"
        )
