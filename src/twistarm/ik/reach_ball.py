"""The ball that holds a point of the tool, whatever the joints do: a bound that excludes far targets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError
from ..theory.screws import inverse
from .closed_form.chain import chain_for
from .targets import AnyTarget, Approach, Pose, Position

STEPS = 50
"""Steps toward the smallest radius. Each of them gives a bound."""

SHORTEST = 1e-6
"""Shorter distances [m] count as this in a step's weights."""


class ReachBall(NamedTuple):
    """The point x (3,) of the tool, in tool axes, stays within `radius` [m] of `centre` (3,)."""

    x: Array
    centre: Array
    radius: float


def reach_ball(arm: Arm, like: AnyTarget) -> ReachBall | None:
    """A small ball for targets like this one. None for coupled or helical joints, and for a `TolerancedPose`.

    A turn about its axis keeps the distance of a point q_i on it to the next one, q_{i+1}. So the tool's point x stays
    within Σ ‖q_{i+1} − q_i‖ of q_1, and a slide adds half of its range. That holds for any q_i on the axes and any x
    that the target fixes: the origin of a `Position`, the tool axis of an `Approach`, any point of a `Pose`. The q_i
    and x are those of the least sum, by iteratively reweighted least squares (E. Weiszfeld, Tôhoku Math. J. 43, 1937).
    """
    kept = {Position: np.zeros((3, 0)), Approach: getattr(like, "axis", np.zeros(3))[:, None], Pose: np.eye(3)}
    try:
        chain = chain_for(arm, Pose(np.eye(4)))
    except InputError:
        return None
    slides = tuple(i for i in range(arm.n) if chain.axes[i].slides)
    if type(like) not in kept or len(slides) == arm.n:
        return None
    stroke = np.abs(chain.rates * (arm.limits.upper - arm.limits.lower))[list(slides)]
    axes, behind = chain.held(slides, (chain.rates * arm.middle)[list(slides)])
    home, fixed = inverse(behind) @ arm.home, kept[type(like)]
    count = len(axes)
    at = np.array([*(axis.o for axis in axes), home[:3, 3]])
    along = np.zeros((count + 1, 3, count + fixed.shape[1]))
    along[range(count), :, range(count)] = [axis.w for axis in axes]
    along[count, :, count:] = home[:3, :3] @ fixed
    offset, rows, length, z = np.diff(at, axis=0), np.diff(along, axis=0), np.ones(count), np.zeros(along.shape[-1])
    for _ in range(STEPS):
        weight = np.maximum(length, SHORTEST) ** -0.5
        z = np.linalg.lstsq((rows * weight[:, None, None]).reshape(3 * count, -1),
                            -(offset * weight[:, None]).ravel(), rcond=None)[0]  # fmt: skip
        length = np.linalg.norm(offset + rows @ z, axis=1)
    return ReachBall(fixed @ z[count:], at[0] + along[0] @ z, float(length.sum() + 0.5 * stroke.sum()))
