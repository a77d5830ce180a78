"""Splines pulled in: the same waypoints and times, inside the position limits in between."""

from __future__ import annotations

from functools import cache
from math import factorial

import numpy as np
from numpy.typing import NDArray

from ..limits.joint_limits import JointLimits
from ..support.checks import Array, frozen
from .piecewise import bernstein, derivative, evaluate, rescaled
from .spline import scipy

ROUNDING = 1e-10
"""Beyond a limit by less [rad, m] is rounding."""

EASING = 0.7
"""Factor that lowers a joint's velocity at a waypoint, repeatedly, until the joint stays inside."""

LEAST_SHARE = 0.05
"""A velocity lowered to less than this part of it is zero."""

Mask = NDArray[np.bool_]


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
    if not _outside(bernstein(coefficients, durations), lower, upper).any():
        return times, coefficients
    states, share = _states(coefficients, durations), np.ones((k, n))
    while True:
        pieces = _pieces(states, share, waypoints, durations)
        hull = bernstein(pieces.reshape(degree + 1, -1, n), np.repeat(durations / degree, degree))
        out = _outside(hull, lower, upper).reshape(k - 1, degree, n)
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


def _outside(values: Array, lower: Array, upper: Array) -> Mask:
    """Tell which pieces (s, n) have a value (c, s, n) beyond the limits (n,)."""
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
