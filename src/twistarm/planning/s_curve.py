"""Motions of limited jerk: the s-curve law along a path, and double-S profiles in closed form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..support.checks import Array
from .piecewise import Indices, JointPath, bernstein, bisected, derivative, evaluate
from .time_law import PathBounds, TimeLaw, distinct_instants
from .time_optimal import LimitedPath, durations_of, first_grid, law_of, path_velocity, shares_of_average
from .torque_limits import grid_rows
from .within import require_span

# Window widths to try, as multiples of the rise time of the slowest rate to its acceleration limit. The first is the
# best of most paths.
WINDOWS = (2.0, 1.0, 2.8)
# Greatest number of laws for each width; so many in a row that are not shorter by this share end it.
ROUNDS, PATIENCE, GAIN = 8, 4, 5e-3
FAR = 1.2  # A width is left when its law takes longer than the shortest by this factor, or is behind and gains nothing.
# Laws along so many pieces take long, and change little from one to the next: the first without a gain ends it.
MANY_PIECES = 900
# A ceiling is divided by this power of the piece's need of slowing, which counts within these bounds.
POWER, LEAST, MOST = 0.7, 0.9, 1.2
HEADROOM = 1.05  # A ceiling is at most the speed by this factor, so that it may rise again.
# Share of the jerk for the bend of the path. The rest is for changes of the acceleration along it.
BEND_SHARE = 0.9
PIECES = 64  # Least number of pieces of the path, so that a ceiling is low only in a short part.
ORDERS = np.array([[1.0], [2.0], [3.0]])  # Of the rates: a law slowed by f has 1/f^order of each.
BISECTIONS = 60  # To find when a place is reached, to rounding.
# The jerk in the seven phases of a double-S profile, as a share of its greatest.
SIGNS: Array = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])


def s_curve(path: JointPath, bounds: PathBounds) -> TimeLaw:
    """A law of limited jerk that keeps every limit, with zero velocity and acceleration at both ends.

    A moving average of the time-optimal law limits the jerk. Its greatest jerk is the jump of the acceleration over the
    window's width. Some widths are tried. Ceilings of ṡ fall where the law exceeds a limit, and rise where it uses
    none. So the whole comes near its limits everywhere. The shortest of all laws is then slowed as a whole to its exact
    extremes. A joint or motor without a jerk limit reaches its acceleration limit in 0.1 s. `double_s` is shorter from
    rest to rest in a straight line. A path without motion takes no time. Raises InputError as `time_optimal` does.
    """
    if not path.moves:
        return TimeLaw.at_once()
    fine, piece = path.in_pieces(path.length / PIECES)
    bounds = bounds.capped(bounds.ceiling_of(path)[piece])
    limited, grid, jerk = LimitedPath.of(fine, bounds), first_grid(fine.breakpoints), np.ascontiguousarray(bounds.jerk)
    rows = grid_rows(bounds.torques, fine, grid)
    first = _ceiling(fine, bounds)
    limits = np.isfinite(bounds.acceleration)
    rise = float((bounds.acceleration[limits] / bounds.jerk[limits]).max())  # of the slowest rate to its limit [s]
    best, shortest = None, np.inf
    for window in rise * np.array(WINDOWS):
        ceiling, least, vain = first, np.inf, 0
        for _ in range(ROUNDS):
            x = path_velocity(replace(limited, ceiling=ceiling), grid, rows).x
            passing = float(durations_of(grid, x).sum()) + window
            require_span(passing)
            shares, speed = shares_of_average(limited, grid, rows, x, jerk, window)
            factor = np.max([*shares ** (1.0 / ORDERS), speed / bounds.ceiling_of(fine)], axis=0)
            duration = passing * float(factor.max())  # once it is slowed as a whole
            if duration < shortest:
                best, shortest = (x, window), duration
            vain = 0 if duration < least * (1.0 - GAIN) else vain + 1
            least = min(least, duration)
            patience = PATIENCE if least <= shortest and len(piece) < MANY_PIECES else 1
            if vain >= patience or duration > FAR * shortest:
                break
            reached = np.where(speed > 0.0, HEADROOM * speed, np.inf)  # a law may pass a tiny piece between samples
            ceiling = np.minimum(ceiling, reached) / np.clip(factor, LEAST, MOST) ** POWER
            ceiling = np.minimum(ceiling, bounds.ceiling_of(fine))
    assert best is not None
    x, window = best
    return _smoothed(law_of(grid, x), window, fine).at_full_pace(fine, bounds, bounds.jerk)


def _ceiling(path: JointPath, bounds: PathBounds) -> Array:
    """The greatest ṡ on each piece (m,): in sharp bends |C d³q/ds³| ṡ³ has its share of the jerk."""
    sharp = np.abs(bernstein(derivative(path.coefficients, 3), np.diff(path.breakpoints)) @ bounds.C.T).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slow = np.cbrt(BEND_SHARE * bounds.jerk / sharp)
    return np.asarray(np.fmin(bounds.ceiling_of(path), np.fmin.reduce(slow, axis=1)))


def _smoothed(law: TimeLaw, window: float, path: JointPath) -> TimeLaw:
    """s_w(t) = (1/w) ∫ s(τ) dτ over [t − w, t]. It is longer by the window w [s], and of one degree more.

    Its rate is (s(t) − s(t − w))/w ≥ 0. Further derivatives are difference quotients too. Where s̈ jumps, s̈_w rises
    evenly. It is zero at both ends. Pieces end where the path's do.
    """
    average = _Average(law, window)
    times = distinct_instants(np.concatenate([average.knots, _reached(average, path.breakpoints[1:-1])]))
    return TimeLaw(times, average.pieces(times))


class _Average:
    """The moving average of a law of parabolas, at rest before and after it."""

    def __init__(self, law: TimeLaw, window: float) -> None:
        steps, c = np.diff(law.breakpoints), law.coefficients
        powers = np.arange(len(c), 0, -1.0)
        integral = np.concatenate([c / powers[:, None], np.zeros((1, c.shape[1]))])
        integral[-1, 1:] = np.cumsum(np.polyval(integral, steps))[:-1]
        end = float(np.polyval(c[:, -1], steps[-1])), float(np.polyval(integral[:, -1], steps[-1]))
        before, after = np.zeros((len(integral), 1)), np.zeros((len(integral), 1))
        after[-2:, 0] = end
        self.integral = np.concatenate([before, integral, after], axis=1)[:, :, None]
        self.starts = np.concatenate([[0.0], law.breakpoints])
        self.window = window
        self.knots = distinct_instants(np.concatenate([law.breakpoints, law.breakpoints + window]))

    def pieces(self, times: Array) -> Array:
        """Coefficients (degree + 2, k) on the pieces between these times (k + 1,), which hold every knot."""
        middle, starts = 0.5 * (times[:-1] + times[1:]), times[:-1]
        now, before = self._piece(middle), self._piece(middle - self.window)
        at = (now, starts - self.starts[now]), (before, starts - self.window - self.starts[before])
        rows, factorial = [], 1.0
        for order in range(len(self.integral)):
            factorial *= max(order, 1)
            rate = derivative(self.integral, order)
            late, early = (evaluate(rate[:, i], tau[:, None])[:, 0] for i, tau in at)
            rows.append((late - early) / self.window / factorial)
        return np.stack(rows[::-1])

    def _piece(self, times: Array) -> Indices:
        return np.searchsorted(self.starts[1:], times, side="right")


def _reached(average: _Average, places: Array) -> Array:
    """When the average passes these places of the path."""
    times = average.knots
    pieces = average.pieces(times)
    index = np.clip(np.searchsorted(pieces[-1], places, side="right") - 1, 0, len(times) - 2)
    own, ends = pieces[:, index], np.diff(times)[index]
    _, late = bisected(lambda tau: evaluate(own, tau) < places, np.zeros_like(places), ends, BISECTIONS)
    return times[index] + late


def double_s(start: Array, goal: Array, bounds: PathBounds, straight: bool = False) -> tuple[Array, Array]:
    """Breakpoints (k + 1,) [s] and coefficients (4, k, n) of a rest-to-rest motion from `start` to `goal` (n,).

    Each joint has seven phases of constant jerk, or fewer on a short way. All are slowed to the slowest joint's time.
    With `straight`, or where one motor drives several joints, all joints share one profile along the straight line. A
    joint without a jerk limit reaches its acceleration limit in 0.1 s. A motion to its start takes no time. Source:
    Biagiotti & Melchiorri, Trajectory Planning for Automatic Machines and Robots, §3.4.
    """
    way = goal - start
    if not way.any():
        return np.zeros(2), np.concatenate([np.zeros((3, 1, len(start))), start[None, None]])
    d, limits, direction = _profiled(way, bounds, straight)
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


def _profiled(
    way: Array, bounds: PathBounds, straight: bool = False
) -> tuple[Array, tuple[Array, Array, Array], Array]:
    """Lengths d (..., p) of the p profiles along ways (..., n), limits of their rates, and the way per unit of d."""
    limits = bounds.velocity, bounds.acceleration, bounds.jerk
    rows = np.abs(bounds.C)
    with np.errstate(divide="ignore"):
        if straight or (np.count_nonzero(rows, axis=1) > 1).any():
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
