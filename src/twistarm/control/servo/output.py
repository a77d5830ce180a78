"""The output of a servo step: joint rates, their reason, and the lost part of the command."""

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
from .command import BASE, AnyCommand, TwistCommand
from .settings import ServoBounds

if TYPE_CHECKING:
    from ...collision import Contact

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


REASON_OF_CAUSE = (
    ServoReason.MOVING, ServoReason.SINGULARITY, ServoReason.VELOCITY_LIMIT, ServoReason.LOWER_LIMIT,
    ServoReason.UPPER_LIMIT, ServoReason.STALE, ServoReason.COLLISION,
)  # fmt: skip
"""The reason for each `servo_cause` of the core, in its order."""

NOTABLE_LOSS = 0.02  # Least lost share of a command that the output mentions.
ALL = 0.95  # A larger lost share counts as all of it.
STANDSTILL = 1e-3  # An arm that executes less than this share of the command counts as standing.

_NOTHING_LOST = frozen(np.zeros(6))


class CoreStep(NamedTuple):
    """The unchanged answer of the compiled step: the next state, and what became of the command.

    row: the row of `ServoBounds.motion` at its limit, the row of near pairs, or the joint of a singularity. −1: none.
    position, angle: what remains to a pose [m], [rad]. period [s]: the mean step time after this step.
    """

    theta: Array
    theta_dot: Array
    held_pose: Array | None
    cause: int
    row: int
    scale: float
    lost: Array
    lost_share: float
    halted: bool
    position: float
    angle: float
    period: float


class StepRequest(NamedTuple):
    """A command to an arm at theta (n,), and whether the arm stops where it cannot follow."""

    arm: Arm
    theta: Array
    command: AnyCommand
    stops: bool


@dataclass(frozen=True, eq=False, repr=False)
class ServoOutput(Brief):
    """The answer of one step.

    theta_dot (n,) [rad/s, m/s]: the joint rates for the coming dt.

    reason: a code for why the arm rests or does less than commanded. It changes only with the cause.

    scale: the executed share of the reachable command, at least 0: 1 − ‖done − reachable‖ over the longer of the two.
    It is below 1 while the arm changes speed, or a limit or a singularity slows it.

    lost_twist (6,) [m/s, rad/s], in the command's frame: the part impossible here at any speed. The cause is a missing
    motion, a singularity, or a joint that is or stops at its end. At constant speed the tool moves by scale · (twist −
    lost_twist). If the tool must turn in order to move, that rotation is in it too, with opposite sign.

    lost_share: ‖lost_twist‖ / ‖twist‖, with metres divided by the length.

    joint: the joint or motor most concerned by a limit or a singularity, or None.

    remaining: the distance of a `PoseCommand` from its pose, [m] and [rad], else zeros.

    halted: whether a position limit or a collision holds the arm at rest.

    contact: the pair of bodies that slows or halts the arm, or None. It has distance and margin [m].
    """

    theta_dot: Array
    reason: ServoReason
    scale: float
    lost_twist: Array
    lost_share: float
    joint: str | None
    remaining: tuple[float, float]
    halted: bool = False
    contact: Contact | None = None
    _why: str | None = field(default=None, repr=False)
    _request: StepRequest | None = field(default=None, repr=False)

    @property
    def status(self) -> str:
        """A code for how the step went: that of the reason, or `HALTED_LIMIT` or `HALTED_COLLISION` for a halt."""
        if self.halted:
            return "HALTED_COLLISION" if self.reason is ServoReason.COLLISION else "HALTED_LIMIT"
        return self.reason.status

    def explain(self) -> str:
        """Why the arm rests or does less than commanded, in one sentence, made on demand.

        It names the joint or motor at its limit, the motion that the arm lacks, or the command's error. "stopped on its
        course" precedes it if settings.on_unreachable stopped the arm.
        """
        stands = self.scale * (1.0 - self.lost_share) < STANDSTILL
        on_course = stands and self._request is not None and self._request.stops
        if on_course and self._words != ServoReason.MOVING.words and self.reason is not ServoReason.IMPOSSIBLE:
            return f"stopped on its course: {self._words}"
        return self._words

    @cached_property
    def _words(self) -> str:
        if self._why is not None:
            return self._why
        if self.reason in (ServoReason.LOWER_LIMIT, ServoReason.UPPER_LIMIT):
            side = "lower" if self.reason is ServoReason.LOWER_LIMIT else "upper"
            if self.halted:
                return f"{self.joint} is at its {side} position limit"
            return f"slowed by {position_limit(side, str(self.joint))}"
        if self.contact is not None:
            return f"{'halted before' if self.halted else 'slowed near'} a collision: {self.contact}"
        if self.reason is ServoReason.VELOCITY_LIMIT:
            return f"slowed by the velocity limit of {self.joint}"
        complete = self.status == "OK" and self._missing_share < NOTABLE_LOSS
        if complete and self.scale < ALL:
            return ServoReason.CHANGING_SPEED.words
        if self._request and not (complete and self.lost_share < NOTABLE_LOSS):
            return _missing(self._request, self.lost_twist, self.joint, self.share)[1]
        return self.reason.words

    @property
    def share(self) -> float:
        """The executed share of the command, 0 … 1. Rotations that only serve the way do not count."""
        return self.scale * (1.0 - self._missing_share)

    @property
    def _missing_share(self) -> float:
        """aᵀ lost / |a|² for the commanded twist a, metres measured in the reach; `lost_share` for other commands."""
        request, share = self._request, self.lost_share
        if request is not None and isinstance(request.command, TwistCommand) and request.command.numbers.any():
            scale = np.repeat([1.0 / request.arm.reach, 1.0], 3)
            twist = request.command.numbers * scale
            share = float(twist @ (self.lost_twist * scale) / (twist @ twist))
        return min(max(share, 0.0), 1.0)

    @classmethod
    def stale(cls, theta_dot: Array, reason: str) -> ServoOutput:
        """The output of a step without a usable command or state.

        Args:
            theta_dot: Rates (n,) [rad/s, m/s].
            reason: The reason, in words.
        """
        return cls(theta_dot, ServoReason.STALE, 0.0, _NOTHING_LOST, 0.0, None, (0.0, 0.0), _why=reason)


