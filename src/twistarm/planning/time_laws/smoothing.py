"""A law's moving average: its jerk is bounded, and it stays monotone."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ..joint_path import Indices, JointPath
from ..piecewise import bisected, derivative, evaluate
from .law import TimeLaw, apart

BISECTIONS = 60
"""To find when a place is reached, to rounding."""


def smoothed(law: TimeLaw, window: float, path: JointPath) -> TimeLaw:
    """s_w(t) = (1/w) ∫ s(τ) dτ over [t − w, t] is longer by the window w [s], and of one degree more.

    Its rate is (s(t) − s(t − w))/w ≥ 0. Further derivatives are difference quotients too. Where s̈ jumps, s̈_w rises
    evenly. It is zero at both ends. Pieces end where the path's do.
    """
    average = _Average(law, window)
    return average.law(_reached(average, path.breakpoints[1:-1]))


def roughly_smoothed(law: TimeLaw, window: float, path: JointPath) -> TimeLaw:
    """The same law in pieces that end only about where the path's do."""
    average = _Average(law, window)
    return average.law(np.interp(path.breakpoints[1:-1], average.at(average.knots), average.knots))


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
        self.knots = apart(np.concatenate([law.breakpoints, law.breakpoints + window]))

    def law(self, instants: Array) -> TimeLaw:
        """The average as a law with ends of pieces at these instants too."""
        times = apart(np.concatenate([self.knots, instants]))
        return TimeLaw(times, self.pieces(times))

    def at(self, times: Array) -> Array:
        """s_w at some of the knots."""
        return self._quotient(times, self._piece(times), self._piece(times - self.window), 0)

    def pieces(self, times: Array) -> Array:
        """Coefficients (degree + 2, k) on the pieces between these times (k + 1,), which hold every knot."""
        middle, starts = 0.5 * (times[:-1] + times[1:]), times[:-1]
        now, before = self._piece(middle), self._piece(middle - self.window)
        rows, factorial = [], 1.0
        for order in range(len(self.integral)):
            factorial *= max(order, 1)
            rows.append(self._quotient(starts, now, before, order) / factorial)
        return np.stack(rows[::-1])

    def _quotient(self, times: Array, now: Indices, before: Indices, order: int) -> Array:
        coefficients = derivative(self.integral, order)
        tau = times - self.starts[now], times - self.window - self.starts[before]
        late, early = (evaluate(coefficients[:, i], t[:, None])[:, 0] for i, t in zip((now, before), tau, strict=True))
        return (late - early) / self.window

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
