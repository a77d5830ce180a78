"""The time-optimal law along a path, within velocities, accelerations, motors, torques and the tool's speed.

The largest ṡ² on a grid comes from a reachability analysis in two passes, by the compiled core. Source: Pham & Pham, A
new approach to time-optimal path parameterization based on reachability analysis, IEEE T-RO 34(3), 2018. The rows of
each interval are those of core/include/twistarm/planning/interval_limits.hpp.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..arm import engine
from ..support.checks import Array
from ..support.errors import InputError
from .piecewise import JointPath
from .time_law import APART, PathBounds, TimeLaw
from .torque_limits import grid_rows, largest_between
from .within import MARGIN, SHORTEST, require_span

FIRST_INTERVALS = 150  # Intervals to begin with, about.
LEAST_PER_PIECE = 2  # Intervals to begin with on each piece of the path.
GAIN = 1e-3  # The grid is fine enough when a finer one shortens the motion by less than this share.
UNUSED_PER_GAIN = 4.0  # The grid loses one in so many parts of the time that the limits leave unused.
# Intervals are halved if their loss exceeds this share of the motion's time, divided among all of them.
LOSS = 3e-3
BETWEEN = 3e-4  # Intervals are halved if a torque exceeds its room by this share in their middle.
ROUNDS = 10  # How often intervals are halved at most.
MAX_INTERVALS = 5000  # A grid of more intervals is not refined: a trajectory has a piece for each.
LEAST_DEGREE = 2  # A straight line counts as a parabola: its curvature is a polynomial too.
# The kinds of motion that need no core.
WITHOUT_CORE = " (not kind='quintic', straight joint moves from rest to rest, or splines at given times)"


def time_optimal(path: JointPath, bounds: PathBounds) -> TimeLaw:
    """The shortest law from rest to rest that keeps velocity, acceleration, motors, torques and ceiling.

    s̈ is constant on each interval of a grid, so s is a parabola on each. No limit is exceeded between the grid's
    points either, a torque by 0.1 % at most. Intervals are halved until the gain is below 0.1 %, or there are 5,000.
    Where p' = 0, curvature alone limits the acceleration. Where the path does not move, nothing does. Jerk is not
    limited. A path that stays where it is takes no time. Raises InputError for a motion of less than 1e-9 s or more
    than 1e9 s.
    """
    if not path.moves:
        return TimeLaw.at_once()
    if path.coefficients.shape[:2] == (2, 1) and bounds.torques is None:
        return along_line(path, bounds)
    limited, grid, shortest = LimitedPath.of(path, bounds), first_grid(path.breakpoints), np.inf
    for rounds_left in reversed(range(ROUNDS)):
        profile = path_velocity(limited, grid, grid_rows(bounds.torques, path, grid))
        durations = durations_of(grid, profile.x)
        duration = float(durations.sum())
        endless = np.isinf(durations)
        # Where both speeds are zero, or an interval is tiny, no limit has a share; an endless interval is halved.
        loss = np.where(endless, 0.0, durations) * (1.0 - np.fmax(np.fmin(profile.share, 1.0), 0.0))
        if bounds.torques is not None:
            endless |= largest_between(bounds.torques, path, grid, profile.x) > 1.0 + BETWEEN
        fine = loss.sum() < UNUSED_PER_GAIN * GAIN * duration or duration > shortest * (1.0 - GAIN)
        coarse = endless | (loss > LOSS * duration / len(loss))
        if not rounds_left or (not endless.any() and (fine or not coarse.any() or len(coarse) > MAX_INTERVALS)):
            break
        shortest = duration
        grid = np.sort(np.concatenate([grid, (0.5 * (grid[:-1] + grid[1:]))[coarse]]))
    if bounds.torques is not None:
        return law_of(grid, profile.x / max(1.0, float(largest_between(bounds.torques, path, grid, profile.x).max())))
    return law_of(grid, profile.x)


def first_grid(breakpoints: Array) -> Array:
    """Every piece of the path in as many intervals of one length."""
    pieces = len(breakpoints) - 1
    count = max(LEAST_PER_PIECE, -(-FIRST_INTERVALS // pieces))
    inner = breakpoints[:-1, None] + np.diff(breakpoints)[:, None] * np.arange(count) / count
    return np.append(inner.ravel(), breakpoints[-1])


def durations_of(grid: Array, x: Array) -> Array:
    """How long each interval takes (N,) [s]: 2 h / (ṡ0 + ṡ1), inf without speed at both ends."""
    speed = np.sqrt(x)
    with np.errstate(divide="ignore"):
        durations: Array = 2.0 * np.diff(grid) / (speed[:-1] + speed[1:])
    return durations


def law_of(grid: Array, x: Array) -> TimeLaw:
    """The law of x = ṡ² (N + 1,) with a constant s̈ on each interval of a grid (N + 1,)."""
    durations = durations_of(grid, x)
    require_span(float(durations.sum()))
    breakpoints = np.concatenate([[0.0], np.cumsum(durations)])
    coefficients = np.stack([0.25 * np.diff(x) / np.diff(grid), np.sqrt(x[:-1]), grid[:-1]])
    return TimeLaw(breakpoints, coefficients)


@dataclass(frozen=True, eq=False)
class LimitedPath:
    """A path for its limits: rows C q of joints and motors (d + 1, m, r), d ≥ 2, and their limits.

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
        return cls(path.breakpoints, np.ascontiguousarray(padded), *((1.0 - MARGIN) * limit for limit in limits))


