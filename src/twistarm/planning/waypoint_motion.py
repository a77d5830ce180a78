"""The shortest motion through waypoints under a time law: along a spline, straight, or both, with few stops."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache
from itertools import pairwise

import numpy as np

from ..support.checks import Array
from .joint_path import JointPath
from .piecewise import bernstein, side_by_side
from .spline import cubic_not_forced, natural, outside, pulled_in
from .time_laws.law import PathBounds
from .time_laws.s_curve import s_curve
from .time_laws.straight import double_s, double_s_durations, line_durations
from .time_laws.time_optimal import time_optimal
from .trajectory import Progress
from .within import require_span

Motion = tuple[Array, Array, Array]
"""Times of the waypoints (k,), breakpoints (p + 1,) and coefficients (degree + 1, p, n)."""

FEW_WAYPOINTS = 30
"""With at most so many waypoints the centripetal spline is a candidate. It is slow on many uneven ones."""

WORTH_A_LAW = 1.05
"""A path that takes longer than the fastest by this factor without jerk limits gets no s-curve."""

FIRST_PART = 0.8
"""Share of the work when the motion without stops is there."""

MOST_STOPS = 16
"""Greatest number of stops on the way, unless the motion stops after every leg."""

SHORT = 0.4
"""A leg is short if it takes less than this share of the time of either leg beside it."""

GAUSS_POINTS, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(8)


def shortest_motion(
    points: Array, law: str, bounds: PathBounds, *, stop: bool = False, progress: Progress | None = None
) -> Motion:
    """Return the shortest motion found through distinct waypoints (k, n), k ≥ 2, from rest to rest.

    It stops at every waypoint if `stop`, and goes straight then. Otherwise it stops only where that is sooner done.
    Between stops it follows the spline whose law is the shortest.
    """
    ways = np.diff(points, axis=0)
    alone = (double_s_durations if law == "s_curve" else line_durations)(ways, bounds)
    require_span(float(alone.sum()))
    straight = _double_s if law == "s_curve" else _along_line

    @cache
    def timed(i: int, j: int) -> Motion:
        return straight(points[i : j + 1], bounds) if j == i + 1 else _along_spline(points[i : j + 1], law, bounds)

    stops = tuple(range(1, len(alone)))
    if not stop and len(alone) > 1:
        ends = timed(0, len(alone))[0][1:]
        if progress is not None:
            progress(FIRST_PART)
        stops = best_stops(lambda i, j: float(alone[i] if j == i + 1 else timed(i, j)[0][-1]), alone, ends)
    return _joined([timed(i, j) for i, j in pairwise([0, *stops, len(alone)])])


def best_stops(duration: Callable[[int, int], float], alone: Array, ends: Array) -> tuple[int, ...]:
    """Return after which of m legs to stop: none, all, or a few that save time.

    A stop may save time where both legs beside it take longer on the way than from rest to rest, and at both ends of a
    short leg. Such stops that do not help are left out one by one.

    Args:
        duration: The time [s] of legs i … j − 1 from rest to rest, without a stop between them.
        alone: The time of each leg from rest to rest (m,) [s].
        ends: When the motion without stops ends each leg (m,) [s].
    """
    count = len(alone)

    def whole(stops: Iterable[int]) -> float:
        return sum(duration(i, j) for i, j in pairwise([0, *stops, count]))

    passed = np.append(0.0, ends)
    slow = np.flatnonzero(passed[2:] - passed[:-2] > alone[1:] + alone[:-1]) + 1
    short = np.flatnonzero(alone[1:-1] < SHORT * np.minimum(alone[:-2], alone[2:])) + 1
    few = [tuple(stops.tolist()) for stops in (slow, np.union1d(short, short + 1)) if len(stops) <= MOST_STOPS]
    best = min(((), tuple(range(1, count)), *few), key=whole)
    if best in few:
        for stop in best:
            best = min(best, tuple(other for other in best if other != stop), key=whole)
    return best


def _double_s(ends: Array, bounds: PathBounds) -> Motion:
    breakpoints, coefficients = double_s(ends[0], ends[1], bounds)
    return breakpoints[[0, -1]], breakpoints, coefficients


def _along_line(ends: Array, bounds: PathBounds) -> Motion:
    line = JointPath.straight(ends[0], ends[1])
    breakpoints, coefficients = time_optimal(line, bounds).along(line)
    return breakpoints[[0, -1]], breakpoints, coefficients


def _along_spline(points: Array, law: str, bounds: PathBounds) -> Motion:
    """Return the shortest motion along one of the splines through the waypoints, without a stop."""
    paths = spline_paths(points, bounds)
    laws = [time_optimal(path, bounds) for path, _ in paths]
    if law == "s_curve":
        most = WORTH_A_LAW * min(each.duration for each in laws)
        paths = [path for path, each in zip(paths, laws, strict=True) if each.duration <= most]
        laws = [s_curve(path, bounds) for path, _ in paths]
    best = min(range(len(laws)), key=lambda i: laws[i].duration)
    path, places = paths[best]
    return laws[best].passes(places), *laws[best].along(path)


def spline_paths(points: Array, bounds: PathBounds) -> list[tuple[JointPath, Array]]:
    """Return candidate paths through distinct waypoints (k, n), k ≥ 3, with the place s of each waypoint (k,).

    Distances are Euclidean in C q / velocity: s counts seconds at full speed. Candidates are the C² cubic by chords,
    the C⁴ quintic by its own arc length, and for few waypoints the centripetal C² cubic (Lee 1989). A path that would
    leave the position limits becomes the natural cubic with its knots at the waypoints, pulled inside.
    """
    chords = _length(np.diff(points, axis=0), bounds)
    rough = JointPath(*natural(points, _summed(chords), 5))
    at = _summed(chords)[:-1] + 0.5 * (GAUSS_POINTS[:, None] + 1.0) * chords
    arcs = 0.5 * chords * (GAUSS_WEIGHTS @ _length(rough(at, 1), bounds))
    candidates = [(chords, 3), (arcs, 5), *([(np.sqrt(chords), 3)] if len(points) <= FEW_WAYPOINTS else [])]
    return [_through(points, _summed(steps), degree, bounds) for steps, degree in candidates]


def _through(points: Array, s: Array, degree: int, bounds: PathBounds) -> tuple[JointPath, Array]:
    breakpoints, coefficients = natural(points, s, degree)
    lower, upper = np.minimum(bounds.limits.lower, points.min(0)), np.maximum(bounds.limits.upper, points.max(0))
    if outside(bernstein(coefficients, np.diff(breakpoints)), lower, upper).any():
        return JointPath(*pulled_in(cubic_not_forced(points, s, "natural"), s, points, bounds.limits)), s
    return JointPath(breakpoints, coefficients).cut_at(s), s


def _length(way: Array, bounds: PathBounds) -> Array:
    """Return the Euclidean length (...) of ways (..., n) in C q / velocity [s]."""
    return np.linalg.norm(way @ bounds.C.T / bounds.velocity, axis=-1)


def _summed(steps: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(steps)])


def _joined(motions: list[Motion]) -> Motion:
    starts = np.concatenate([[0.0], np.cumsum([times[-1] for times, _, _ in motions])])
    times, breakpoints = (
        np.concatenate([[0.0], *(start + motion[i][1:] for start, motion in zip(starts, motions, strict=False))])
        for i in (0, 1)
    )
    return times, breakpoints, side_by_side([coefficients for _, _, coefficients in motions])
