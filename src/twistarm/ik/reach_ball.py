"""The ball that holds a point of the tool, whatever the joints do: a bound that excludes far targets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..theory.screws import to_screw
from .closed_form.chain import NO_PITCH
from .targets import Approach, Pose, Position

STEPS = 50
"""Steps toward the smallest radius. Each of them gives a bound."""

SHORTEST = 1e-6
"""Shorter distances [m] count as this in a step's weights."""

ROUNDING = 1e-9
"""What the radius has beyond the bound [m]."""


class ReachBall(NamedTuple):
    """The point x (3,) of the tool, in tool axes, stays within `radius` [m] of `centre` (3,)."""

    x: Array
    centre: Array
    radius: float


def reach_ball(arm: Arm, like: Position | Approach | Pose, bounds: tuple[Array, Array] | None = None) -> ReachBall:
    """A small ball for targets like this one, where theta is inside `bounds` or the limits.

    A turn about its axis keeps the distance of a point q_i on it to the next one, q_{i+1}. So the tool's point x stays
    within Σ ‖q_{i+1} − q_i‖ of q_1. A slide or thread adds half of its range. That holds for any q_i on the axes and
    any x that the target fixes: the origin of a `Position`, the tool axis of an `Approach`, any point of a `Pose`. The
    q_i and x are those of the least sum, by iteratively reweighted least squares (E. Weiszfeld, Tôhoku Math. J. 43,
    1937). Coupled joints count as if they moved alone. A slide or thread without limits makes the radius inf.
    """
    kept = {Position: np.zeros((3, 0)), Approach: getattr(like, "axis", np.zeros(3))[:, None], Pose: np.eye(3)}
    lower, upper = bounds or (arm.limits.lower, arm.limits.upper)
    screws = to_screw(arm.screws.T)
    turns = np.isfinite(screws.pitch)
    pitch = np.where(turns, np.where(np.abs(screws.pitch) > NO_PITCH, screws.pitch, 0.0), 1.0)
    advance = (pitch * screws.magnitude)[:, None] * arm.coupling.A
    half = np.where(advance, np.maximum(upper - arm.middle, arm.middle - lower), 0.0)  # no 0 times inf
    shift = (advance @ arm.middle)[:, None] * screws.axis
    axes, behind = screws.axis[turns], (np.cumsum(shift, axis=0) + screws.point)[turns]
    count, fixed = len(axes), kept[type(like)]
    at = np.vstack([behind, arm.home[:3, 3] + shift.sum(axis=0)])
    along = np.zeros((count + 1, 3, count + fixed.shape[1]))
    along[range(count), :, range(count)] = axes
    along[count, :, count:] = arm.home[:3, :3] @ fixed
    offset, rows, length, z = np.diff(at, axis=0), np.diff(along, axis=0), np.ones(count), np.zeros(along.shape[-1])
    for _ in range(STEPS):
        weight = np.maximum(length, SHORTEST) ** -0.5
        z = np.linalg.lstsq((rows * weight[:, None, None]).reshape(3 * count, len(z)),
                            -(offset * weight[:, None]).ravel(), rcond=None)[0]  # fmt: skip
        length = np.linalg.norm(offset + rows @ z, axis=1)
    radius = float(length.sum() + (np.abs(advance) * half).sum()) + ROUNDING
    return ReachBall(fixed @ z[count:], at[0] + along[0] @ z, radius)
