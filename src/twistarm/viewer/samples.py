"""An arm at moments in time, as the stand-alone page is given them: it interpolates between two."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from .. import rotations
from ..arm import Arm
from ..checks import Array
from ..planning.trajectory import Trajectory
from .admission import checked_theta
from .placement import Placement

SAMPLE_TIME = 1.0 / 30.0
"""Between samples [s] the page interpolates, so the eye sees no steps."""

MOST_SAMPLES = 2000
"""A longer motion is sampled more coarsely: the file stays within a few megabytes."""

DECIMALS = 6
"""Positions to a micrometre, quaternions to a microradian."""

Samples = dict[str, Any]
"""times (k,) [s], theta (k, n), others, tool, and per node (k, 7): position [m], quaternion (x, y, z, w)."""


def standing(arm: Arm, theta: Array, others: Mapping[str, float]) -> Samples:
    """One moment: the arm at theta (n,)."""
    return _sampled(arm, np.zeros(1), [theta], others)


def moving(arm: Arm, trajectory: Trajectory, others: Mapping[str, float]) -> Samples:
    """`trajectory` from its start to its end."""
    times = _times(float(trajectory.duration))
    return _sampled(arm, times, [checked_theta(arm, trajectory(t)) for t in times], others)


def _sampled(arm: Arm, times: Array, thetas: Iterable[Array], others: Mapping[str, float]) -> Samples:
    placement = Placement(arm)
    placed = [placement.at(theta, others) for theta in thetas]
    return {
        "times": times.tolist(),
        "theta": [_rounded(frame["theta"]) for frame in placed],
        "others": dict(others),
        "tool": [frame["tool"] for frame in placed],
        "nodes": {path: [_seven(frame["transforms"][path]) for frame in placed] for path in placed[0]["transforms"]},
    }


def _times(duration: float) -> Array:
    count = min(MOST_SAMPLES, 1 + int(np.ceil(duration / SAMPLE_TIME)))
    return np.asarray(np.linspace(0.0, duration, max(2, count) if duration > 0 else 1), dtype=np.float64)


def _seven(numbers: list[float]) -> list[float]:
    """Position and quaternion (x, y, z, w) of a matrix given by columns."""
    g = np.array(numbers).reshape(4, 4).T
    return _rounded(np.concatenate([g[:3, 3], rotations.to_xyzw(g[:3, :3])]))


def _rounded(values: Any) -> list[float]:
    numbers: list[float] = np.round(values, DECIMALS).tolist()
    return numbers
