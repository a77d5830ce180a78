"""Piecewise polynomials through waypoints (k, n) at times (k,): splines and rest-to-rest profiles.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np

from ..support.checks import Array
from ..support.errors import missing_extra
from .piecewise import rescaled, through


def scipy(part: str) -> Any:
    """The module of SciPy of that name, such as "linalg". Raises MissingExtraError without SciPy."""
    try:
        return import_module(f"scipy.{part}")
    except ImportError as error:
        raise missing_extra("planning", "SciPy", "plan") from error


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
    if len(waypoints) > 2:
        rates[:, 1:-1] = _smooth_rates(np.diff(waypoints, axis=0), np.diff(times))
    return through(times, waypoints, *rates)


def unforced_quintic(waypoints: Array, times: Array) -> Array:
    """The C⁴ quintic spline with free velocity and acceleration at both ends, (6, k − 1, n).

    Its third and fourth derivatives are zero at both ends.
    """
    way, durations = np.pad(np.diff(waypoints, axis=0), ((1, 1), (0, 0))), np.diff(times)
    # A segment of endless duration beyond each end has no jerk and no snap.
    rates = _smooth_rates(way, np.pad(durations, 1, constant_values=np.inf))
    return through(times, waypoints, *rates)


def _smooth_rates(way: Array, h: Array) -> Array:
    """Velocity and acceleration (2, k − 2, n) at the inner waypoints, where jerk and snap are continuous."""
    bands, given = _jerk_and_snap(way, h)
    solve = scipy("linalg").solve_banded
    solved: Array = solve((3, 3), bands, given, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return solved.reshape(len(h) - 1, 2, -1).swapaxes(0, 1)


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


def _straight(waypoints: Array, times: Array, unit: tuple[float, ...]) -> Array:
    coefficients = rescaled(np.array(unit)[:, None, None] * np.diff(waypoints, axis=0), 1.0 / np.diff(times))
    coefficients[-1] += waypoints[:-1]
    return coefficients
