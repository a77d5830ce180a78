"""The shortest motions from rest to rest along straight lines, in closed form: double-S profiles and trapezoids."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ..joint_path import JointPath
from ..within import MARGIN, require_span
from .law import APART, PathBounds, TimeLaw, distinct_instants

SIGNS: Array = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])
"""The jerk in the seven phases of a double-S profile, as a share of its greatest."""


def double_s(start: Array, goal: Array, bounds: PathBounds) -> tuple[Array, Array]:
    """Breakpoints (k + 1,) [s] and coefficients (4, k, n) of a rest-to-rest motion from `start` to `goal` (n,).

    Each joint has seven phases of constant jerk, or fewer on a short way. All are slowed to the slowest joint's time.
    Where one motor drives several joints, all joints share one profile along the straight line. A joint without a jerk
    limit reaches its acceleration limit in 0.1 s. A motion to its start takes no time. Source: Biagiotti & Melchiorri,
    Trajectory Planning for Automatic Machines and Robots, §3.4.
    """
    way = goal - start
    if not way.any():
        return np.zeros(2), np.concatenate([np.zeros((3, 1, len(start))), start[None, None]])
    d, limits, direction = _profiled(way, bounds)
    breakpoints, coefficients = _profiles(d, *_phases(d, *limits))
    coefficients = coefficients * direction
    coefficients[-1] += start
    return breakpoints, coefficients


def double_s_durations(ways: Array, bounds: PathBounds) -> Array:
    """Durations (k,) [s] of the motions along ways (k, n) that are not zero."""
    d, limits, _ = _profiled(ways, bounds)
    jerk, hold, coast = _phases(d, *limits)
    durations: Array = (4.0 * jerk + 2.0 * hold + coast).max(axis=-1)
    return durations


def _profiled(way: Array, bounds: PathBounds) -> tuple[Array, tuple[Array, Array, Array], Array]:
    """Lengths d (..., p) of the p profiles along ways (..., n), limits of their rates, and the way per unit of d."""
    limits = bounds.velocity, bounds.acceleration, bounds.jerk
    rows = np.abs(bounds.C)
    with np.errstate(divide="ignore"):
        if (np.count_nonzero(rows, axis=1) > 1).any():
            share = np.abs(way @ bounds.C.T)
            V, A, J = ((limit / share).min(axis=-1, keepdims=True) for limit in limits)
            return np.ones_like(V), (V, A, J), way
        V, A, J = ((limit[:, None] / rows).min(axis=0) for limit in limits)
    return np.abs(way), (V, A, J), np.sign(way)


def _phases(d: Array, V: Array, A: Array, J: Array) -> tuple[Array, Array, Array]:
    """How long each joint's jerk, constant acceleration and constant velocity last, (n,) each [s]."""
    rise = A / J
    with np.errstate(invalid="ignore"):
        reaches_A = A * rise <= V
        jerk = np.where(reaches_A, rise, np.sqrt(V / J))
        hold = np.where(reaches_A, V / A - rise, 0.0)
        ramps = V * (2.0 * jerk + hold)
        coasts = d >= ramps
        speed = 2.0 * d * A / (A * rise + np.sqrt((A * rise) ** 2 + 4.0 * d * A))
        coast = np.where(coasts, (d - ramps) / V, 0.0)
    short = ~coasts & (speed < A * rise)
    jerk = np.where(coasts, jerk, np.where(short, np.cbrt(0.5 * d / J), rise))
    hold = np.where(coasts, hold, np.where(short, 0.0, speed / A - rise))
    return jerk, np.where(d > 0, hold, 0.0), coast


def _profiles(d: Array, jerk: Array, hold: Array, coast: Array) -> tuple[Array, Array]:
    """Breakpoints and coefficients for the distances d (n,) with these phases, slowed to one duration."""
    own = 4.0 * jerk + 2.0 * hold + coast
    whole, moves = float(own.max()), own > 0
    slower = whole / np.where(moves, own, 1.0)
    x, y, z = jerk * slower, hold * slower, np.where(moves, coast * slower, whole)
    ends = np.cumsum([x, y, x, z, x, y], axis=0)
    times = distinct_instants(np.vstack([np.zeros_like(d), ends, np.full_like(d, whole)]))
    phase = (0.5 * (times[:-1] + times[1:])[:, None, None] >= ends).sum(axis=1)
    a = d / np.where(moves, (x + y) * (2.0 * x + y + z), 1.0)
    # The greatest acceleration a is reached in x, so the third derivative is a / x; then three integrals.
    c3, h = SIGNS[phase] * (a / np.where(moves, x, 1.0)) / 6.0, np.diff(times)[:, None]
    c2 = _integrated(3.0 * c3 * h)
    c1 = _integrated((2.0 * c2 + 3.0 * c3 * h) * h)
    return times, np.stack([c3, c2, c1, _integrated((c1 + (c2 + c3 * h) * h) * h)])


def _integrated(steps: Array) -> Array:
    """The value at the beginning of each piece (k, n), 0 at the first, by the change on each."""
    return np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps[:-1], axis=0)])


def line_durations(ways: Array, bounds: PathBounds) -> Array:
    """Durations (k,) [s] of the shortest motions along ways (k, n) that are not zero, straight and from rest to rest.

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
