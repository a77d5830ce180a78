"""A motion at sampled times for the saved page, which interpolates between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..parts.limit_checks import checked_theta

SAMPLE_TIME = 1.0 / 30.0
"""Between samples [s] the page interpolates, so the eye sees no steps."""

MOST_SAMPLES = 2000
"""A longer motion is sampled more coarsely: the file stays within a megabyte."""

DECIMALS = 9
"""Of rad and m."""

Samples = dict[str, Any]
"""times (k,) [s] and theta (k, n)."""


def standing(theta: Array) -> Samples:
    """One moment: the arm at theta (n,)."""
    return {"times": [0.0], "theta": [theta.tolist()]}


def moving(arm: Arm, trajectory: Trajectory) -> Samples:
    """`trajectory` from its start to its end."""
    times = _times(float(trajectory.duration))
    theta = [np.round(checked_theta(arm, trajectory(t)), DECIMALS).tolist() for t in times]
    return {"times": times.tolist(), "theta": theta}


def _times(duration: float) -> Array:
    count = min(MOST_SAMPLES, 1 + int(np.ceil(duration / SAMPLE_TIME)))
    return np.asarray(np.linspace(0.0, duration, max(2, count) if duration > 0 else 1), dtype=np.float64)
