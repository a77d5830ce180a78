"""Smoothing: recorded waypoints moved within a tolerance, so that noise costs no time."""

from __future__ import annotations

from math import comb

import numpy as np

from ..support.checks import Array
from .optional import scipy

ORDER = 3
"""Order of the differences that are minimized. Those of a path of constant curvature are 0."""

SHARPER, STAGES, STEPS = 20.0, 14, 10
"""Factor of the roughness between stages, number of stages, and most Newton steps of each."""

SETTLED, GAP = 1e-3, 1e-2
"""Newton decrement that ends a stage, and the gap to the least roughness that ends the search."""

INSIDE = 0.95
"""Greatest share of the way to the tolerance's edge in one step."""

HEAVIEST = 1e12
"""Greatest weight of squared third differences, in tolerances. Beyond it the systems are singular to rounding."""

PINNED = 1e12
"""Curvature that holds the first and the last waypoint."""


def smoothed(points: Array, tolerance: Array) -> Array:
    """Return the smoothest waypoints (k, n) within `tolerance` (k, n) of the given ones. The first and the last stay.

    Each joint's z minimizes Σ (Δ³z_i)² under |z_i − y_i| ≤ tolerance. A logarithmic barrier and Newton's method solve
    this quadratic program on banded systems (Boyd & Vandenberghe 2004, §11.3). Fewer than five waypoints stay.
    """
    if len(points) <= ORDER + 1:
        return points
    return np.stack([_column(*each) for each in zip(points.T, tolerance.T, strict=True)], axis=1)


def _column(y: Array, tolerance: Array) -> Array:
    """Return one joint's values (k,): u = (z − y) / tolerance minimizes weight/2 Σ (Δ³z)² − Σ log(1 − u²)."""
    solve = scipy("linalg").solveh_banded
    rough = float((np.diff(y, ORDER) ** 2).sum())
    if rough == 0.0:
        return y
    u, weight, bands = np.zeros(len(y)), 1.0 / rough, _bands(tolerance)
    for _ in range(STAGES):
        for _ in range(STEPS):
            slope = weight * tolerance * _turned_back(np.diff(y + tolerance * u, ORDER)) + 2.0 * u / (1.0 - u**2)
            matrix = weight * bands
            matrix[-1] += 2.0 * (1.0 + u**2) / (1.0 - u**2) ** 2
            matrix[-1, [0, -1]] += PINNED * matrix[-1].max()
            step = -solve(matrix, slope)
            step[[0, -1]] = 0.0
            with np.errstate(divide="ignore"):
                room = float(np.min((1.0 - np.sign(step) * u) / np.abs(step)))
            u = u + min(1.0, INSIDE * room) * step
            if -float(slope[1:-1] @ step[1:-1]) < SETTLED:
                break
        rough = float((np.diff(y + tolerance * u, ORDER) ** 2).sum())
        weight *= SHARPER
        if len(y) * SHARPER / weight < GAP * rough or weight * tolerance.max() ** 2 > HEAVIEST:
            break
    return y + tolerance * u


def _bands(scale: Array) -> Array:
    """Return the upper bands (4, k) of the matrix of Σ (Δ³z_i)² in z / scale (k,)."""
    k = len(scale)
    row = [(-1.0) ** (ORDER - i) * comb(ORDER, i) for i in range(ORDER + 1)]
    bands = np.zeros((ORDER + 1, k))
    for i in range(ORDER + 1):
        for j in range(i, ORDER + 1):
            bands[ORDER - (j - i), j : k - ORDER + j] += row[i] * row[j]
    for d in range(ORDER + 1):
        bands[ORDER - d, d:] *= scale[d:] * scale[: k - d]
    return bands


def _turned_back(differences: Array) -> Array:
    """Return the transpose of Δ³ times (k − 3,)."""
    return (-1.0) ** ORDER * np.diff(np.pad(differences, ORDER), ORDER)
