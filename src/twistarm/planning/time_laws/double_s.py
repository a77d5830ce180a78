"""Double-S profiles: the shortest rest-to-rest motion within velocity, acceleration and jerk, in closed form."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from .bounds import PathBounds
from .law import apart


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
    whole = float(own.max())
    moves = own > 0
    slower = whole / np.where(moves, own, 1.0)
    x, y, z = jerk * slower, hold * slower, np.where(moves, coast * slower, whole)
    knots = np.zeros((8, len(d)))
    np.cumsum([x, y, x, z, x, y], axis=0, out=knots[1:7])
    knots[7] = whole
    a = d / np.where(moves, (x + y) * (2.0 * x + y + z), 1.0)
    j = a / np.where(moves, x, 1.0) / 6.0
    v1, v2, v3 = 0.5 * a * x, a * (0.5 * x + y), a * (x + y)
    p1 = a * x * x / 6.0
    p2 = p1 + (v1 + 0.5 * a * y) * y
    p3 = p2 + (v2 + a * x / 3.0) * x
    o, half = np.zeros_like(d), 0.5 * a
    phases = np.array(
        [
            [j, o, -j, o, -j, o, j],
            [o, half, half, o, o, -half, -half],
            [o, v1, v2, v3, v3, v2, v1],
            [o, p1, p2, p3, d - p3, d - p2, d - p1],
        ]
    )
    times = apart(knots)
    middle = 0.5 * (times[:-1] + times[1:])
    phase = (middle[:, None, None] >= knots[1:7]).sum(axis=1)
    joint = np.arange(len(d))
    c3, c2, c1, c0 = phases[:, phase, joint]
    tau = times[:-1, None] - knots[phase, joint]
    bent = c3 * tau
    return times, np.array(
        [c3, c2 + 3.0 * bent, c1 + tau * (2.0 * c2 + 3.0 * bent), c0 + tau * (c1 + tau * (c2 + bent))]
    )
