"""The s-curve law along a path: the time-optimal one with its jumps of acceleration smoothed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import derivative
from ..spans import Progress
from .bounds import PathBounds
from .law import TimeLaw
from .pace import at_full_pace, pace_needed
from .smoothing import smoothed
from .time_optimal import time_optimal

WINDOWS = (0.5, 0.7, 1.0, 1.4, 2.0, 4.0)
"""Widths of the window that are tried, in the time in which the slowest rate comes to its acceleration limit."""

ROUGHLY = 1e-2
"""How exactly the motions of several windows are compared."""

BEND_SHARE = 0.5
"""Of the jerk, left to the bend of the path itself; the rest is for changes of the acceleration along it."""


def s_curve(path: JointPath, bounds: PathBounds, progress: Progress | None = None) -> TimeLaw:
    """A law of limited jerk, at rest and without acceleration at both ends, that keeps every limit everywhere.

    The time-optimal law's moving average has a jerk of at most its jumps of acceleration over the window's width; the
    whole is then slowed by what its exact extremes ask. Several widths are tried and the shortest motion taken. A joint
    or a motor without a jerk limit comes to its acceleration limit in 0.1 s. From rest to rest in a straight line
    `double_s` is shorter. A path that stays where it is takes no time.

    Args:
        path: Where the motion goes.
        bounds: The limits; each joint that moves needs one of its acceleration, or its motors do.
        progress: Called with the fraction done, in (0, 1], or None.

    Returns:
        The law.

    Raises:
        InputError: As `time_optimal`.
    """
    bounds.require(path)
    if not path.moves:
        return TimeLaw.at_once()
    fastest = time_optimal(path, replace(bounds, ceiling=_ceiling(path, bounds)), progress)
    tried = (smoothed(fastest, width * _slowest_rise(bounds), path) for width in WINDOWS)
    shortest = min(tried, key=lambda law: law.duration * pace_needed(path, law, bounds, bounds.jerk, ROUGHLY))
    return at_full_pace(path, shortest, bounds, bounds.jerk)


def _ceiling(path: JointPath, bounds: PathBounds) -> Array:
    """The greatest ṡ on each piece (m,): where the path bends sharply, |C d³q/ds³| ṡ³ has its share of the jerk."""
    sharp = np.abs(bernstein(derivative(path.coefficients, 3), np.diff(path.breakpoints)) @ bounds.C.T).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slow = np.cbrt(BEND_SHARE * bounds.jerk / sharp)
    return np.asarray(np.fmin(bounds.ceiling_of(path), np.fmin.reduce(slow, axis=1)))


def _slowest_rise(bounds: PathBounds) -> float:
    """The longest time [s] in which a rate comes to its acceleration limit."""
    limited = np.isfinite(bounds.acceleration)
    return float((bounds.acceleration[limited] / bounds.jerk[limited]).max())
