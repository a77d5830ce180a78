"""Piecewise polynomials of many joints: values, derivatives, extremes, and polynomials through given states.

Coefficients are (degree + 1, segments, n), highest power first. Time counts from the segment's start [s]. SciPy's
`PPoly` has the same layout.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from math import comb

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array, frozen

BISECTIONS = 30
"""An extreme located to 2⁻³⁰ of its segment has its value to 2⁻⁶⁰: the slope there is zero."""


def derivative(coefficients: Array, order: int = 1) -> Array:
    """Return the coefficients of that derivative; a zero polynomial keeps one row of zeros."""
    for _ in range(order):
        powers = np.arange(len(coefficients) - 1, 0, -1.0)
        lowered = coefficients[:-1] * powers[:, None, None]
        coefficients = lowered if len(lowered) else np.zeros((1, *coefficients.shape[1:]))
    return coefficients


def evaluate(coefficients: Array, tau: Array) -> Array:
    """Return Σ c_k tau^(degree − k) by Horner's rule. tau [s] counts from the segment's start and broadcasts against
    c_k.
    """
    value: Array = coefficients[0] + 0.0 * tau
    for row in coefficients[1:]:
        value = value * tau + row
    return value


def rescaled(coefficients: Array, unit: float | Array) -> Array:
    """p(unit · u) of polynomials (d + 1, ...), with one unit, or one per piece (s,)."""
    powers = np.arange(len(coefficients) - 1, -1, -1.0)
    factors = np.asarray(unit) ** powers.reshape(-1, *[1] * np.ndim(unit))
    return coefficients * factors.reshape(*factors.shape, *[1] * (coefficients.ndim - factors.ndim))


def spread(count: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """For `count` (s,) places in each piece: the piece of each place, and its number there."""
    piece = np.repeat(np.arange(len(count)), count)
    return piece, np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)


def bisected(before: Callable[[Array], NDArray[np.bool_]], low: Array, high: Array, steps: int) -> tuple[Array, Array]:
    """Halve intervals that often. `before` tells for each middle whether the place that you look for comes later."""
    for _ in range(steps):
        middle = 0.5 * (low + high)
        later = before(middle)
        low, high = np.where(later, middle, low), np.where(later, high, middle)
    return low, high


def side_by_side(pieces: Sequence[Array]) -> Array:
    """Join pieces one after the other, with the highest degree among them."""
    degree = max(map(len, pieces))
    return np.concatenate([np.pad(each, ((degree - len(each), 0), (0, 0), (0, 0))) for each in pieces], axis=1)


def composed(outer: Array, inner: Array) -> Array:
    """Return the coefficients (d e + 1, k, n) of outer(inner(t)) for (d + 1, k, n) and (e + 1, k)."""
    result = outer[:1]
    for row in outer[1:]:
        product = np.zeros((len(result) + len(inner) - 1, *outer.shape[1:]))
        for i, factor in enumerate(inner):
            product[i : i + len(result)] += factor[:, None] * result
        product[-1] += row
        result = product
    return result


def shifted(coefficients: Array, by: Array) -> Array:
    """Return the same polynomials from `by` (s,) [s] after each segment's start: p(tau + by)."""
    binomials, powers = _binomials(len(coefficients) - 1)
    moved = binomials[:, :, None] * by ** powers[:, :, None]
    return np.einsum("kps,ps...->ks...", moved, coefficients)


@cache
def _binomials(degree: int) -> tuple[Array, Array]:
    """The factor and the power of `by` for each coefficient (column) of each shifted one (row)."""
    down = np.arange(degree, -1, -1)
    binomials = [[float(comb(p, k)) for p in down] for k in down]
    return frozen(binomials), frozen(np.maximum(down[None, :] - down[:, None], 0))


def extremes(coefficients: Array, durations: Array) -> tuple[Array, Array]:
    """Times tau (c, s, n) [s] since each segment's start that include every extreme, and their values.

    The candidates are both ends and the zeros of the derivative. These lie between the zeros of the next derivative,
    and so on up to the linear one. The polynomial is monotone between those, so bisection cannot fail. Without a zero,
    the candidate falls harmlessly on an interval's end.
    """
    tau = _edges(derivative(rescaled(coefficients, durations))) * durations[:, None]
    return tau, evaluate(coefficients, tau)


def _edges(slope: Array) -> Array:
    """Return 0, the zeros of `slope` in [0, 1] in order, and 1: (degree + 2, s, n)."""
    ends = np.zeros((1, *slope.shape[1:])), np.ones((1, *slope.shape[1:]))
    if len(slope) == 1:
        return np.concatenate(ends)
    inner = _edges(derivative(slope))
    rising: NDArray[np.bool_] = evaluate(slope, inner[:-1]) < evaluate(slope, inner[1:])
    low, high = bisected(lambda at: (evaluate(slope, at) < 0) == rising, inner[:-1], inner[1:], BISECTIONS)
    return np.concatenate([ends[0], 0.5 * (low + high), ends[1]])


def through(t: Array, theta: Array, theta_dot: Array | None = None, theta_ddot: Array | None = None) -> Array:
    """Return coefficients (degree + 1, k − 1, n) through states (k, n) at t (k,) [s].

    Positions alone give straight lines, rates too give cubics, accelerations too give quintics. Each piece meets the
    given states at both ends, exactly at its start.
    """
    h = np.diff(t)[:, None]
    a, way = theta[:-1], np.diff(theta, axis=0)
    if theta_dot is None:
        return np.stack([way / h, a])
    u = theta_dot[:-1]
    if theta_ddot is None:
        way, faster = way - u * h, np.diff(theta_dot, axis=0)
        return np.stack([(faster * h - 2.0 * way) / h**3, (3.0 * way - faster * h) / h**2, u, a])
    half = 0.5 * theta_ddot[:-1]
    way = way - (u + half * h) * h
    faster = (np.diff(theta_dot, axis=0) - 2.0 * half * h) * h
    bent = 0.5 * np.diff(theta_ddot, axis=0) * h**2
    fifth, fourth = (6.0 * way - 3.0 * faster + bent) / h**5, (-15.0 * way + 7.0 * faster - 2.0 * bent) / h**4
    return np.stack([fifth, fourth, (10.0 * way - 4.0 * faster + bent) / h**3, half, u, a])
