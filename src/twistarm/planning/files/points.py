"""The points of a motion as they stand in a file."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ...support.checks import Array


class Points(NamedTuple):
    """k instants t (k,) [s] with the arm's joints (k, n), rates and accelerations where the file has them.

    `place(i)` says where point i stands in the file.
    """

    t: Array
    labels: list[tuple[float, str]]
    place: Callable[[int], str]
    theta: Array
    theta_dot: Array | None = None
    theta_ddot: Array | None = None
