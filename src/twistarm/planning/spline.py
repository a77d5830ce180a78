"""Piecewise polynomials through waypoints (k, n) at times (k,): splines, rest-to-rest profiles, and splines pulled in.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..limits.joint_limits import JointLimits
from ..support.checks import Array, frozen
from ..support.errors import missing_extra
from .piecewise import bernstein, derivative, evaluate, rescaled, through

EASING, LEAST_SHARE = 0.7, 0.05
"""Factor that lowers a joint's velocity at a waypoint until the joint stays inside; below such a share it is zero."""

ROUNDING = 1e-10
"""Beyond a limit by less [rad, m] is rounding."""

Mask = NDArray[np.bool_]


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


def cubic_not_forced(waypoints: Array, times: Array, ends: str) -> Array:
    """The C² cubic spline with free velocities at both ends, (4, k − 1, n).

    At the `ends` the second derivative is 0 ("natural"), or the third is continuous nearby ("not-a-knot").
    """
    # From the first waypoint on: a joint that does not move then stays free of rounding.
    coefficients = np.array(scipy("interpolate").CubicSpline(times, waypoints - waypoints[0], bc_type=ends).c)
    coefficients[-1] += waypoints[0]
    return coefficients


def natural(waypoints: Array, s: Array, degree: int) -> tuple[Array, Array]:
    """Breakpoints and coefficients of a spline of odd degree d with d − 1 continuous derivatives, k ≥ (d + 1)/2.

    The derivatives (d + 1)/2 … d − 1 are zero at both ends. The knots are not at the waypoints, but at the means of d
    consecutive s. At even spacing both agree inside. A piece is then never as short as the way between two very near
    waypoints, where the highest derivative would have to change by much. Source: de Boor, A Practical Guide to Splines,
    chapter XIII.
    """
    free = degree // 2
    sites = np.pad(s, free, mode="edge")
    inner = np.lib.stride_tricks.sliding_window_view(sites, degree).mean(axis=1)[1:-1]
    knots = np.concatenate([np.repeat(s[0], degree + 1), inner, np.repeat(s[-1], degree + 1)])
    ends = [(order, np.zeros(waypoints.shape[1])) for order in range(free + 1, degree)]
    make = scipy("interpolate").make_interp_spline
    # From the first waypoint on: a joint that does not move then stays free of rounding.
    spline = make(s, waypoints - waypoints[0], k=degree, t=knots, bc_type=(ends, ends))
    breakpoints = knots[degree:-degree]
    coefficients = [spline(breakpoints[:-1], order) / factorial(order) for order in range(degree, -1, -1)]
    coefficients[-1] += waypoints[0]
    return breakpoints, np.stack(coefficients)


def quintic(waypoints: Array, times: Array) -> Array:
    """The C⁴ quintic spline with zero velocity and acceleration at both ends, (6, k − 1, n).

    Of all paths through the waypoints at these times it has the least ∫ jerk² dt. The unknowns are velocity and
    acceleration at each inner waypoint. Continuous jerk and snap give a banded system of equations.
    """
    rates = np.zeros((2, *waypoints.shape))
    if len(waypoints) > 2:
        rates[:, 1:-1] = _smooth_rates(np.diff(waypoints, axis=0), np.diff(times))
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


