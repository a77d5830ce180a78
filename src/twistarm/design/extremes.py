"""Random configurations with the extreme ones near them, inside the limits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array

STARTS, ROUNDS = 4, 24
"""Samples from which each cost descends, and its steps: they begin at a quarter of the range."""


def with_extremes(arm: Arm, costs: Callable[[Array], Array], theta: Array) -> Array:
    """Theta (s, n), and below it local minima of each of the `costs`, (..., n) to (..., c), to 1e-3 of the range.

    A cost descends from its least samples by the best step along one joint, halved where none helps.
    """
    lower, upper = arm.sampling_bounds
    moves = np.vstack([np.zeros(arm.n), np.eye(arm.n), -np.eye(arm.n)]) * (upper - lower) / 4
    starts = costs(theta).argsort(axis=0)[:STARTS]
    x, column = theta[starts.ravel()], np.tile(np.arange(starts.shape[1]), len(starts))
    size, each = np.ones(len(x)), np.arange(len(x))
    for _ in range(ROUNDS):
        tried = np.clip(x[:, None] + size[:, None, None] * moves, lower, upper)
        best = costs(tried)[each, :, column].argmin(axis=1)
        x = tried[each, best]
        size[best == 0] /= 2
    return np.vstack([theta, x])
