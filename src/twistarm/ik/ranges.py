"""Joint ranges during a search: bounds, and joints that may turn without end."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..arm.arm_data import kept
from ..support.checks import Array

TURN = 2.0 * math.pi

WHOLE_TURN_TOL = 1e-9  # Greatest rounding of a whole multiplier, and of a pitch of 0 [m/rad].


Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class JointRanges:
    """Limits `lower`, `upper` (n,), and which joints are `periodic`.

    A periodic joint with a range of a whole turn `turns` freely during a search. Every angle then has a representative
    inside the limits, so the search can ignore them.
    """

    lower: Array
    upper: Array
    periodic: Mask

    @property
    def turns(self) -> Mask:
        """Periodic joints with a range of a whole turn."""
        return self.periodic & (self.upper - self.lower >= TURN)

    def wrapped(self, theta: Array, near: Array) -> Array:
        """theta with every freely turning joint at its representative inside the limits nearest to `near`."""
        nearest = theta + TURN * np.round((near - theta) / TURN)
        return np.where(self.turns, np.clip(self._without_turns(nearest), self.lower, self.upper), theta)

    def inside(self, theta: Array) -> Array:
        """theta brought into the limits by whole turns, else to the bound."""
        inside = self._without_turns(theta)
        kept = self.periodic & (inside >= self.lower) & (inside <= self.upper)
        return np.clip(np.where(kept, inside, theta), self.lower, self.upper)

    def toward_middle(self, theta: Array) -> Array:
        """theta (..., n) by whole turns as near to the middle of the limits as possible."""
        bounded = np.isfinite(self.lower) & np.isfinite(self.upper)
        middle = 0.5 * (np.where(bounded, self.lower, 0.0) + np.where(bounded, self.upper, 0.0))
        return np.where(self.periodic, theta + TURN * np.round((middle - theta) / TURN), theta)

    def _without_turns(self, theta: Array) -> Array:
        """theta without the whole turns by which it lies outside. A hair outside, by rounding, stays."""
        below = np.ceil(np.maximum(self.lower - theta, 0.0) / TURN - WHOLE_TURN_TOL)
        above = np.ceil(np.maximum(theta - self.upper, 0.0) / TURN - WHOLE_TURN_TOL)
        return theta + TURN * (below - above)


def joint_ranges(arm: Arm) -> JointRanges:
    """The ranges of an arm's joints, kept with the arm."""
    lower, upper = arm.limits.lower, arm.limits.upper
    return kept(arm, "joint ranges", lambda: JointRanges(lower, upper, periodic(arm.screws, arm.coupling.A)))


def locked_joints(arm: Arm) -> tuple[int, ...]:
    """The joints with limits of one value."""
    return tuple(np.flatnonzero(arm.limits.lower == arm.limits.upper).tolist())


def holding(arm: Arm, joints: tuple[int, ...], theta: Array) -> Arm:
    """The arm with these joints held at theta (n,), clipped to the limits."""
    there = np.clip(theta, arm.limits.lower, arm.limits.upper)
    values = {arm.joint_names[i]: float(there[i]) for i in joints}
    return replace(arm, limits=arm.limits.with_({"lower": values, "upper": values}, arm.joint_names)) if joints else arm


def periodic(screws: Array, A: Array) -> Mask:
    """Columns of theta (n,) for which 2π moves nothing: e^{ξ̂ 2π a} = I for their screws ξ and multipliers a.

    That holds only for pure rotations (w ≠ 0, wᵀv = 0) with a whole number ‖w‖ a of turns. A slide moves on, a helical
    joint advances. A follower at half speed makes half a turn.
    """
    v, w = screws[:3], screws[3:]
    rate = np.linalg.norm(w, axis=0)
    pure = (rate > 0.0) & (np.abs((v * w).sum(axis=0)) <= WHOLE_TURN_TOL * rate**2)
    turns = rate[:, None] * A
    whole = np.abs(turns - np.round(turns)) <= WHOLE_TURN_TOL
    moves = A != 0.0
    return moves.any(axis=0) & ((pure[:, None] & whole) | ~moves).all(axis=0)
