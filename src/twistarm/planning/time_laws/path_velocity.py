"""The largest ṡ² along a path within limits, on a grid: reachability analysis in two passes, by the compiled core.

Source: Pham & Pham, A new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO
34(3), 2018. The rows of each interval are those of core/include/twistarm/planning/interval_limits.hpp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...arm import engine
from ...support.checks import Array
from ...support.errors import InputError
from ..joint_path import JointPath
from ..spans import MARGIN, SHORTEST
from .bounds import PathBounds

LEAST_DEGREE = 2
"""A straight line counts as a parabola: its curvature is a polynomial too."""


@dataclass(frozen=True, eq=False)
class LimitedPath:
    """A path for its limits: the rows C q of joints and motors, (d + 1, m, r), d ≥ 2, and their limits.

    `velocity` and `acceleration` are (r,), `ceiling` of ṡ (m,); all less by what rounding may add.
    """

    breakpoints: Array
    coefficients: Array
    velocity: Array
    acceleration: Array
    ceiling: Array

    @classmethod
    def of(cls, path: JointPath, bounds: PathBounds) -> LimitedPath:
        """The path with its bounds."""
        coefficients = path.coefficients @ bounds.C.T
        missing = max(0, LEAST_DEGREE + 1 - len(coefficients))
        padded = np.concatenate([np.zeros((missing, *coefficients.shape[1:])), coefficients])
        limits = bounds.velocity, bounds.acceleration, bounds.ceiling_of(path)
        return cls(path.breakpoints, np.ascontiguousarray(padded), *((1.0 - MARGIN) * each for each in limits))


class Profile(NamedTuple):
    """x = ṡ² (N + 1,) on a grid, and how far each interval uses its tightest limit (N,)."""

    x: Array
    share: Array


def path_velocity(path: LimitedPath, grid: Array) -> Profile:
    """The profile on the grid (N + 1,) over the path's length, with every breakpoint of the path.

    Backwards: from which x the end can be reached at rest. Forwards: the largest x, interval by interval, that stays
    among those. Every interval's region of (x0, x1) is convex and holds (0, 0), so neither pass can fail. Raises
    TwistarmError without the compiled core, InputError for more joints and motors than it takes.
    """
    core = engine.need("the shortest motion along a path")
    found = core.path_velocity(*vars(path).values(), grid, greatest_rate(path))
    if found is None:
        count, most = len(path.velocity), 2 * engine.MOST_JOINTS
        raise InputError(f"a path is timed for at most {most} joints and motors; this one has {count}")
    return Profile(*found)


def greatest_rate(path: LimitedPath) -> float:
    """The largest ṡ² where nothing else limits it."""
    return float(path.breakpoints[-1] / SHORTEST) ** 2
