"""The answer of one servo step as plain numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from ...support.checks import Array


class Cause(IntEnum):
    """What holds the arm back most."""

    NONE = 0
    SINGULARITY = 1
    VELOCITY = 2
    LOWER = 3
    UPPER = 4
    UNUSABLE = 5


@dataclass(eq=False)
class Answer:
    """theta, theta_dot (n,): the state after the step. period [s]: the mean step time after this one.

    row: the limiting row of `Bounds.motion`, or the joint of a singularity; −1 for none.
    """

    theta: Array
    theta_dot: Array
    cause: Cause
    row: int
    scale: float = 1.0
    lost: Array = field(default_factory=lambda: np.zeros(6))
    lost_share: float = 0.0
    held: Array | None = None
    halted: bool = False
    remaining: tuple[float, float] = (0.0, 0.0)
    period: float = 0.0
