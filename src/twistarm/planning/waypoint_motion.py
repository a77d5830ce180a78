"""The shortest motion through waypoints under a time law: along a spline, straight, or both."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

from ..support.checks import Array
from .joint_path import JointPath
from .piecewise import side_by_side
from .spans import Progress, require_span
from .stops import best_stops
from .time_laws import PathBounds, double_s, double_s_durations, line_durations, s_curve, time_optimal
from .waypoint_path import spline_paths

Motion = tuple[Array, Array, Array]
"""Times of the waypoints (k,), breakpoints (p + 1,) and coefficients (degree + 1, p, n)."""

WORTH_A_LAW = 1.05
"""A path that takes longer than the fastest by this factor without jerk limits gets no s-curve."""

FIRST_PART = 0.8
"""Share of the work when the motion without stops is there."""


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


def _double_s(ends: Array, bounds: PathBounds) -> Motion:
    breakpoints, coefficients = double_s(ends[0], ends[1], bounds)
    return breakpoints[[0, -1]], breakpoints, coefficients


def _along_line(ends: Array, bounds: PathBounds) -> Motion:
    line = JointPath(np.array([0.0, 1.0]), np.stack([ends[1] - ends[0], ends[0]])[:, None])
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


def _joined(motions: list[Motion]) -> Motion:
    starts = np.concatenate([[0.0], np.cumsum([times[-1] for times, _, _ in motions])])
    times, breakpoints = (
        np.concatenate([[0.0], *(start + motion[i][1:] for start, motion in zip(starts, motions, strict=False))])
        for i in (0, 1)
    )
    return times, breakpoints, side_by_side([coefficients for _, _, coefficients in motions])
