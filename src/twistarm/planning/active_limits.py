"""Active limits: what keeps each stretch of a motion from being faster."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError, quote
from .joint_space import completed
from .segments import Move, Segment, as_segments
from .time_law import PathBounds
from .torque_limits import Load, torque_limits
from .trajectory import Trajectory

SAMPLES = 2000  # How many instants of a motion are sampled: ten or more in each stretch that is no sliver.
# Shares that differ by no more than this are equal. So one of several proportional joints is named.
EQUAL_SHARE = 1e-3
SLIVER = 5e-3  # A stretch shorter than this part of the motion belongs to the one before it.


@dataclass(frozen=True)
class ActiveLimit:
    """The limit that a motion uses most from `begin` to `end` [s].

    `owner` is "joint", "motor" or "tool", `name` its name. `rate` is "velocity", "acceleration", "jerk" or "torque";
    "linear speed" or "angular speed" for the tool. `share` is the greatest part of the limit in use there; 1 is all.
    For a torque it is the part of what gravity leaves.
    """

    begin: float
    end: float
    rate: str
    owner: str
    name: str
    share: float

    def describe(self) -> str:
        """Such as "velocity of joint 'elbow'"."""
        return self.rate if self.owner == "tool" else f"{self.rate} of {self.owner} {self.name!r}"


def active_limits(
    arm: Arm,
    motion: Trajectory,
    *,
    limits: JointLimits | Mapping[str, Any] | None = None,
    segments: Sequence[Segment] = (),
    torques: bool = False,
    payload: Load = 0.0,
) -> tuple[ActiveLimit, ...]:
    """Return the limit that each stretch of a motion uses most. Raise that limit to make the motion faster there.

    It compares the shares |rate_j(t)| / limit_j of every rate of every joint and motor j at 2,000 instants. A stretch
    lasts as long as the same one is the greatest, to 0.05 % of the motion. Rates without a limit do not count, and
    nothing limits an arm at rest. Stretches shorter than 0.5 % of the motion join the one before.

    Args:
        arm: The arm. The limits of its motors count too.
        motion: The motion of its joints.
        limits: As given to `plan` or `plan_joint`; usual ones replace missing ones here too.
        segments: Those given to `plan`. Their shares of joint velocities and speeds of the tool count.

        torques: Whether efforts count, as given to `plan`.
        payload: What the tool carries then, as given to `plan`.

    Returns:
        The stretches in order of time. Gaps are where the arm stands; () for a motion of duration 0.

    Raises:
        InputError: The motion is of other joints, or does not belong to the segments.
    """
    require_arm(arm)
    if not isinstance(motion, Trajectory) or motion.joint_names != arm.joint_names:
        raise InputError(f"motion must be a Trajectory of the arm's joints; got {quote(motion)}")
    moves = [] if isinstance(segments, Sequence) and not segments else as_segments(segments)
    if moves and len(moves) + 1 != len(motion.times):
        raise InputError(
            f"a motion of {len(moves)} segments has {len(moves) + 1} waypoints; this one has {len(motion.times)}"
        )
    if not motion.duration:
        return ()
    given = completed(arm, limits)[0]
    bounds = PathBounds(given, arm.actuators, torques=torque_limits(arm, given.effort, torques, payload))
    t = motion.duration * (np.arange(SAMPLES) + 0.5) / SAMPLES
    shares = _shares(arm, motion, bounds, moves, t)
    motors = () if arm.actuators is None else arm.actuators.names
    owners = [*(("joint", name) for name in arm.joint_names), *(("motor", name) for name in motors)]
    rows = [(rate, *owner) for rate in ("velocity", "acceleration", "jerk") for owner in owners]
    rows += [("linear speed", "tool", ""), ("angular speed", "tool", ""), *(("torque", *owner) for owner in owners)]
    found, first = [], 0
    for row, count in _stretches(shares):
        share = float(shares[first : first + count, row].max())
        begin, end = (motion.duration * (sample / SAMPLES) for sample in (first, first + count))
        if row >= 0:
            found.append(ActiveLimit(begin, end, *rows[row], share))
        first += count
    return tuple(found)


def _shares(arm: Arm, motion: Trajectory, bounds: PathBounds, moves: Sequence[Segment], t: Array) -> Array:
    """Velocity, acceleration and jerk of joints and motors, both speeds of the tool, torques: (m, 3 r + 2) or more.

    Each is a share of its limit, 0 without a limit.
    """
    limits = (bounds.velocity, bounds.acceleration, bounds.rates.jerk)
    rates = [np.abs(motion(t, order) @ bounds.C.T) / limit for order, limit in enumerate(limits, 1)]
    tool = np.zeros((len(t), 2))
    for move, begin, end in zip(moves, motion.times, motion.times[1:], strict=False):
        if not isinstance(move, Move):
            continue
        among = (t >= begin) & (t < end)
        rates[0][among, : motion.n] /= move.velocity_scaling
        twist = (arm.body_jacobian(motion(t[among])) @ motion(t[among], 1)[..., None]).reshape(-1, 2, 3)
        most = [np.inf if speed is None else speed for speed in (move.linear_speed, move.angular_speed)]
        tool[among] = np.linalg.norm(twist, axis=-1) / most
    if bounds.torques is not None:
        torques = bounds.torques.shares(*(motion(t, order) for order in range(3)))
        return np.concatenate([*rates, tool, torques], axis=1)
    return np.concatenate([*rates, tool], axis=1)


def _stretches(shares: Array) -> list[tuple[int, int]]:
    """The row that leads each stretch, -1 where all stand, and its number of samples."""
    leaders, row = [], -1
    for share, leader, greatest in zip(shares, shares.argmax(axis=1).tolist(), shares.max(axis=1), strict=True):
        if greatest == 0.0:
            row = -1
        elif row < 0 or share[row] < (1.0 - EQUAL_SHARE) * greatest:
            row = leader
        leaders.append(row)
    stretches: list[tuple[int, int]] = []
    for row, group in groupby(leaders):
        count = len(list(group))
        if stretches and (count < SLIVER * SAMPLES or row == stretches[-1][0]):
            row, count = stretches[-1][0], stretches.pop()[1] + count
        stretches.append((row, count))
    return stretches