def pulled_in(coefficients: Array, times: Array, waypoints: Array, limits: JointLimits) -> tuple[Array, Array]:
    """Breakpoints and coefficients of a spline (d + 1, k − 1, n) through waypoints (k, n), inside the limits.

    A spline inside them comes back unchanged. Where a joint leaves them, its velocity at the nearer waypoint is scaled
    by μ, and its derivative of order r by μ^r. In the middle both waypoints count. A segment becomes d equal pieces
    with d − 1 continuous derivatives and the same ends. So the motion stays as smooth as the spline. μ = 1 at both ends
    gives the spline again. μ = 0 gives monotone pieces, the integral of a B-spline of degree d − 1. So some μ always
    keeps inside. The check is on the Bernstein coefficients of the pieces.

    Source: de Boor, A Practical Guide to Splines, chapters IX and XI.
    """
    durations, (degree, k, n) = np.diff(times), (len(coefficients) - 1, *waypoints.shape)
    lower, upper = np.minimum(limits.lower, waypoints.min(0)), np.maximum(limits.upper, waypoints.max(0))
    if not outside(bernstein(coefficients, durations), lower, upper).any():
        return times, coefficients
    states, share = _states(coefficients, durations), np.ones((k, n))
    while True:
        pieces = _pieces(states, share, waypoints, durations)
        hull = bernstein(pieces.reshape(degree + 1, -1, n), np.repeat(durations / degree, degree))
        out = outside(hull, lower, upper).reshape(k - 1, degree, n)
        left, right = out[:, : degree // 2 + 1].any(1), out[:, degree // 2 :].any(1)
        left, right = left | (right & (share[1:] == 0.0)), right | (left & (share[:-1] == 0.0))
        ends = np.zeros((k, n), dtype=bool)
        ends[:-1] |= left
        ends[1:] |= right
        if not (ends & (share > 0.0)).any():
            break
        eased = np.where(share * EASING < LEAST_SHARE, 0.0, share * EASING)
        share = np.where(ends, eased, share)
    whole = (share == 1.0).all(-1)
    whole = whole[:-1] & whole[1:]
    pieces[:, whole, 0] = coefficients[:, whole]
    kept = np.ones((k - 1, degree), dtype=bool)
    kept[whole, 1:] = False
    starts = times[:-1, None] + durations[:, None] * (np.arange(degree) / degree)
    return np.append(starts[kept], times[-1]), pieces[:, kept]


def outside(values: Array, lower: Array, upper: Array) -> Mask:
    """Tell which pieces (s, n) have a value (c, s, n) beyond the limits (n,), by more than rounding."""
    return (values.min(0) < lower - ROUNDING) | (values.max(0) > upper + ROUNDING)


def _states(coefficients: Array, durations: Array) -> Array:
    """Return derivatives of order 1 … d − 1 of a spline at its waypoints, (d − 1, k, n)."""
    degree = len(coefficients) - 1
    rows = []
    for order in range(1, degree):
        slope = derivative(coefficients, order)
        rows.append(np.concatenate([slope[-1], evaluate(slope[:, -1:], durations[-1:, None])]))
    return np.stack(rows)


def _pieces(states: Array, share: Array, waypoints: Array, durations: Array) -> Array:
    """Coefficients (d + 1, k − 1, d, n) of segments in d pieces. Shares (k, n) scale the waypoints' derivatives."""
    orders = np.arange(1, len(states) + 1)[:, None, None]
    eased, T = states * share**orders, durations[:, None] ** orders
    way = np.diff(waypoints, axis=0)[None]
    ends = np.concatenate([np.zeros(way.shape), eased[:, :-1] * T, way, eased[:, 1:] * T])
    degree = len(states) + 1
    unit = np.einsum("cpe,esn->cspn", _smooth_step(degree), ends)
    unit[-1] += waypoints[:-1, None]
    return rescaled(unit, 1.0 / durations)


@cache
def _smooth_step(degree: int) -> Array:
    """Return (d + 1, d, 2 d): the spline of d equal pieces with given derivatives at both ends.

    Columns are the derivatives of order 0 … d − 1 at 0, then those at 1.
    """
    knots = np.concatenate([np.zeros(degree), np.linspace(0.0, 1.0, degree + 1), np.ones(degree)])
    unit, starts = np.eye(2 * degree), knots[degree : 2 * degree]
    ends = [[(order, unit[first + order]) for order in range(1, degree)] for first in (0, degree)]
    make = scipy("interpolate").make_interp_spline
    step = make([0.0, 1.0], unit[[0, degree]], k=degree, t=knots, bc_type=tuple(ends))
    return frozen([step(starts, order) / factorial(order) for order in range(degree, -1, -1)])
