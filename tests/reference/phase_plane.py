"""The fastest motion along a path, by phase space, and nothing of twistarm's."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np


def least_time(
    path: Callable[[np.ndarray, int], np.ndarray], length: float, velocity: float, acceleration: float
) -> float:
    """The least time along path(s, order), s from 0 to `length`, from rest to rest (Bobrow 1985): a backward and a
    forward pass over ṡ² with the limits at grid points alone, a lower bound but for the grid."""
    s = np.linspace(0.0, length, 4_001)
    h, tangent, bend = s[1], path(s, 1), path(s, 2)
    cap = ((velocity / np.abs(tangent)) ** 2).min(-1)

    def range_of(i: int, x: float) -> tuple[float, float]:
        ends = (np.array([[-acceleration], [acceleration]]) - bend[i] * x) / tangent[i]
        return float(ends.min(0).max()), float(ends.max(0).min())

    # Where the ranges of s̈ do not meet, x is too large: the velocity limit curve of the acceleration, by bisection.
    low, high = np.zeros_like(cap), cap.copy()
    for _ in range(60):
        middle = 0.5 * (low + high)
        ends = (np.array([-acceleration, acceleration])[:, None, None] - bend * middle[:, None]) / tangent
        fits = ends.min(0).max(-1) <= ends.max(0).min(-1)
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    x = low
    for order in (range(len(s) - 2, -1, -1), range(1, len(s))):
        backwards = order.step < 0
        previous = 0.0
        x[-1 if backwards else 0] = 0.0
        for i in order:
            least, most = range_of(i + 1 if backwards else i - 1, previous)
            x[i] = min(x[i], previous + 2.0 * h * (-least if backwards else most))
            previous = x[i] = max(x[i], 0.0)
    speed = np.sqrt(x)
    return float((2.0 * h / (speed[1:] + speed[:-1])).sum())
