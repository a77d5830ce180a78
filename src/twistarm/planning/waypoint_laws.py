"""Motions through waypoints by a time law: along a spline, or double-S between stops."""

from __future__ import annotations

import numpy as np

from ..support.checks import Array
from ..support.errors import LimitError
from . import spline
from .joint_path import JointPath
from .pulling_in import pulled_in
from .spans import Progress
from .time_laws import PathBounds, double_s, time_optimal
from .within import RATE_TOL

EXPONENTS = (0.5, 1.0)
"""Exponents of each segment's least time in the path's parameter: the centripetal and the chordal spline."""

Motion = tuple[Array, Array, Array]
"""Times of the waypoints (k,), breakpoints (p + 1,) and coefficients (degree + 1, p, n)."""


def fastest_along_spline(points: Array, bounds: PathBounds, progress: Progress | None = None) -> Motion:
    """The shortest motion along a spline through distinct waypoints (k, n), inside the limits.

    It takes the faster of the centripetal and the chordal cubic spline, pulled inside the position limits.
    """
    least, laws = np.abs(np.diff(points, axis=0) @ bounds.C.T / bounds.velocity).max(-1), []
    for exponent in EXPONENTS:
        s = np.concatenate([[0.0], np.cumsum(least**exponent)])
        path = JointPath(*pulled_in(spline.unforced(points, s), s, points, bounds.limits))
        laws.append((time_optimal(path, bounds, progress), path, s))
    law, path, s = min(laws, key=lambda timed: timed[0].duration)
    return law.passes(s), *law.along(path)


def fastest_rests(points: Array, bounds: PathBounds) -> Motion:
    """The shortest motion straight from each waypoint (k, n) to the next distinct one."""

    def segment(i: int) -> tuple[Array, Array]:
        line = JointPath(np.array([0.0, 1.0]), np.stack([points[i + 1] - points[i], points[i]])[:, None])
        return time_optimal(line, bounds).along(line)

    return _chained([segment(i) for i in range(len(points) - 1)])


def double_s_rests(points: Array, bounds: PathBounds, times: Array | None = None) -> Motion:
    """Double-S from each waypoint (k, n) to the next: the shortest, or at times (k,) [s]."""
    given = np.zeros(len(points) - 1) if times is None else np.diff(times)
    segments = [double_s(points[i], points[i + 1], bounds, float(duration)) for i, duration in enumerate(given)]
    needed = np.array([instants[-1] for instants, _ in segments])
    if times is not None and (needed > given * (1.0 + RATE_TOL)).any():
        i = int(np.argmax(needed / given))
        raise LimitError(
            f"from waypoint {i} (counted from 0) to the next takes {needed[i]:.4g} s inside the limits; times leave "
            f"{given[i]:.4g} s: multiply times by {needed[i] / given[i] * (1 + 5e-4):.4g}, or leave times out"
        )
    return _chained(segments)


def _chained(segments: list[tuple[Array, Array]]) -> Motion:
    when = np.concatenate([[0.0], np.cumsum([instants[-1] for instants, _ in segments])])
    breakpoints = [start + instants[1:] for start, (instants, _) in zip(when, segments, strict=False)]
    return when, np.concatenate([[0.0], *breakpoints]), np.concatenate([pieces for _, pieces in segments], axis=1)
