"""Samples of a motion for the stand-alone page: joint values and the numbers of the theory."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..parts.theory import axes, numbers

SAMPLE_TIME = 1.0 / 30.0
"""Time between samples [s]. The page interpolates between them."""

MOST_SAMPLES = 2000
"""Most samples of a motion, which keep the file within a megabyte."""

DECIMALS = 9
"""Decimals of values in rad and m."""

MOST_NUMBERS = 250
"""Most samples with numbers of the theory: some 600 kB for seven joints."""

NUMBERS_PER_SECOND = 15.0

NUMBER_DECIMALS = 6


def moving(trajectory: Trajectory) -> dict[str, Any]:
    """times (k,) [s] and theta (k, n): `trajectory` from its start to its end."""
    times = _times(float(trajectory.duration))
    return {"times": times.tolist(), "theta": np.round(trajectory(times), DECIMALS).tolist()}


def _times(duration: float) -> Array:
    count = min(MOST_SAMPLES, 1 + int(np.ceil(duration / SAMPLE_TIME)))
    return np.asarray(np.linspace(0.0, duration, max(2, count) if duration > 0 else 1), dtype=np.float64)


def recorded(arm: Arm, theta: Array, trajectory: Trajectory | None) -> dict[str, Any]:
    """The axes, times (k,) [s], the numbers at each, and `aside`, those at the shown theta (n,).

    `moved`: the joint that is fastest at that moment, metres measured in the reach.
    """
    there = rounded({"moved": 0, **numbers(arm, theta)})
    if trajectory is None:
        return {"axes": axes(arm), "times": [0.0], "numbers": [there], "aside": there}
    duration = float(trajectory.duration)
    times = np.linspace(0.0, duration, min(MOST_NUMBERS, 2 + int(duration * NUMBERS_PER_SECOND)))
    length = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    found = []
    for at, rates in zip(trajectory(times), trajectory(times, 1), strict=True):
        fastest = int(np.argmax(np.abs(rates) / length))
        found.append(rounded({"moved": fastest, **numbers(arm, at, rates)}))
    return {"axes": axes(arm), "times": rounded(times.tolist()), "numbers": found, "aside": there}


def rounded(value: Any) -> Any:
    """`value` with every float in it to `NUMBER_DECIMALS`; what is whole is written so."""
    if isinstance(value, float):
        near = round(value, NUMBER_DECIMALS)
        return int(near) if near.is_integer() else near
    if isinstance(value, dict):
        return {name: rounded(each) for name, each in value.items()}
    return [rounded(each) for each in value] if isinstance(value, list) else value
