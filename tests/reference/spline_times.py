"""The time of a spline between waypoints and its gradient, in NumPy and SciPy: the core's search, written again.

A motion f times as slow meets its limits. There f is the largest share of a limit in use, to the power 1/order of the
rate. One factor of all durations d does not change Σ d · f. L-BFGS minimizes it in x = log d, with a p-norm for the
largest (Nocedal & Wright, Numerical Optimization, §7.2).
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.optimize import minimize

from twistarm.planning.piecewise import derivative, evaluate, through
from twistarm.support.checks import Array, frozen

SAMPLES = 17
"""Places in each segment at which rates are looked at."""

NORMS = (2.0**5, 2.0**7, 2.0**9, 2.0**10)
"""Orders of the norm. The first sees the whole motion; the last is within a per cent of the maximum of very many.

With fewer orders between them, a search stops at one rate after the other.
"""

STEPS, GAIN = 60, 3e-6
"""Greatest number of steps for each norm, and the least gain of a step."""


def in_numpy(way: Array, degree: int, limits: tuple[Array, ...], durations: Array) -> Array:
    """Durations (s,), up to one factor, of the shortest motion found near the given ones, by SciPy."""
    x, least = np.log(durations), (np.inf, np.log(durations))
    for power in NORMS:

        def norm(at: Array, power: float = power) -> tuple[float, Array]:
            nonlocal least
            value, gradient, exact = duration(way, degree, limits, at, power)
            least = min(least, (exact, at.copy()), key=lambda seen: seen[0])
            return value, gradient

        x = minimize(norm, x, jac=True, method="L-BFGS-B", options={"maxiter": STEPS, "ftol": GAIN}).x
    return np.exp(least[1])


def duration(way: Array, degree: int, limits: tuple[Array, ...], x: Array, power: float) -> tuple[float, Array, float]:
    """The logarithm of the time with durations exp(x) (s,): by the p-norm, its gradient (s,), and by the largest rate.

    The unknown derivatives u at inner waypoints minimize E = ½ ∫ |q^(R+1)|² dt, degree = 2 R + 1. In unit time a
    segment has the ends e, e_k ~ d^k u_k, and E is the sum of ½ d^(−degree) eᵀ K e. So ∂E/∂u = 0 is a symmetric linear
    system. Its adjoint gives the gradient of any function of d and u.
    """
    R, d = degree // 2, np.exp(x - x.mean())
    order = np.array([*range(1, R + 1), 0, *range(1, R + 1)])
    scale, s = d[:, None] ** order, len(d)
    unknown = (np.arange(s)[:, None] - 1) * R + np.array([*range(R), -degree * s * R, *range(R, 2 * R)])
    inner = (unknown >= 0) & (unknown < (s - 1) * R)
    seg, end = np.nonzero(inner)
    stiff = energy(degree) * (d[:, None, None] ** (order[:, None] + order - degree))
    bands, right = np.zeros((2 * R, (s - 1) * R)), np.zeros(((s - 1) * R, way.shape[1]))
    upper = inner[:, :, None] & inner[:, None, :] & (unknown[:, :, None] <= unknown[:, None, :])
    at, first, second = np.nonzero(upper)
    row, column = unknown[at, first], unknown[at, second]
    np.add.at(bands, (2 * R - 1 + row - column, column), stiff[upper])
    np.add.at(right, unknown[seg, end], -stiff[seg, end, R, None] * way[seg])
    e = np.zeros((s, degree, way.shape[1]))
    e[:, R] = way
    e[seg, end] = solved(bands, right)[unknown[seg, end]] * scale[seg, end, None]

    rates = [
        np.einsum("mk,skr->smr", sampled_derivative(degree, o), e) / (limit * d[:, None, None] ** o)
        for o, limit in enumerate(limits, 1)
    ]
    shares = [np.abs(rate) ** (1.0 / o) for o, rate in enumerate(rates, 1)]
    most = max(float(share.max()) for share in shares)
    weights = [(share / most) ** power for share in shares]
    total = sum(float(weight.sum()) for weight in weights)

    slope, gradient = np.zeros_like(e), d / d.sum()
    for o, (rate, weight, limit) in enumerate(zip(rates, weights, limits, strict=True), 1):
        by_rate = np.divide(weight, o * total * rate, out=np.zeros_like(rate), where=rate != 0.0)
        slope += np.einsum("mk,smr->skr", sampled_derivative(degree, o), by_rate / (limit * d[:, None, None] ** o))
        gradient -= weight.sum((1, 2)) / total
    gradient += (order[:, None] * slope * e)[:, order > 0].sum((1, 2))
    pull = np.zeros_like(right)
    np.add.at(pull, unknown[seg, end], (slope * scale[..., None])[seg, end])
    adjoint = np.zeros_like(e)
    adjoint[seg, end] = solved(bands, pull)[unknown[seg, end]]
    exponents = (order[:, None] + order - degree) * energy(degree)
    moved = np.einsum("skr,kl,slr->sk", adjoint, exponents, e)
    gradient -= (moved * d[:, None] ** (order - degree)).sum(1)
    exact = float(np.log(d.sum()) + np.log(most))
    return exact + float(np.log(total)) / power, gradient, exact


def solved(bands: Array, right: Array) -> Array:
    """The unknowns (N, r) of a positive definite system, in SciPy's upper form (2 R, N)."""
    return np.asarray(cho_solve_banded((cholesky_banded(bands), False), right)) if right.size else right


@cache
def sampled_derivative(degree: int, order: int) -> Array:
    """(17, degree): that derivative at σ from 0 to 1, from a segment's ends in unit time.

    The ends are start, way and end: derivatives of order 1 … R at both, and their difference.
    """
    return frozen(evaluate(derivative(_from_ends(degree), order), np.linspace(0.0, 1.0, SAMPLES)[:, None]))


@cache
def energy(degree: int) -> Array:
    """(degree, degree): ∫ of the products of the ends' derivatives of order R + 1, in unit time."""
    b = derivative(_from_ends(degree), degree // 2 + 1)[:, 0]
    powers = np.arange(len(b) - 1, -1, -1.0)
    return frozen(np.einsum("ik,jl,ij->kl", b, b, 1.0 / (powers[:, None] + powers + 1.0)))


def _from_ends(degree: int) -> Array:
    """(degree + 1, 1, degree): the polynomial on [0, 1] of each of a segment's ends."""
    R, unit = degree // 2, np.eye(degree)
    states = np.zeros((R + 1, 2, degree))
    states[1:, 0], states[0, 1], states[1:, 1] = unit[:R], unit[R], unit[R + 1 :]
    return through(np.array([0.0, 1.0]), *states)
