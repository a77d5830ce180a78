"""Piecewise polynomials through waypoints (k, n) at times (k,): splines, rest-to-rest profiles, and splines pulled in.

Coefficients are laid out as in `piecewise`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from importlib import import_module
from math import factorial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..limits.joint_limits import JointLimits
from ..support.checks import Array, frozen
from ..support.errors import missing_extra
from .piecewise import bernstein, derivative, evaluate, rescaled

# Factor that lowers a joint's velocity at a waypoint until the joint stays inside; below such a share it is zero.
EASING, LEAST_SHARE = 0.7, 0.05
ROUNDING = 1e-10  # Beyond a limit by less [rad, m] is rounding.
# The orders of the derivatives that are zero at both ends, and the step from 0 to 1 at rest, highest power first.
KINDS = {"cubic": ((1,), (-2.0, 3.0, 0.0, 0.0)), "quintic": ((1, 2), (6.0, -15.0, 10.0, 0.0, 0.0, 0.0))}

Mask = NDArray[np.bool_]


def scipy(part: str) -> Any:
    """The module of SciPy of that name, such as "linalg". Raises MissingExtraError without SciPy."""
    try:
        return import_module(f"scipy.{part}")
    except ImportError as error:
        raise missing_extra("planning", "SciPy", "plan") from error


def at_times(kind: str, waypoints: Array, times: Array, stop: bool) -> Array:
    """The spline of a kind of `KINDS`, (d + 1, k − 1, n), at rest at both ends.

    The cubic is C²: its acceleration starts and ends with a step (Lynch & Park §9.3). The quintic is C⁴ and has zero
    acceleration at both ends. Of all paths through the waypoints at these times it has the least ∫ jerk² dt.

    With `stop` it goes straight and rests at each waypoint. The cubic is x + (3 u² − 2 u³) Δx. The quintic is x + (10
    u³ − 15 u⁴ + 6 u⁵) Δx, with zero acceleration there. u is the fraction of the segment's time (Lynch & Park §9.2.2).
    """
    zero, step = KINDS[kind]
    if not stop:
        return interpolating(waypoints, times, times[1:-1], zero)[1]
    coefficients = rescaled(np.array(step)[:, None, None] * np.diff(waypoints, axis=0), 1.0 / np.diff(times))
    coefficients[-1] += waypoints[:-1]
    return coefficients


def natural(waypoints: Array, s: Array, degree: int) -> tuple[Array, Array]:
    """Breakpoints and coefficients of a spline of odd degree d with d − 1 continuous derivatives, k ≥ (d + 1)/2.

    The derivatives (d + 1)/2 … d − 1 are zero at both ends. The knots are not at the waypoints, but at the means of d
    consecutive s. At even spacing both agree inside. A piece is then never as short as the way between two very near
    waypoints. The highest derivative would have to change by much there.
    """
    sites = np.pad(s, degree // 2, mode="edge")
    knots = np.lib.stride_tricks.sliding_window_view(sites, degree).mean(axis=1)[1:-1]
    return interpolating(waypoints, s, knots, range(degree // 2 + 1, degree))


def interpolating(waypoints: Array, s: Array, knots: Array, zero: Sequence[int]) -> tuple[Array, Array]:
    """A spline with m inner knots through waypoints (k, n) at s (k,): breakpoints, and coefficients (d + 1, m + 1, n).

    The derivatives of the orders `zero` are zero at both ends. The numbers of knots and conditions make the degree d:
    m + d + 1 = k + 2 · their number. Source: de Boor, A Practical Guide to Splines, chapter XIII.
    """
    degree = len(s) + 2 * len(zero) - len(knots) - 1
    padded = np.concatenate([np.repeat(s[0], degree + 1), knots, np.repeat(s[-1], degree + 1)])
    ends = [(order, np.zeros(waypoints.shape[1])) for order in zero]
    make = scipy("interpolate").make_interp_spline
    # From the first waypoint on: a joint that does not move then stays free of rounding.
    spline = make(s, waypoints - waypoints[0], k=degree, t=padded, bc_type=(ends or None, ends or None))
    breakpoints = padded[degree : len(padded) - degree]
    coefficients = np.stack([spline(breakpoints[:-1], order) / factorial(order) for order in range(degree, -1, -1)])
    coefficients[-1] += waypoints[0]
    return breakpoints, coefficients


def pulled_in(coefficients: Array, times: Array, waypoints: Array, limits: JointLimits) -> tuple[Array, Array]:
    """Breakpoints and coefficients of a spline (d + 1, k − 1, n) through waypoints (k, n), inside the limits.

    A spline inside them comes back unchanged. Where a joint leaves them, its velocity at the nearer waypoint is scaled
    by μ. Its derivative of order r is scaled by μ^r. In the middle both waypoints count. A segment becomes d equal
    pieces with d − 1 continuous derivatives and the same ends. So the motion stays as smooth as the spline. μ = 1 at
    both ends gives the spline again. μ = 0 gives monotone pieces, the integral of a B-spline of degree d − 1. So some μ
    always keeps inside. The check is on the Bernstein coefficients of the pieces.

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
    pieces[:, whole, 0] = coefficients[:, whole]  # a segment that nothing pulled in stays one piece
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
