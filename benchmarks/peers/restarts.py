"""Restarts for libraries that offer one step of inverse kinematics and leave the loop to the caller."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np

TOLERANCE = 1e-6  # Position [m] and rotation [rad].
ITERATIONS, SECONDS = 30, 0.1  # Of one search, and of one call.

SETTINGS = f"{ITERATIONS} iterations, then a random start; {1e3 * SECONDS:.0f} ms at most"

# From a start to where the search ended, and whether it met the target.
Search = Callable[[np.ndarray], tuple[np.ndarray, bool]]


class Restarts:
    """`search` from the caller's start, then from random ones inside the limits, until the time is over."""

    def __init__(self, lower: list[float], upper: list[float]) -> None:
        self.lower, self.upper = np.array(lower), np.array(upper)
        self.rng = np.random.default_rng(0)

    def until_met(self, search: Search, start: np.ndarray) -> tuple[np.ndarray, bool]:
        end = perf_counter() + SECONDS
        theta, met = search(start)
        while not met and perf_counter() < end:
            theta, met = search(self.rng.uniform(self.lower, self.upper))
        return theta, met


def met(error: np.ndarray) -> bool:
    """Whether a twist (v, w) of error is within the tolerance."""
    return bool(error[:3] @ error[:3] <= TOLERANCE**2 and error[3:] @ error[3:] <= TOLERANCE**2)
