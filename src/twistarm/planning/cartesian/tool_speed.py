"""The greatest speed of the tool along a joint path: a bound that it comes near to, and never passes."""

from __future__ import annotations

import numpy as np

from ...arm.arm import Arm
from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from ..joint_path import Indices, JointPath
from .tool_derivatives import ToolDerivatives

LOOKS = 8
"""Intervals of each piece at whose ends the tool's velocity is looked at to begin with."""

NEAR = 1e-4
"""How far a bound may be above the greatest speed seen, relatively, where it counts."""

MOST_LOOKS = 512
"""A piece has no more intervals than that."""


def greatest_tool_speeds(
    arm: Arm, path: JointPath, limits: JointLimits, tool_speed: float, turn_speed: float
) -> tuple[Array, Array]:
    """Bounds of ‖p'‖ [m] and ‖ω‖ [rad] by s on each piece, (m,) each.

    Between two places a distance d apart, a vector v(s) is within d² max ‖v''‖ / 8 of the chord, so that ‖v‖ is at most
    that above the greater of both ends (`ToolDerivatives` bounds v''). There are as many places as bring the bound near
    to what is seen, but where the joints' own velocity limits (n,) keep the tool below both speeds.
    """
    bounds = ToolDerivatives.along(arm, path)
    bend = np.stack([bounds.jerk, bounds.turn_jerk], axis=1)
    most = np.array([tool_speed, turn_speed])
    count = np.full(len(bend), LOOKS)
    seen, pace = _seen(arm, path, limits, count)
    slack = (np.diff(path.breakpoints) / LOOKS)[:, None] ** 2 / 8.0 * bend
    with np.errstate(divide="ignore", invalid="ignore"):
        counts = (slack > NEAR * seen) & ((seen + slack) * pace[:, None] > most)
        finer = np.where(counts, np.sqrt(slack / (NEAR * seen)), 1.0).max(axis=1)
    if counts.any():
        count = np.ceil(LOOKS * np.minimum(finer, MOST_LOOKS / LOOKS)).astype(np.int64)
        seen, _ = _seen(arm, path, limits, count)
        slack = (np.diff(path.breakpoints) / count)[:, None] ** 2 / 8.0 * bend
    linear, angular = (seen + slack).T
    return linear, angular


def _seen(arm: Arm, path: JointPath, limits: JointLimits, count: Indices) -> tuple[Array, Array]:
    """The greatest speeds (m, 2) by s at the ends of so many intervals of each piece, and the greatest ṡ (m,) there by
    the joints' velocity limits.
    """
    piece = np.repeat(np.arange(len(count)), count + 1)
    first = np.cumsum(count + 1) - (count + 1)
    sigma = (np.diff(path.breakpoints) / count)[piece] * (np.arange(len(piece)) - first[piece])
    theta, rate = (path.within(piece, sigma, order) for order in (0, 1))
    twist = (arm.body_jacobian(theta) @ rate[..., None])[..., 0]
    speeds = np.stack([np.linalg.norm(twist[:, :3], axis=1), np.linalg.norm(twist[:, 3:], axis=1)], axis=1)
    with np.errstate(divide="ignore"):
        pace = 1.0 / (np.abs(rate) / limits.velocity).max(axis=1)
    return np.maximum.reduceat(speeds, first), np.maximum.reduceat(pace, first)
