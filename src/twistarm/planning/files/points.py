"""The points of a motion as a file holds them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...support.checks import Array


class Points(NamedTuple):
    """k instants t (k,) [s] of n joints (k, n). Rates and accelerations are optional.

    `place(i)` tells the place of point i in the file.
    """

    t: Array
    labels: list[tuple[float, str]]
    place: Callable[[int], str]
    theta: Array
    theta_dot: Array | None = None
    theta_ddot: Array | None = None
