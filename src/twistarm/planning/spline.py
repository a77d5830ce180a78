"""Piecewise polynomials through waypoints (k, n) at times (k,): splines, and profiles that rest at each waypoint.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np

from ..support.checks import Array
from ..support.errors import missing_extra


def cubic(waypoints: Array, times: Array) -> Array:
    """The C² cubic spline with zero velocity at both ends, (4, k − 1, n).

    Acceleration is continuous inside and starts and ends with a step. Lynch & Park §9.3 (via points).
    """
    try:
        from scipy.interpolate import CubicSpline
    except ImportError as error:
        raise missing_extra("planning", "SciPy", "plan") from error
    return np.asarray(CubicSpline(times, waypoints, bc_type="clamped").c)


def quintic(waypoints: Array, times: Array) -> Array:
    """The C⁴ quintic spline with zero velocity and acceleration at both ends, (6, k − 1, n).

    Of all paths through the waypoints at these times it has the least ∫ jerk² dt.
    """
    try:
        from scipy.interpolate import make_interp_spline
    except ImportError as error:
        raise missing_extra("planning", "SciPy", "plan") from error
    zero = np.zeros(waypoints.shape[1])
    rests: Any = ([(1, zero), (2, zero)], [(1, zero), (2, zero)])
    # From the first waypoint on: a joint that does not move then stays free of rounding.
    spline = make_interp_spline(times, waypoints - waypoints[0], k=5, bc_type=rests)
    coefficients = np.stack([spline(times[:-1], nu=power) / factorial(power) for power in range(5, -1, -1)])
    coefficients[-1] += waypoints[0]
    return coefficients


def cubic_rests(waypoints: Array, times: Array) -> Array:
    """Straight from waypoint to waypoint, x + (3 u² − 2 u³) Δx, velocity zero at each: (4, k − 1, n).

    u is the fraction of the segment's time (Lynch & Park §9.2.2.1).
    """
    return _straight(waypoints, times, (-2.0, 3.0, 0.0, 0.0))


def quintic_rests(waypoints: Array, times: Array) -> Array:
    """Straight from waypoint to waypoint, x + (10 u³ − 15 u⁴ + 6 u⁵) Δx: (6, k − 1, n).

    Velocity and acceleration are zero at each waypoint (Lynch & Park §9.2.2.1).
    """
    return _straight(waypoints, times, (6.0, -15.0, 10.0, 0.0, 0.0, 0.0))


def trapezoid(waypoints: Array, times: Array, ramps: Array) -> tuple[Array, Array]:
    """Straight from waypoint to waypoint with trapezoidal velocity; all joints ramp, coast and brake together.

    `ramps` (k − 1,) [s] is how long each segment accelerates, at most half of it; the fraction travelled then
    has speed 1 / (T − ramp) and acceleration speed / ramp (Lynch & Park §9.2.2.2). A segment is three pieces, or
    two where it does not coast. Returns breakpoints (p + 1,) and coefficients (3, p, n).
    """
    breakpoints, pieces = [times[:1]], []
    for i, (start, step) in enumerate(zip(waypoints[:-1], np.diff(waypoints, axis=0), strict=True)):
        inner, fractions = _ramp_coast_brake(times[i], times[i + 1], ramps[i])
        fractions = fractions[:, :, None] * step
        fractions[-1] += start
        breakpoints += [inner, times[i + 1 : i + 2]]
        pieces.append(fractions)
    return np.concatenate(breakpoints), np.concatenate(pieces, axis=1)


def _straight(waypoints: Array, times: Array, unit: tuple[float, ...]) -> Array:
    durations = np.diff(times)[:, None]
    powers = np.arange(len(unit) - 1, -1, -1.0)[:, None, None]
    coefficients: Array = np.array(unit)[:, None, None] / durations**powers * np.diff(waypoints, axis=0)
    coefficients[-1] += waypoints[:-1]
    return coefficients


COAST_TOL = 1e-12
"""A coast shorter than this part of its segment is a rounding of none."""


def _ramp_coast_brake(start: float, end: float, ramp: float) -> tuple[Array, Array]:
    """Times at which the phases change, and coefficients (3, 2 or 3) of the fraction travelled in each."""
    duration = end - start
    if duration - 2.0 * ramp <= COAST_TOL * duration:
        ramp = duration / 2.0
    speed = 1.0 / (duration - ramp)
    bend, ramped = speed / ramp / 2.0, speed * ramp / 2.0
    accelerate, coast, brake = (bend, 0.0, 0.0), (0.0, speed, ramped), (-bend, speed, 1.0 - ramped)
    if ramp == duration / 2.0:
        return np.array([start + ramp]), np.array([accelerate, brake]).T
    return np.array([start + ramp, end - ramp]), np.array([accelerate, coast, brake]).T
