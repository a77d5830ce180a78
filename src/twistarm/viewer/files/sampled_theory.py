"""Theory numbers along a motion for the saved page, fewer and rounder than live ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ..parts.theory import axes
from ..parts.theory_numbers import numbers

MOST = 250
"""Moments of a motion: with seven joints some 600 kB."""

PER_SECOND = 15.0

DECIMALS = 6


def recorded(arm: Arm, theta: Array, trajectory: Trajectory | None) -> dict[str, Any]:
    """The axes, times (k,) [s], the numbers at each time, and `aside`, the numbers at theta (n,).

    `moved` is the fastest joint at that moment, with metres divided by the reach.
    """
    there = rounded({"moved": 0, **numbers(arm, theta)})
    if trajectory is None:
        return {"axes": axes(arm), "times": [0.0], "numbers": [there], "aside": there}
    duration = float(trajectory.duration)
    times = np.linspace(0.0, duration, min(MOST, 2 + int(duration * PER_SECOND)))
    length = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    found = []
    for at, rates in zip(trajectory(times), trajectory(times, 1), strict=True):
        fastest = int(np.argmax(np.abs(rates) / length))
        found.append(rounded({"moved": fastest, **numbers(arm, at, rates)}))
    return {"axes": axes(arm), "times": rounded(times.tolist()), "numbers": found, "aside": there}


def rounded(value: Any) -> Any:
    """`value` with every float in it to `DECIMALS`; what is whole is written so."""
    if isinstance(value, float):
        near = round(value, DECIMALS)
        return int(near) if near.is_integer() else near
    if isinstance(value, dict):
        return {name: rounded(each) for name, each in value.items()}
    return [rounded(each) for each in value] if isinstance(value, list) else value