class Profile(NamedTuple):
    """x = ṡ² (N + 1,) on a grid, and how far each interval uses its tightest limit (N,)."""

    x: Array
    share: Array


def path_velocity(path: LimitedPath, grid: Array, rows: Array | None = None) -> Profile:
    """The profile on the grid (N + 1,) over the path's length, with every breakpoint of the path.

    `rows` are a and b (2, N + 1, k) of further limits a s̈ + b ṡ² ≤ 1 at its points.

    Backwards: from which x the end can be reached at rest. Forwards: the largest x, interval by interval, that stays
    among those. Every interval's region of (x0, x1) is convex and holds (0, 0), so neither pass can fail. Raises
    TwistarmError without the compiled core, InputError for more joints and motors than it takes.
    """
    core = engine.need(f"the shortest motion along a path{WITHOUT_CORE}")
    a, b = np.zeros((2, len(grid), 0)) if rows is None else rows
    greatest = float(path.breakpoints[-1] / SHORTEST) ** 2  # ṡ² where nothing else limits it
    return Profile(*_require_capacity(path, core.path_velocity(*vars(path).values(), grid, a, b, greatest)))


def shares_of_average(
    path: LimitedPath, grid: Array, rows: Array, x: Array, jerk: Array, window: float
) -> tuple[Array, Array]:
    """The shares of its limits that a law x = ṡ² (N + 1,) uses after a moving average over a window [s].

    The shares (3, m) are of velocity, acceleration and `jerk` (r,) on each piece, with the largest ṡ there (m,). Three
    samples between any two knots of the law and of the path give them. Raises as `path_velocity` does.
    """
    core = engine.need(f"the shortest motion along a path{WITHOUT_CORE}")
    return _require_capacity(path, core.shares_of_average(*vars(path).values(), grid, *rows, x, jerk, window))


def _require_capacity(path: LimitedPath, found: tuple[Array, Array] | None) -> tuple[Array, Array]:
    if found is None:
        count, most = len(path.velocity), 2 * engine.MOST_JOINTS
        raise InputError(f"a path is timed for at most {most} joints and motors; this one has {count}")
    return found


def line_durations(ways: Array, bounds: PathBounds) -> Array:
    """Durations (k,) [s] of the shortest straight motions from rest to rest along ways (k, n) other than zero.

    The fraction travelled may have speed V = min v / |C way| and acceleration A = min a / |C way|. It takes 1/V + V/A,
    or 2/√A if V² ≥ A (Lynch & Park §9.2.2.2).
    """
    V, A = _line_limits(ways, bounds)
    ramps = np.minimum(V / A, np.sqrt(1.0 / A))
    return ramps + np.maximum(1.0 / V, ramps)


def along_line(path: JointPath, bounds: PathBounds) -> TimeLaw:
    """The law of a straight path: full acceleration, full speed, full braking."""
    L = path.length
    V, A = (float(limit[0]) * L * (1.0 - MARGIN) for limit in _line_limits((path.end - path.start)[None], bounds))
    V = min(V, float(bounds.ceiling_of(path)[0]) * (1.0 - MARGIN))
    ramp = min(V / A, np.sqrt(L / A))
    coast = L / V - ramp
    speed, bend = A * ramp, 0.5 * A * ramp**2
    phases = [(0.5 * A, 0.0, 0.0), (0.0, speed, bend), (-0.5 * A, speed, L - bend)]
    durations = [ramp, coast, ramp]
    if coast <= APART * ramp:
        del phases[1], durations[1]
    require_span(sum(durations))
    return TimeLaw(np.cumsum([0.0, *durations]), np.array(phases).T)


def _line_limits(ways: Array, bounds: PathBounds) -> tuple[Array, Array]:
    rows = np.abs(ways @ bounds.C.T)
    with np.errstate(divide="ignore"):
        return 1.0 / (rows / bounds.velocity).max(axis=-1), 1.0 / (rows / bounds.acceleration).max(axis=-1)
