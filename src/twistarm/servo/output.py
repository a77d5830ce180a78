"""What one step of a servo answers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from ..brief import Brief
from ..checks import Array, frozen
from .answer import Answer, Cause
from .bounds import Bounds


class ServoStatus(Enum):
    """How a step went; the gravest that holds."""

    OK = "moving as commanded"
    SLOWED_SINGULARITY = "slowed near a singularity"
    SLOWED_LIMIT = "slowed by a limit"
    HALTED_LIMIT = "halted by a position limit"
    STALE = "no usable command or state: coming to rest"


_STATUS = {
    Cause.NONE: ServoStatus.OK,
    Cause.SINGULARITY: ServoStatus.SLOWED_SINGULARITY,
    Cause.VELOCITY: ServoStatus.SLOWED_LIMIT,
    Cause.LOWER: ServoStatus.SLOWED_LIMIT,
    Cause.UPPER: ServoStatus.SLOWED_LIMIT,
}

_WORDS = {Cause.VELOCITY: "velocity", Cause.LOWER: "lower position", Cause.UPPER: "upper position"}

WORTH_SAYING = 0.02
"""Of the command: a smaller loss is not put into words."""

_NOTHING_LOST = frozen(np.zeros(6))


@dataclass(frozen=True, eq=False, repr=False)
class ServoOutput(Brief):
    """What one step answers.

    theta_dot (n,) [rad/s, m/s]: the joint rates for the coming dt.
    scale: how much of the reachable part of the command is done, 1 − |done − reachable| over the longer of the two, at
    least 0: less than 1 while the arm speeds up or still moves otherwise, and where a limit or a singularity slows it.
    lost_twist (6,) [m/s, rad/s]: the part of the command that the arm cannot do here at any speed, because it has no
    motion for it, is near a singularity, or a joint is at its end or brakes toward it, in the axes of the
    command's frame: at an even speed the tool moves by scale · (twist − lost_twist). Where the tool must turn so that
    it can go where it is told, that rotation stands in it too, with the opposite sign.
    lost_share: |lost_twist| / |twist|, metres measured in the length.
    joint: the one, or the motor, that a limit or a singularity concerns most, if any.
    remaining: how far a `PoseCommand` still is from its pose, [m] and [rad]; zeros for any other command.
    """

    theta_dot: Array
    status: ServoStatus
    scale: float
    lost_twist: Array
    lost_share: float
    joint: str | None
    remaining: tuple[float, float]
    _why: str | Cause

    @property
    def reason(self) -> str:
        """The status in words: which joint, which limit, what was wrong with the command."""
        if isinstance(self._why, str):
            return self._why
        if self._why in _WORDS:
            verb = "halted" if self.status is ServoStatus.HALTED_LIMIT else "slowed"
            return f"{verb} by the {_WORDS[self._why]} limit of {self.joint}"
        if self._why is Cause.SINGULARITY:
            most = f"; {self.joint} would have to move most for it" if self.joint else ""
            return f"near a singularity: the arm can hardly move that way from here{most}"
        if self.lost_share > WORTH_SAYING:
            return f"{self.status.value}, but for {self.lost_share:.0%} that the arm cannot do here"
        return self.status.value

    @classmethod
    def stale(cls, theta_dot: Array, reason: str) -> ServoOutput:
        """What a step answers without a usable command or state, and why."""
        return cls(theta_dot, ServoStatus.STALE, 0.0, _NOTHING_LOST, 0.0, None, (0.0, 0.0), reason)

    @classmethod
    def of(cls, answer: Answer, bounds: Bounds, joint_names: tuple[str, ...]) -> ServoOutput:
        """What an answer of the core, or of the readable step, means."""
        cause, row = answer.cause, answer.row
        status = ServoStatus.HALTED_LIMIT if answer.halted else _STATUS[cause]
        names = joint_names if cause is Cause.SINGULARITY else bounds.motion.names
        joint = names[row] if row >= 0 else None
        lost = answer.lost, answer.lost_share
        return cls(answer.theta_dot, status, answer.scale, *lost, joint, answer.remaining, cause)
