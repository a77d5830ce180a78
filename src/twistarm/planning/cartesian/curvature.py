"""Curvature: bounds of the second derivative of how far the tool is from a curve, along a joint path."""

from __future__ import annotations

import numpy as np

from ...arm.arm import Arm
from ...ik.targets import Position, Task
from ...support.checks import Array
from ..joint_path import JointPath
from .moving_target import MovingTarget
from .tool_derivatives import ToolDerivatives


def deviation_bend(arm: Arm, moving: MovingTarget, path: JointPath) -> Array:
    """Bounds of the second derivatives of the position error [m] and the rotation error [rad] on each piece, (m, 2).

    With the curve's own p_c and ω_c, of which ω_c is constant: ‖p'' − p_c''‖ ≤ ‖p''‖ + ‖p_c''‖, and of E = R_cᵀ R,
    E'' = R_cᵀ (ω̂' + (ω − ω_c)^ ω̂ − ω̂_c (ω − ω_c)^) R, so that the angle's is at most ‖ω'‖ + (‖ω‖ + ‖ω_c‖)². Errors
    along axes that turn with the target, R_cᵀ (p − p_c), have two terms more.
    """
    motion = ToolDerivatives.along(arm, path)
    curve, w = moving.curve, moving.angle
    position = motion.acceleration + curve.bend
    if isinstance(moving.like, Task) and moving.like.frame == "target":
        apart = motion.velocity + curve.length
        offset = np.linalg.norm(arm.fk(path(path.breakpoints))[:, :3, 3] - curve(path.breakpoints)[:, :3, 3], axis=1)
        farthest = np.maximum(offset[:-1], offset[1:]) + apart * np.diff(path.breakpoints)
        position = position + 2.0 * w * apart + w**2 * farthest
    rotation = motion.turn_acceleration + (motion.turn_velocity + w) ** 2
    return np.stack([position, 0.0 * rotation if isinstance(moving.like, Position) else rotation], axis=1)
