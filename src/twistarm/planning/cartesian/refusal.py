"""PathError: how far a path can be followed, why no farther, and what would help."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...ik.solve import solve_ik
from ...ik.stop_reason import StopReason
from ...ik.targets import AnyTarget, Approach, Pose, Position
from ...model.arm import Arm
from ...support.caller_words import posture, quantity
from ...support.checks import Array
from ...support.errors import TwistarmError
from .branches import branches
from .following import Blocked, Followed, follow
from .moving_target import MovingTarget

AT_LIMIT = 0.01
"""A joint that is nearer to its limit than this [rad, m] where a path ends has come to it."""

SINGULAR = 0.05
"""A smaller least singular value, metres over the arm's reach, is that of a posture near a singular one."""

AHEAD = (1e-3, 0.02)
"""So far beyond the end, in s, it is asked whether any configuration meets the path."""

FEW = 8
"""Other configurations at the start that are tried."""


class PathError(TwistarmError):
    """A path that the arm cannot follow to its end.

    `share`: how much of it, s in [0, 1); `theta` (n,): the configuration there; `reason`: "limit", "singular" or "out
    of reach"; `joint`: which has come to its limit, or None; `start` (n,): another configuration at the beginning from
    which the whole path can be followed, or None; `segment`: the index of the segment in the motion, of which `place`
    says the same in words; `detail`: the message without it.
    """

    def __init__(
        self,
        message: str,
        share: float = 0.0,
        theta: Array | None = None,
        reason: str = "",
        joint: str | None = None,
        start: Array | None = None,
        segment: int | None = None,
        place: str = "",
    ) -> None:
        super().__init__(f"{place}: {message}" if place else message)
        self.detail, self.share, self.theta, self.reason = message, share, theta, reason
        self.joint, self.start, self.segment, self.place = joint, start, segment, place

    def __reduce__(self) -> tuple[type[PathError], tuple[object, ...]]:
        known = self.share, self.theta, self.reason, self.joint, self.start, self.segment, self.place
        return type(self), (self.detail, *known)

    def within(self, segment: int, place: str) -> PathError:
        """The same of a segment of a motion.

        Args:
            segment: its index, from 0.
            place: it and its place in words, which the message begins with.
        """
        return PathError(self.detail, self.share, self.theta, self.reason, self.joint, self.start, segment, place)


def refusal(arm: Arm, moving: MovingTarget, blocked: Blocked, start: Array) -> PathError:
    """The error for a path that is blocked from `start` (n,) on; looks for what would help."""
    reason, joint, why = _why(arm, moving, blocked)
    other = _other_start(arm, moving, start)
    help_ = _help(arm, moving, start, other)
    return PathError(
        f"the tool follows the path for {_part(moving, blocked.share)} and no farther: {why}: {help_}",
        blocked.share,
        blocked.theta,
        reason,
        joint,
        other,
    )


def _part(moving: MovingTarget, share: float) -> str:
    """So far of so much, in m, or in rad where it only turns."""
    turns = moving.curve.length < 1e-9
    whole, unit = (moving.curve.angle, "rad") if turns else (moving.curve.length, "m")
    so_far, all_ = (quantity(float(f"{part:.3g}"), unit) for part in (share * whole, whole))
    return f"{so_far} of {all_} ({min(round(100.0 * share), 99)} %)"


def _why(arm: Arm, moving: MovingTarget, blocked: Blocked) -> tuple[str, str | None, str]:
    """Reason, joint and words."""
    theta, limits = blocked.theta, arm.limits
    room = np.minimum(theta - limits.lower, limits.upper - theta)
    j = int(room.argmin())
    if room[j] < AT_LIMIT:
        side = "lower" if theta[j] - limits.lower[j] < limits.upper[j] - theta[j] else "upper"
        limit = quantity(float(getattr(limits, side)[j]), arm.units[j])
        return "limit", arm.joint_names[j], f"joint {arm.joint_names[j]!r} comes to its {side} limit {limit}"
    beyond = [solve_ik(arm, moving.at(min(blocked.share + step, 1.0)), theta) for step in AHEAD]
    unmet = next((solution for solution in beyond if not solution.converged), None)
    met = unmet is None
    least = float(arm.manipulability(theta).singular_values[-1])
    if met and least < SINGULAR:
        return "singular", None, "the arm comes to a singular posture, and would have to leap to another configuration"
    if met:
        return "limit", None, "the arm would have to leap to another configuration"
    assert unmet is not None
    if unmet.stop is StopReason.IMPOSSIBLE_DIRECTION:
        return "out of reach", None, unmet.stop.value
    return "out of reach", None, "the path leaves the arm's reach there"


def _other_start(arm: Arm, moving: MovingTarget, start: Array) -> Array | None:
    """Another configuration at the beginning of the path from which all of it can be followed."""
    theta: Array
    for theta in branches(arm, moving.at(0.0), start)[:FEW]:
        if isinstance(follow(arm, moving, theta), Followed):
            return theta
    return None


def _help(arm: Arm, moving: MovingTarget, start: Array, other: Array | None) -> str:
    if other is not None:
        begin = posture(other.tolist(), arm.units)
        return f"begin it in another configuration, {begin}, from which all of it can be followed"
    if isinstance(moving.like, Pose):
        g = moving.like.g
        freer: dict[str, AnyTarget] = {
            "turning about the tool axis": Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis, arm.tool_axis),
            "the rotation": Position(g[:3, 3]),
        }
        for what, like in freer.items():
            freed = replace(moving, like=like)
            if not freed.is_still and isinstance(follow(arm, freed, start), Followed):
                return f"with {what} left free the arm can follow it (an Approach or a Position as goal)"
    return "make it shorter, or move its ends"
