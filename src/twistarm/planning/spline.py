"""Piecewise polynomials through waypoints (k, n) at times (k,): splines and rest-to-rest profiles.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

import numpy as np

from ..support.checks import Array
from .optional import scipy
from .piecewise import rescaled, through


def cubic(waypoints: Array, times: Array) -> Array:
    """The C² cubic spline with zero velocity at both ends, (4, k − 1, n).

    Acceleration is continuous inside and starts and ends with a step. Lynch & Park §9.3 (via points).
    """
    return np.asarray(scipy("interpolate").CubicSpline(times, waypoints, bc_type="clamped").c)


def unforced(waypoints: Array, times: Array, ends: str = "natural") -> Array:
    """The C² cubic spline with free velocities at both ends, (4, k − 1, n).

    At the `ends` the second derivative is 0 ("natural"), or the third is continuous nearby ("not-a-knot").
    """
    # From the first waypoint on: a joint that does not move then stays free of rounding.
    coefficients = np.array(scipy("interpolate").CubicSpline(times, waypoints - waypoints[0], bc_type=ends).c)
    coefficients[-1] += waypoints[0]
    return coefficients


def quintic(waypoints: Array, times: Array) -> Array:
    """The C⁴ quintic spline with zero velocity and acceleration at both ends, (6, k − 1, n).

    Of all paths through the waypoints at these times it has the least ∫ jerk² dt. The unknowns are velocity and
    acceleration at each inner waypoint. Continuous jerk and snap give a banded system of equations.
    """
    rates = np.zeros((2, *waypoints.shape))
    inner = len(waypoints) - 2
    if inner > 0:
        bands, given = _jerk_and_snap(np.diff(waypoints, axis=0), np.diff(times))
        solve = scipy("linalg").solve_banded
        solved = solve((3, 3), bands, given, overwrite_ab=True, overwrite_b=True, check_finite=False)
        rates[:, 1:-1] = solved.reshape(inner, 2, -1).swapaxes(0, 1)
    return through(times, waypoints, *rates)


def _jerk_and_snap(way: Array, h: Array) -> tuple[Array, Array]:
    """Bands (7, 2 k − 4) and right side (2 k − 4, n) of the equations for v_1, a_1, v_2, a_2, …

    At each inner waypoint the jerk and the snap of both segments agree.
    """
    before, after = h[:-1], h[1:]
    # Each equation is divided by the size of its terms, because segment lengths may differ by orders of magnitude.
    size = (1.0 / before + 1.0 / after) ** np.array([[2.0], [3.0]])
    L2, R2, L3, R3 = 1.0 / before**2, 1.0 / after**2, 1.0 / before**3, 1.0 / after**3
    terms = {
        # (equation, unknown counted from v_i): the coefficient
        (0, -2): 24.0 * L2, (0, -1): 3.0 / before, (0, 0): 36.0 * (L2 - R2), (0, 1): -9.0 / before - 9.0 / after,
        (0, 2): -24.0 * R2, (0, 3): 3.0 / after,
        (1, -2): 168.0 * L3, (1, -1): 24.0 * L2, (1, 0): 192.0 * (L3 + R3), (1, 1): 36.0 * (R2 - L2),
        (1, 2): 168.0 * R3, (1, 3): -24.0 * R2,
    }  # fmt: skip
    count = 2 * len(before)
    bands = np.zeros((7, count + 5))
    for (equation, unknown), coefficient in terms.items():
        bands[equation - unknown + 3, unknown + 2 : unknown + 2 + count : 2] = coefficient / size[equation]
    left, right = way[:-1], way[1:]
    jerk = 60.0 * (left * L3[:, None] - right * R3[:, None])
    snap = 360.0 * (left * L2[:, None] ** 2 + right * R2[:, None] ** 2)
    given = np.stack([jerk / size[0][:, None], snap / size[1][:, None]], axis=1)
    return bands[:, 2 : count + 2], given.reshape(count, -1)


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

    `ramps` (k − 1,) [s] is how long each segment accelerates, at most half of it. The fraction travelled then has speed
    1 / (T − ramp) and acceleration speed / ramp (Lynch & Park §9.2.2.2). A segment is three pieces, or two where it
    does not coast. Returns breakpoints (p + 1,) and coefficients (3, p, n).
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
    coefficients = rescaled(np.array(unit)[:, None, None] * np.diff(waypoints, axis=0), 1.0 / np.diff(times))
    coefficients[-1] += waypoints[:-1]
    return coefficients


COAST_TOL = 1e-15
"""A coast shorter than this share of the time at its end is a rounding error."""


def _ramp_coast_brake(start: float, end: float, ramp: float) -> tuple[Array, Array]:
    """Times at which the phases change, and coefficients (3, 2 or 3) of the fraction travelled in each."""
    duration = end - start
    if duration - 2.0 * ramp <= COAST_TOL * end:
        ramp = duration / 2.0
    speed = 1.0 / (duration - ramp)
    bend, ramped = speed / ramp / 2.0, speed * ramp / 2.0
    accelerate, coast, brake = (bend, 0.0, 0.0), (0.0, speed, ramped), (-bend, speed, 1.0 - ramped)
    if ramp == duration / 2.0:
        return np.array([start + ramp]), np.array([accelerate, brake]).T
    return np.array([start + ramp, end - ramp]), np.array([accelerate, coast, brake]).T
