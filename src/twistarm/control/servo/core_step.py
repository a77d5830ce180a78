"""The answer of the compiled servo step as plain numbers, and the codes for its reason."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from ...support.checks import Array

STATUSES = (
    "OK", "SLOWED_SINGULARITY", "SLOWED_LIMIT", "HALTED_LIMIT", "IMPOSSIBLE_DIRECTION", "STALE", "SLOWED_COLLISION",
    "HALTED_COLLISION",
)  # fmt: skip
"""Codes for how a step went. A setpoint line on a serial port has their number."""


class ServoReason(Enum):
    """Why a step did what it did. The name is a code that stays; the numbers are fields of the output.

    status: how a step with this reason went while the arm moves. words: the reason in general.
    """

    MOVING = "OK", "moving as commanded"
    CHANGING_SPEED = "OK", "changing speed, as fast as the acceleration limits allow"
    VELOCITY_LIMIT = "SLOWED_LIMIT", "slowed by a velocity limit"
    LOWER_LIMIT = "SLOWED_LIMIT", "a joint or motor is at its lower position limit, or brakes toward it"
    UPPER_LIMIT = "SLOWED_LIMIT", "a joint or motor is at its upper position limit, or brakes toward it"
    SINGULARITY = "SLOWED_SINGULARITY", "a direction of the command is nearly lost in this configuration"
    TURN_LOST = "OK", "the tool turns otherwise than commanded, because the arm has too few joints"
    IMPOSSIBLE = "IMPOSSIBLE_DIRECTION", "this arm has no such motion"
    STALE = "STALE", "no usable command or state: coming to rest"
    COLLISION = "SLOWED_COLLISION", "two bodies of the scene come near each other"

    def __init__(self, status: str, words: str) -> None:
        self.status, self.words = status, words


OF_CAUSE = (
    ServoReason.MOVING, ServoReason.SINGULARITY, ServoReason.VELOCITY_LIMIT, ServoReason.LOWER_LIMIT,
    ServoReason.UPPER_LIMIT, ServoReason.STALE, ServoReason.COLLISION,
)  # fmt: skip
"""The reason for each `servo_cause` of the core, in its order."""


@dataclass(eq=False)
class CoreStep:
    """theta, theta_dot (n,): the state after the step. period [s]: the mean step time after this one.

    row: the row of `ServoBounds.motion` at its limit, the row of near pairs, or the joint of a singularity; −1 for
    none.
    """

    theta: Array
    theta_dot: Array
    reason: ServoReason
    row: int
    scale: float = 1.0
    lost: Array = field(default_factory=lambda: np.zeros(6))
    lost_share: float = 0.0
    held: Array | None = None
    halted: bool = False
    remaining: tuple[float, float] = (0.0, 0.0)
    period: float = 0.0