def output_of(step: CoreStep, bounds: ServoBounds, request: StepRequest, contact: Contact | None) -> ServoOutput:
    """The output for an answer of the compiled step. `contact`: the pair of bodies that holds the arm."""
    reason = REASON_OF_CAUSE[step.cause]
    near = reason is ServoReason.COLLISION
    names = request.arm.joint_names if reason is ServoReason.SINGULARITY else bounds.motion.names
    joint = names[step.row] if step.row >= 0 and not near else None
    if reason is ServoReason.MOVING and step.lost_share >= NOTABLE_LOSS:
        reason = ServoReason.TURN_LOST
    elif reason is ServoReason.MOVING and step.scale < ALL:
        reason = ServoReason.CHANGING_SPEED
    output = ServoOutput(
        step.theta_dot, reason, step.scale, step.lost, step.lost_share, joint, (step.position, step.angle),
        step.halted, contact, _request=request,
    )  # fmt: skip
    if joint is not None or near or step.lost_share <= ALL or output._missing_share <= ALL:
        return output
    nowhere, why = _missing(request, step.lost, joint, 0.0)
    return replace(output, reason=ServoReason.IMPOSSIBLE if nowhere else ServoReason.SINGULARITY, _why=why)


def _missing(request: StepRequest, lost: Array, joint: str | None, share: float) -> tuple[bool, str]:
    """The graver half of the lost twist (6,): whether the arm has it nowhere, and words."""
    angular = np.linalg.norm(lost[3:]) * request.arm.reach >= np.linalg.norm(lost[:3])
    half, way = (ANGULAR, "turn") if angular else (LINEAR, "move")
    part = lost[list(half)]
    unit = part / max(float(np.linalg.norm(part)), np.finfo(float).tiny)  # a lost twist may be exactly zero
    twist = request.command if isinstance(request.command, TwistCommand) else None
    frame = BASE if twist is None else twist.frame
    before, held = _prior_components(twist, half)
    nowhere = lacks(request.arm, request.theta, half, unit, frame, before)
    on_the_way = angular and twist is not None and not twist.twist[3:].any()
    if not nowhere:
        # An axis that the lost direction has for good: numbers would change from step to step.
        axis = direction_in_words(np.abs(unit), frame) if np.abs(unit).max() >= ALONG_AXIS and not on_the_way else ""
        return False, singular("move" if on_the_way else way, share, joint, axis)
    if on_the_way:
        return True, must_turn(unit, frame)
    return True, (cannot_turn if angular else cannot_move)(unit, frame, held)


def _prior_components(twist: TwistCommand | None, half: tuple[int, ...]) -> tuple[tuple[int, ...], str]:
    """The components that go before one half of a command, and what they are called."""
    held = [] if twist is None else [k for k in range(6) if twist.held[k] and k not in half]
    if half == ANGULAR:
        return LINEAR, "the position"
    return tuple(held), "the orientation" if len(held) == len(ANGULAR) else "what is to stay" if held else ""
