"""Splines through waypoints, as paths without time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array
from . import spline
from .joint_path import JointPath
from .piecewise import derivative, evaluate
from .pulling_in import pulled_in
from .time_laws import PathBounds

FEW_WAYPOINTS = 30
"""With at most so many waypoints the centripetal spline is a candidate. It is slow on many uneven ones."""

NEAR_SHARE = 0.2
"""A waypoint nearer to the last than this share of the median distance may be left out of the spline."""

FEWEST_KNOTS = 3
"""A quintic with free ends needs so many waypoints."""

LEAST_KNOT = 3e-5
"""Least distance [rad, m] between the waypoints of a spline. Rounding of nearer ones makes the jerk large."""

ROOM = 3.0
"""A waypoint moves out to the least distance only if the next one is farther by this factor."""

MET = 1e-9
"""Greatest distance [rad, m] from the path to a waypoint that its spline leaves out or moves."""

ROUNDS = 3
"""Greatest number of splines, each through more of the waypoints that the last one missed."""

PROJECTIONS = 3
"""Newton steps to the nearest place on the path. Waypoints lie so near that two are enough."""

TINY = 1e-300
"""In place of 0 below a fraction, where the path stands still."""

Fit = Callable[[Array, PathBounds], tuple[Array, Array]]
"""Coefficients (degree + 1, k − 1, n) of a spline through knots (k, n), and the place s of each knot (k,)."""

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)


def spline_paths(points: Array, bounds: PathBounds) -> list[tuple[JointPath, Array]]:
    """Return candidate paths through distinct waypoints (k, n), k ≥ 2, with the place s of each waypoint (k,).

    Distances are Euclidean in C q / velocity: s counts seconds at full speed. Candidates are the C² cubic and the C⁴
    quintic, and for few waypoints the centripetal C² cubic (Lee 1989). All are pulled inside the position limits.
    The parameter of the quintic is the arc length of the quintic by chords.
    """
    fits = [_cubic_by_chords, _quintic_by_arcs, *([_cubic_by_roots] if len(points) <= FEW_WAYPOINTS else [])]
    return [_through(points, bounds, fit) for fit in fits]


def _through(points: Array, bounds: PathBounds, fit: Fit) -> tuple[JointPath, Array]:
    """Return the path of a fit, and the place of each waypoint.

    Rounding in the distance of near waypoints becomes jerk of the spline. So the fit leaves out waypoints much nearer
    than others, and moves one very near another away from it. It meets them within 1e-9 or takes them as they are.
    """
    along = _summed(_distances(points, bounds))
    kept = _far_apart(along)
    for _ in range(ROUNDS):
        knots = _moved_apart(points[kept], bounds)
        path, s = _fitted(knots, bounds, fit)
        free = ~kept
        free[kept] = (knots != points[kept]).any(axis=1)
        places = np.interp(along, along[kept], s)
        places[free] = _nearest(path, points[free], places[free])
        missed = np.abs(path(places) - points).max(axis=1) > MET
        if not missed.any() and (np.diff(places) > 0.0).all():
            return path.cut_at(places[free]), places
        kept = kept | missed
    return _fitted(points, bounds, fit)


def _fitted(knots: Array, bounds: PathBounds, fit: Fit) -> tuple[JointPath, Array]:
    coefficients, s = fit(knots, bounds)
    return JointPath(*pulled_in(coefficients, s, knots, bounds.limits)), s


def _cubic_by_chords(knots: Array, bounds: PathBounds) -> tuple[Array, Array]:
    s = _summed(_distances(knots, bounds))
    return spline.unforced(knots, s), s


def _cubic_by_roots(knots: Array, bounds: PathBounds) -> tuple[Array, Array]:
    s = _summed(np.sqrt(_distances(knots, bounds)))
    return spline.unforced(knots, s), s


def _quintic_by_arcs(knots: Array, bounds: PathBounds) -> tuple[Array, Array]:
    chords = _distances(knots, bounds)
    rough = spline.unforced_quintic(knots, _summed(chords))
    tau = 0.5 * (GAUSS_POINTS[:, None, None] + 1.0) * chords[:, None]
    speed = np.stack([_length(evaluate(derivative(rough), at), bounds) for at in tau])
    s = _summed(0.5 * chords * (GAUSS_WEIGHTS @ speed))
    return spline.unforced_quintic(knots, s), s


def _distances(points: Array, bounds: PathBounds) -> Array:
    return _length(np.diff(points, axis=0), bounds)


def _length(way: Array, bounds: PathBounds) -> Array:
    """Return the Euclidean length (...) of ways (..., n) in C q / velocity [s]."""
    return np.linalg.norm(way @ bounds.C.T / bounds.velocity, axis=-1)


def _summed(steps: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(steps)])


def _far_apart(along: Array) -> NDArray[np.bool_]:
    """Tell which waypoints at these places (k,) are far enough from the last such one. Both ends are."""
    least = NEAR_SHARE * float(np.median(np.diff(along)))
    kept = np.zeros(len(along), dtype=np.bool_)
    kept[0], last = True, along[0]
    for i in range(1, len(along) - 1):
        if along[i] - last >= least <= along[-1] - along[i]:
            kept[i], last = True, along[i]
    kept[-1] = True
    return kept if kept.sum() >= FEWEST_KNOTS else np.ones_like(kept)


def _moved_apart(knots: Array, bounds: PathBounds) -> Array:
    """Return knots (k, n) of which one very near another is moved away from it, along the line through both."""
    moved, size = knots.copy(), np.abs(np.diff(knots, axis=0)).max(axis=1)
    for i in np.flatnonzero(size < LEAST_KNOT):
        stays, goes, beyond = (i, i + 1, i + 1) if i + 2 < len(knots) else (i + 1, i, i - 1)
        if 0 <= beyond < len(size) and size[beyond] > ROOM * LEAST_KNOT:
            moved[goes] = knots[stays] + (knots[goes] - knots[stays]) * (LEAST_KNOT / size[i])
    inside = (moved >= bounds.limits.lower) & (moved <= bounds.limits.upper)
    return np.where(inside.all(axis=1, keepdims=True), moved, knots)


def _nearest(path: JointPath, points: Array, s: Array) -> Array:
    """Return the places (k,) on the path nearest to points (k, n), near the given ones."""
    for _ in range(PROJECTIONS):
        tangent = path(s, 1)
        step = ((points - path(s)) * tangent).sum(axis=1) / np.maximum((tangent**2).sum(axis=1), TINY)
        s = np.clip(s + step, 0.0, path.length)
    return s
