"""Piecewise polynomials of many joints: values, derivatives, extremes, bounds, given states; and paths without time.

Coefficients are (degree + 1, segments, n), highest power first. Time counts from the segment's start [s]. SciPy's
`PPoly` has the same layout.

Bernstein coefficients bound a polynomial without samples. On σ in [0, 1], p(σ) = Σ b_k C(d, k) σ^k (1 − σ)^(d−k) lies
between the least and the largest b_k. It starts at b_0 and ends at b_d. Source: Farin, Curves and Surfaces for CAGD,
chapters 4 and 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..support.checks import Array, frozen

Indices = NDArray[np.intp]

BISECTIONS = 30  # An extreme located to 2⁻³⁰ of its segment has its value to 2⁻⁶⁰: the slope there is zero.
PRECISION = 1e-10  # How near, relatively, a bound comes to the largest magnitude that it bounds.
ROUNDING = 1e-9  # A piece may exceed its greatest length by this share before it is cut again.
# A joint that moves by less [rad, m] stays where it is, and so does a cut nearer to a breakpoint by such a share.
STILL = 1e-12


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
    value: Array = coefficients[0] + 0.0 * tau  # so a constant has the shape of tau too
    for row in coefficients[1:]:
        value = value * tau + row
    return value


def rescaled(coefficients: Array, unit: float | Array) -> Array:
    """p(unit · u) of polynomials (d + 1, ...), with one unit, or one per piece (s,)."""
    powers = np.arange(len(coefficients) - 1, -1, -1.0)
    factors = np.asarray(unit) ** powers.reshape(-1, *[1] * np.ndim(unit))
    return coefficients * factors.reshape(*factors.shape, *[1] * (coefficients.ndim - factors.ndim))


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
    return np.concatenate([np.pad(piece, ((degree - len(piece), 0), (0, 0), (0, 0))) for piece in pieces], axis=1)


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


def bernstein(coefficients: Array, durations: Array) -> Array:
    """Return Bernstein coefficients (d + 1, k, ...) of polynomials (d + 1, k, ...) on k pieces of durations (k,)."""
    return np.tensordot(_from_powers(len(coefficients) - 1), rescaled(coefficients, durations), 1)


def largest(coefficients: Array, durations: Array) -> float:
    """Return an upper bound of max |p(σ)| of polynomials (d + 1, k, r) on k pieces.

    Branch and bound halves pieces (de Casteljau) with coefficients above the largest value seen. It ends when the bound
    is within 1e-10 of a value. Pieces with powers that add up to less than a value at an end need no such look.
    """
    powers = rescaled(coefficients, durations).reshape(len(coefficients), -1)
    greatest = max(float(np.abs(ends).max()) for ends in (powers[-1], powers.sum(axis=0)))
    powers = powers[:, np.abs(powers).sum(axis=0) > greatest * (1.0 + PRECISION)]
    b = powers.T @ _from_powers(len(coefficients) - 1).T
    while len(b):
        greatest = max(greatest, float(np.abs(b[:, [0, -1]]).max()))
        above = np.abs(b).max(-1) > greatest * (1.0 + PRECISION)
        if not above.any():
            return greatest * (1.0 + PRECISION)
        b = (b[above] @ _halving(b.shape[1] - 1)).reshape(-1, b.shape[1])
    return greatest * (1.0 + PRECISION)


@cache
def _halving(degree: int) -> Array:
    """Return (d + 1, 2 d + 2): the coefficients on the first half, then on the second (de Casteljau)."""
    left = [[comb(i, j) / 2**i if j <= i else 0.0 for i in range(degree + 1)] for j in range(degree + 1)]
    return frozen(np.hstack([left, np.array(left)[::-1, ::-1]]))


@cache
def _from_powers(degree: int) -> Array:
    """Return (d + 1, d + 1): from coefficients of powers, highest first, to Bernstein coefficients."""
    return frozen(
        [[comb(k, i) / comb(degree, i) if i <= k else 0.0 for i in range(degree, -1, -1)] for k in range(degree + 1)]
    )


@dataclass(frozen=True, eq=False)
class JointPath:
    """q(s) of n joints: polynomials on m pieces of a path parameter s without a unit.

    `breakpoints` (m + 1,) starts at 0 and increases. `coefficients` (degree + 1, m, n) [rad, m] hold the highest power
    of s − breakpoints[i] first. Position, tangent q' and curvature q'' are continuous. A path without motion may have
    one piece of no length.
    """

    breakpoints: Array
    coefficients: Array

    def __post_init__(self) -> None:
        for name in ("breakpoints", "coefficients"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @classmethod
    def straight(cls, start: Array, end: Array) -> JointPath:
        """The straight line from `start` to `end` (n,), of length 1."""
        return cls(np.array([0.0, 1.0]), np.stack([end - start, start])[:, None])

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.coefficients.shape[2])

    @property
    def length(self) -> float:
        """The largest s; the smallest is 0."""
        return float(self.breakpoints[-1])

    @property
    def start(self) -> Array:
        """q(0), (n,)."""
        return self(0.0)

    @property
    def end(self) -> Array:
        """q(length), (n,)."""
        return self(self.length)

    @property
    def moves(self) -> bool:
        """Whether any joint moves along it, by more than rounding."""
        ways = rescaled(self.coefficients, np.diff(self.breakpoints))[:-1]
        return bool(np.abs(ways).max(initial=0.0) > STILL)

    def in_pieces(self, most: float) -> tuple[JointPath, Indices]:
        """Cut the path evenly into pieces no longer than `most`. Also return the old piece of each new one."""
        steps = np.diff(self.breakpoints)
        count = np.maximum(np.ceil(steps / most - ROUNDING), 1.0).astype(np.intp)
        piece = np.repeat(np.arange(len(count)), count)
        nth = np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count)
        by = steps[piece] * nth / count[piece]
        breakpoints = np.append(self.breakpoints[piece] + by, self.length)
        return JointPath(breakpoints, shifted(self.coefficients[:, piece], by)), piece

    def cut_at(self, places: Array) -> JointPath:
        """Cut the path at these places (k,) too, but at none that only rounding tells from a breakpoint."""
        before = self.piece_at(places)
        gaps = places - self.breakpoints[before], self.breakpoints[before + 1] - places
        distinct = np.minimum(*gaps) > STILL * self.length
        breakpoints = np.union1d(self.breakpoints, places[distinct])
        piece = self.piece_at(breakpoints[:-1])
        moved = shifted(self.coefficients[:, piece], breakpoints[:-1] - self.breakpoints[piece])
        return JointPath(breakpoints, moved)

    def piece_at(self, s: Array) -> Indices:
        """Return the indices of the pieces at s (...); at a breakpoint the later one."""
        inner = self.breakpoints[1:-1]
        return np.searchsorted(inner, s, side="right")

    def __call__(self, s: ArrayLike, order: int = 0) -> Array:
        """Return that derivative by s at s (...), (..., n); at a breakpoint the limit from above."""
        at = np.asarray(s, dtype=np.float64)
        piece = self.piece_at(at.ravel())
        return self.within(piece, at.ravel() - self.breakpoints[piece], order).reshape(*at.shape, self.n)

    def within(self, piece: Indices, sigma: Array, order: int = 0) -> Array:
        """Return that derivative in pieces (k,), at sigma (k,) from their starts, (k, n)."""
        return evaluate(derivative(self.coefficients[:, piece], order), sigma[:, None])
