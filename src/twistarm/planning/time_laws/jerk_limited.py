"""The fastest motion along a path within velocity, acceleration and jerk: an interior-point method on a grid.

With x = ṡ² a row p = C q(s) moves with p' ṡ, p'' x + ½ p' x' and ṡ (p''' x + 3/2 p'' x' + ½ p' x''). The time Σ 2 h /
(ṡ_i + ṡ_(i+1)) is convex in x, velocity and acceleration are linear. The jerk's limit is |p''' x + …| ≤ limit / ṡ.
Source: Boyd & Vandenberghe, Convex Optimization, §11.3 (the logarithmic barrier).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...support.checks import Array
from ..joint_path import JointPath
from ..optional import scipy
from .bounds import PathBounds

INTERVALS, GRID_SAMPLES, ENDS = 400, 2000, 0.9
"""Intervals of the grid, samples to lay it out, and how much shorter its steps are at both ends."""

SHARPER, GAP, STEPS = 8.0, 1e-2, 16
"""Factor of the time's weight between stages, the barrier's final share of the time, and Newton steps per stage."""

SETTLED, INSIDE, HALVINGS = 1e-1, 0.95, 12
"""Newton decrement that ends a stage, greatest share of the way to the edge in a step, and most halvings of it."""

LARGEST = 1e12
"""The largest ṡ² where no velocity limits it."""

ROUNDS, CLOSE = 6, 1.01
"""Greatest number of motions, each with tighter limits where the last exceeded one, and the accepted excess."""

BEGIN, BEGIN_AGAIN = 0.5, 0.9
"""Share of the limits in use at the start of the first search, and of the others."""


Passes = Iterator[tuple[Array, Array]]


def fastest_passes(
    path: JointPath, bounds: PathBounds, excess: Callable[[Array, Array], tuple[Array, Array]], *, smooth_ends: bool
) -> Passes:
    """Places s and times t (N + 1,) of a nearly time-optimal rest-to-rest motion.

    Each motion is tighter where the last one exceeded a limit. `excess(s, t)` gives acceleration and jerk at each inner
    place, (N − 1,) each, relative to their limits. With `smooth_ends` the acceleration begins and ends with zero, else
    it may jump there.
    """
    s = _grid(path, bounds)
    problem = _Problem.of(path, bounds, s, smooth_ends)
    x, count = problem.begin(), problem.count()
    weight = count / problem.time(x)
    for _ in range(ROUNDS):
        while True:
            x = problem.centred(x, weight)
            if count / weight < GAP * problem.time(x):
                break
            weight *= SHARPER
        rate = np.sqrt(np.concatenate([[0.0], x, [0.0]]))
        durations = 2.0 * np.diff(s) / (rate[1:] + rate[:-1])
        if smooth_ends:  # s = j t³ / 6 = ṡ t / 3
            durations[[0, -1]] *= 1.5
        t = np.concatenate([[0.0], np.cumsum(durations)])
        yield s, t
        over = excess(s, t)
        if max(float(each.max()) for each in over) < CLOSE:
            return
        problem = problem.tightened(*over)
        x *= min(1.0, BEGIN_AGAIN * problem.room(x))
        weight /= SHARPER


def _grid(path: JointPath, bounds: PathBounds) -> Array:
    """Places (N + 1,) along the path: nearer together where it bends, and towards both ends."""
    s = np.linspace(0.0, path.length, GRID_SAMPLES + 1)
    limits = bounds.velocity, bounds.acceleration, bounds.jerk
    slow = sum(
        np.max(np.abs(path(s, order) @ bounds.C.T / limit), axis=1) ** (1.0 / order)
        for order, limit in enumerate(limits, 1)
    )
    near = np.ones(GRID_SAMPLES // 50) / (GRID_SAMPLES // 50)
    density = np.convolve(np.pad(slow, len(near), mode="edge"), near, mode="same")[len(near) : -len(near)]
    come = np.concatenate([[0.0], np.cumsum(density[1:] + density[:-1])])
    part = np.linspace(0.0, 1.0, INTERVALS + 1)
    part = ENDS * part**2 * (3.0 - 2.0 * part) + (1.0 - ENDS) * part
    return np.interp(part, come / come[-1], s)


@dataclass(frozen=True, eq=False)
class _Problem:
    """Steps h (N,), and factors of x before, at and after every inner place (r, N − 1, 3)."""

    h: Array
    shape: Array
    most: Array
    acceleration: Array
    jerk: Array
    smooth_ends: bool

    @classmethod
    def of(cls, path: JointPath, bounds: PathBounds, s: Array, smooth_ends: bool) -> _Problem:
        h = np.diff(s)
        a, b = h[:-1], h[1:]
        here = np.stack([np.zeros_like(a), np.ones_like(a), np.zeros_like(a)], axis=-1)
        slope = np.stack([-b / (a * (a + b)), (b - a) / (a * b), a / (b * (a + b))], axis=-1)
        bend = 2.0 * np.stack([1.0 / (a * (a + b)), -1.0 / (a * b), 1.0 / (b * (a + b))], axis=-1)
        p1, p2, p3 = ((path(s[1:-1], order) @ bounds.C.T).T[:, :, None] for order in (1, 2, 3))
        with np.errstate(divide="ignore"):
            most = ((bounds.velocity[:, None] / np.abs(p1[..., 0])) ** 2).min(axis=0, initial=LARGEST)
            if smooth_ends:  # s = j t³ / 6
                for end, step in ((0, h[0]), (-1, h[-1])):
                    j = float((bounds.jerk / np.abs(p1[:, end, 0])).min())
                    most[end] = min(most[end], (0.5 * j) ** 2 * (6.0 * step / j) ** (4.0 / 3.0))
        acceleration = (p2 * here + 0.5 * p1 * slope) / bounds.acceleration[:, None, None]
        limited = np.isfinite(bounds.jerk)
        jerk = (p3 * here + 1.5 * p2 * slope + 0.5 * p1 * bend)[limited] / bounds.jerk[limited, None, None]
        inner = s[1:-1] * (s[-1] - s[1:-1])
        return cls(h, (inner / inner.max()) ** (4.0 / 3.0), most, acceleration, jerk, smooth_ends)

    def count(self) -> int:
        """How many limits there are."""
        return 2 * (len(self.acceleration) + len(self.jerk) + 1) * len(self.shape)

    def tightened(self, acceleration: Array, jerk: Array) -> _Problem:
        """The problem with tighter limits at each inner place (N − 1,)."""
        tight = [np.maximum(each, 1.0)[:, None] for each in (acceleration, jerk)]
        most = self.most.copy()
        if self.smooth_ends:
            most[[0, -1]] /= tight[1][[0, -1], 0] ** (2.0 / 3.0)
        return replace(self, most=most, acceleration=self.acceleration * tight[0], jerk=self.jerk * tight[1])

    def begin(self) -> Array:
        """x (N − 1,) well inside the limits."""
        return self.shape * BEGIN * self.room(self.shape)

    def room(self, x: Array) -> float:
        """By what x (N − 1,) may be multiplied, to just keep all limits."""
        share = max(float((x / self.most).max()), float(np.abs(_rows(self.acceleration, x)).max()))
        sharp = float((np.abs(_rows(self.jerk, x)) * np.sqrt(x)).max(initial=0.0))
        return float(1.0 / max(share, sharp ** (2.0 / 3.0)))

    def time(self, x: Array) -> float:
        rate = np.sqrt(np.concatenate([[0.0], x, [0.0]]))
        return float((2.0 * self.h / (rate[1:] + rate[:-1])).sum())

    def value(self, x: Array, weight: float) -> float:
        """weight · time − Σ log of what is left of each limit; inf outside."""
        if not ((x > 0.0) & (x < self.most)).all():
            return np.inf
        left = 1.0 - _rows(self.acceleration, x) ** 2, 1.0 / x - _rows(self.jerk, x) ** 2
        if not all((each > 0.0).all() for each in left):
            return np.inf
        logs = sum(float(np.log(each).sum()) for each in (*left, x, self.most - x))
        return weight * self.time(x) - logs

    def centred(self, x: Array, weight: float) -> Array:
        """The least of `value`, by Newton's method with the convex, banded part of its Hessian."""
        solve = scipy("linalg").solveh_banded
        value = self.value(x, weight)
        for _ in range(STEPS):
            gradient, bands = self._derivatives(x, weight)
            step = -solve(bands, gradient)
            decrement, part = -float(gradient @ step), 1.0
            for _ in range(HALVINGS):
                moved = self.value(x + part * step, weight)
                if moved <= value - 0.01 * part * decrement:
                    break
                part *= 0.5
            else:
                return x
            x, value = x + part * step, moved
            if decrement < SETTLED:
                return x
        return x

    def _derivatives(self, x: Array, weight: float) -> tuple[Array, Array]:
        n = len(x)
        first, second = np.zeros((n, 3)), np.zeros((n, 3, 3))
        rate = np.sqrt(np.concatenate([[0.0], x, [0.0]]))
        total = rate[1:] + rate[:-1]
        by, twice = weight * self.h / total**2, weight * self.h / total**3
        r = rate[1:-1]
        first[:, 1] = -(by[:-1] + by[1:]) / r - 1.0 / x + 1.0 / (self.most - x)
        second[:, 1, 1] = (twice[:-1] + twice[1:]) / x + 0.5 * (by[:-1] + by[1:]) / r**3
        second[:, 1, 1] += 1.0 / x**2 + 1.0 / (self.most - x) ** 2
        mixed = twice[1:-1] / (r[:-1] * r[1:])
        second[:-1, 1, 2] += mixed

        one, none = np.ones(n), np.zeros(n)
        for taps, room, falls in ((self.acceleration, one, none), (self.jerk, 1.0 / np.sqrt(x), -0.5 * x**-1.5)):
            e = _rows(taps, x)
            left = room**2 - e**2
            own, cross = 2.0 * (room**2 + e**2) / left**2, -4.0 * e * room / left**2
            first += np.einsum("rn,rna->na", 2.0 * e / left, taps)
            first[:, 1] -= (2.0 * room / left).sum(0) * falls
            second += np.einsum("rn,rna,rnb->nab", own, taps, taps)
            bent = np.einsum("rn,rna->na", cross, taps) * falls[:, None]
            second[:, 1, :] += bent
            second[:, :, 1] += bent
            second[:, 1, 1] += own.sum(0) * falls**2
        gradient, bands = first[:, 1].copy(), np.zeros((3, n))
        gradient[:-1] += first[1:, 0]
        gradient[1:] += first[:-1, 2]
        bands[2] = second[:, 1, 1]
        bands[2, :-1] += second[1:, 0, 0]
        bands[2, 1:] += second[:-1, 2, 2]
        bands[1, 1:] = second[:-1, 1, 2] + second[1:, 0, 1]
        bands[0, 2:] = second[1:-1, 0, 2]
        return gradient, bands


def _rows(taps: Array, x: Array) -> Array:
    """The rows (r, N − 1) that these taps make of x, zero at both ends."""
    padded = np.concatenate([[0.0], x, [0.0]])
    return taps[..., 0] * padded[:-2] + taps[..., 1] * padded[1:-1] + taps[..., 2] * padded[2:]
