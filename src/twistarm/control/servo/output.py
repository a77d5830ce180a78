"""The output of a servo step: joint rates, a status with its reason, and the lost command."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...arm.abilities import ANGULAR, LINEAR, cannot_move, cannot_turn, lacks, must_turn, position_limit, singular
from ...arm.arm import Arm
from ...support.checks import Array, frozen
from ...support.directions import ALONG_AXIS, direction_in_words
from ...support.display import Brief
from .answer import Answer, Cause
from .bounds import Bounds
from .command import BASE, AnyCommand, TwistCommand

if TYPE_CHECKING:
    from ...collision import Contact


class ServoStatus(Enum):
    """How a step went; the gravest that holds."""

    OK = "moving as commanded"
    SLOWED_SINGULARITY = "slowed near a singularity"
    SLOWED_LIMIT = "slowed by a limit"
    HALTED_LIMIT = "halted by a position limit"
    IMPOSSIBLE_DIRECTION = "this arm has no such motion"
    STALE = "no usable command or state: coming to rest"
    SLOWED_COLLISION = "slowed near a collision"
    HALTED_COLLISION = "halted before a collision"


class ServoReason(Enum):
    """Why a step did what it did. The name is a code that stays; the numbers are fields of the output."""

    MOVING = "moving as commanded"
    CHANGING_SPEED = "changing speed, as fast as the acceleration limits allow"
    VELOCITY_LIMIT = "slowed by a velocity limit"
    LOWER_LIMIT = "a joint or motor is at its lower position limit, or brakes toward it"
    UPPER_LIMIT = "a joint or motor is at its upper position limit, or brakes toward it"
    SINGULARITY = "a direction of the command is nearly lost in this configuration"
    TURN_LOST = "the tool turns otherwise than commanded, because the arm has too few joints"
    IMPOSSIBLE = "this arm has no such motion"
    STALE = "no usable command or state: coming to rest"
    COLLISION = "two bodies of the scene come near each other"


_OF_STATUS = {
    ServoStatus.STALE: ServoReason.STALE,
    ServoStatus.IMPOSSIBLE_DIRECTION: ServoReason.IMPOSSIBLE,
    ServoStatus.SLOWED_SINGULARITY: ServoReason.SINGULARITY,
}

_OF_CAUSE = {
    Cause.NONE: (ServoStatus.OK, None),
    Cause.SINGULARITY: (ServoStatus.SLOWED_SINGULARITY, ServoReason.SINGULARITY),
    Cause.VELOCITY: (ServoStatus.SLOWED_LIMIT, ServoReason.VELOCITY_LIMIT),
    Cause.LOWER: (ServoStatus.SLOWED_LIMIT, ServoReason.LOWER_LIMIT),
    Cause.UPPER: (ServoStatus.SLOWED_LIMIT, ServoReason.UPPER_LIMIT),
    Cause.UNUSABLE: (ServoStatus.STALE, ServoReason.STALE),
    Cause.NEAR: (ServoStatus.SLOWED_COLLISION, ServoReason.COLLISION),
}
"""The status of a step and its reason, by cause."""

NOTABLE_LOSS = 0.02
"""Least lost share of a command that the output mentions."""

ALL = 0.95
"""A larger lost share counts as all of it."""

STANDSTILL = 1e-3
"""An arm that executes less than this share of the command counts as standing."""

_NOTHING_LOST = frozen(np.zeros(6))


class Request(NamedTuple):
    """A command to an arm at theta (n,), whether the arm stops where it cannot follow, and the pair that holds it."""

    arm: Arm
    theta: Array
    command: AnyCommand | None
    stops: bool = False
    contact: Contact | None = None


@dataclass(frozen=True, eq=False, repr=False)
class ServoOutput(Brief):
    """The answer of one step.

    theta_dot (n,) [rad/s, m/s]: the joint rates for the coming dt.

    scale: the executed share of the reachable command, at least 0: 1 − ‖done − reachable‖ over the longer of the two.
    It is below 1 while the arm changes speed, or a limit or a singularity slows it.

    lost_twist (6,) [m/s, rad/s], in the axes of the command's frame: the part impossible here at any speed. The cause
    is a missing motion, a singularity, or a joint that is or stops at its end. At constant speed the tool moves by
    scale · (twist − lost_twist). A rotation that the tool needs in order to move is in it, with opposite sign.

    lost_share: ‖lost_twist‖ / ‖twist‖, with metres divided by the length.

    joint: the joint or motor most concerned by a limit or a singularity, or None.

    remaining: the distance of a `PoseCommand` from its pose, [m] and [rad], else zeros.
    """

    theta_dot: Array
    status: ServoStatus
    scale: float
    lost_twist: Array
    lost_share: float
    joint: str | None
    remaining: tuple[float, float]
    _why: str | Cause = field(repr=False)
    _asked: Request | None = field(default=None, repr=False)

    @property
    def contact(self) -> Contact | None:
        """The pair of bodies that slows or halts the arm, with its distance and margin [m], or None."""
        return self._asked.contact if self._asked else None

    @property
    def reason(self) -> ServoReason:
        """A code for why the arm rests or does less than commanded. It changes only with the cause."""
        if self.status in _OF_STATUS:
            return _OF_STATUS[self.status]
        if isinstance(self._why, Cause) and (reason := _OF_CAUSE[self._why][1]):
            return reason
        if self._asked and self.lost_share >= NOTABLE_LOSS:
            return ServoReason.TURN_LOST
        return ServoReason.CHANGING_SPEED if self.scale < ALL else ServoReason.MOVING

    def explain(self) -> str:
        """Why the arm rests or does less than commanded, in one sentence, made on demand.

        It names the joint or motor and its limit, the motion that the arm lacks, or the command's error. "stopped on
        its course" precedes it if settings.on_unreachable stopped the arm.
        """
        on_course = self._asked is not None and self._asked.stops and self.scale * (1.0 - self.lost_share) < STANDSTILL
        if on_course and self._words != self.status.value and self.status is not ServoStatus.IMPOSSIBLE_DIRECTION:
            return f"stopped on its course: {self._words}"
        return self._words

    @cached_property
    def _words(self) -> str:
        if isinstance(self._why, str):
            return self._why
        if self._why in (Cause.LOWER, Cause.UPPER):
            side = self._why.name.lower()
            if self.status is ServoStatus.HALTED_LIMIT:
                return f"{self.joint} is at its {side} position limit"
            return f"slowed by {position_limit(side, str(self.joint))}"
        if self.contact is not None:
            return f"{self.status.value}: {self.contact}"
        if self._why is Cause.VELOCITY:
            return f"slowed by the velocity limit of {self.joint}"
        complete = self._why is Cause.NONE and self._missing_share < NOTABLE_LOSS
        if complete and self.scale < ALL:
            return ServoReason.CHANGING_SPEED.value
        if self._asked and not (complete and self.lost_share < NOTABLE_LOSS):
            return _missing(self._asked, self.lost_twist, self.joint, self.share)[1]
        return self.status.value

    @property
    def share(self) -> float:
        """The executed share of the command, 0 … 1. Rotations that only serve the way do not count."""
        return self.scale * (1.0 - self._missing_share)

    @property
    def _missing_share(self) -> float:
        """aᵀ lost / |a|² for the commanded twist a, metres measured in the reach; `lost_share` for other commands."""
        asked, share = self._asked, self.lost_share
        if asked is not None and isinstance(asked.command, TwistCommand) and asked.command.numbers.any():
            scale = np.repeat([1.0 / asked.arm.reach, 1.0], 3)
            twist = asked.command.numbers * scale
            share = float(twist @ (self.lost_twist * scale) / (twist @ twist))
        return min(max(share, 0.0), 1.0)

    @classmethod
    def stale(cls, theta_dot: Array, reason: str) -> ServoOutput:
        """The output of a step that had no usable command or state.

        Args:
            theta_dot: Rates (n,) [rad/s, m/s].
            reason: The reason, in words.

        Returns:
            The output, with status STALE.
        """
        return cls(theta_dot, ServoStatus.STALE, 0.0, _NOTHING_LOST, 0.0, None, (0.0, 0.0), reason)

    @classmethod
    def of(cls, answer: Answer, bounds: Bounds, asked: Request) -> ServoOutput:
        """The output for an answer of the compiled step.

        Args:
            answer: The step's answer as plain numbers.
            bounds: The arm's bounds.
            asked: The arm, the configuration and the command of the step, and the pair of bodies that holds the arm.

        Returns:
            The output, with status, joint and reason.
        """
        cause, row = answer.cause, answer.row
        status = _OF_CAUSE[cause][0]
        if answer.halted:
            status = ServoStatus.HALTED_COLLISION if cause is Cause.NEAR else ServoStatus.HALTED_LIMIT
        names = asked.arm.joint_names if cause is Cause.SINGULARITY else bounds.motion.names
        joint = names[row] if row >= 0 and cause is not Cause.NEAR else None
        lost, remaining = (answer.lost, answer.lost_share), answer.remaining
        output = cls(answer.theta_dot, status, answer.scale, *lost, joint, remaining, cause, asked)
        if joint is not None or cause is Cause.NEAR or answer.lost_share <= ALL or output._missing_share <= ALL:
            return output
        nowhere, why = _missing(asked, answer.lost, joint, 0.0)
        status = ServoStatus.IMPOSSIBLE_DIRECTION if nowhere else ServoStatus.SLOWED_SINGULARITY
        return replace(output, status=status, _why=why)


def _missing(asked: Request, lost: Array, joint: str | None, share: float) -> tuple[bool, str]:
    """The graver half of the lost twist (6,): whether the arm has it nowhere, and words."""
    turned = np.linalg.norm(lost[3:]) * asked.arm.reach >= np.linalg.norm(lost[:3])
    half, way = (ANGULAR, "turn") if turned else (LINEAR, "move")
    part = lost[list(half)]
    unit = part / max(float(np.linalg.norm(part)), np.finfo(float).tiny)
    twist = asked.command if isinstance(asked.command, TwistCommand) else None
    frame = BASE if twist is None else twist.frame
    before, held = _prior_components(twist, half)
    nowhere = lacks(asked.arm, asked.theta, half, unit, frame, before)
    on_the_way = turned and twist is not None and not twist.twist[3:].any()
    if not nowhere:
        # An axis that the lost direction has for good: numbers would change from step to step.
        axis = direction_in_words(np.abs(unit), frame) if np.abs(unit).max() >= ALONG_AXIS and not on_the_way else ""
        return False, singular("move" if on_the_way else way, share, joint, axis)
    if on_the_way:
        return True, must_turn(unit, frame)
    return True, (cannot_turn if turned else cannot_move)(unit, frame, held)


def _prior_components(twist: TwistCommand | None, half: tuple[int, ...]) -> tuple[tuple[int, ...], str]:
    """The components that go before one half of a command, and what they are called."""
    held = [] if twist is None else [k for k in range(6) if twist.held[k] and k not in half]
    if half == ANGULAR:
        return LINEAR, "the position"
    return tuple(held), "the orientation" if len(held) == len(ANGULAR) else "what is to stay" if held else ""
