"""Curvature: bounds of the second derivative of how far the tool is from a curve, along a joint path."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ik.targets import Position, Task
from ...model.arm import Arm
from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import derivative
from .moving_target import MovingTarget


@dataclass(frozen=True)
class _Motion:
    """Bounds on each piece, (m,): of ‖p'‖, ‖p''‖ [m], ‖ω‖ and ‖ω'‖ [rad], with respect to s."""

    speed: Array
    bend: Array
    turning: Array
    turning_change: Array


def deviation_bend(arm: Arm, moving: MovingTarget, path: JointPath) -> Array:
    """Bounds of the second derivatives of the position error [m] and the rotation error [rad] on each piece, (m, 2).

    With the curve's own p_c and ω_c, of which ω_c is constant: ‖p'' − p_c''‖ ≤ ‖p''‖ + ‖p_c''‖, and of E = R_cᵀ R,
    E'' = R_cᵀ (ω̂' + (ω − ω_c)^ ω̂ − ω̂_c (ω − ω_c)^) R, so that the angle's is at most ‖ω'‖ + (‖ω‖ + ‖ω_c‖)². Errors
    along axes that turn with the target, R_cᵀ (p − p_c), have two terms more.
    """
    motion = _motion(arm, path)
    curve, w = moving.curve, moving.angle
    position = motion.bend + curve.bend[0]
    if isinstance(moving.like, Task) and moving.like.frame == "target":
        apart = motion.speed + curve.length
        offset = np.linalg.norm(arm.fk(path(path.breakpoints))[:, :3, 3] - curve(path.breakpoints)[:, :3, 3], axis=1)
        farthest = np.maximum(offset[:-1], offset[1:]) + apart * np.diff(path.breakpoints)
        position = position + 2.0 * w * apart + w**2 * farthest
    rotation = motion.turning_change + (motion.turning + w) ** 2
    return np.stack([position, 0.0 * rotation if isinstance(moving.like, Position) else rotation], axis=1)


def _motion(arm: Arm, path: JointPath) -> _Motion:
    """The bounds by the joints' values x = A θ, joint k with ω_k and the greatest lever ρ about its axis.

    ∂p/∂x_k is at most D_k = ‖ω_k‖ ρ + |h_k|, for a slide ‖v_k‖, and ∂²p/∂x_j∂x_k = ω_j × ∂p/∂x_k, j not after k (MLS
    §3.4: joints act on what comes after them). So ‖p''‖ ≤ Σ D_k (|x_k''| + |x_k'| (‖ω_k x_k'‖ + 2 Σ_(j<k) ‖ω_j x_j'‖)),
    and ‖ω'‖ ≤ Σ ‖ω_k x_k''‖ + Σ_(j<k) ‖ω_j x_j'‖ ‖ω_k x_k'‖. The lever is the arm's reach and how far slides are out.
    """
    h = np.diff(path.breakpoints)
    values = path.coefficients @ arm.coupling.A.T
    out, rate, change = (np.abs(bernstein(derivative(values, k), h)).max(axis=0) for k in (0, 1, 2))
    turns = np.linalg.norm(arm.screws[3:], axis=0)
    slides = turns == 0.0
    pitches = np.abs((arm.screws[:3] * arm.screws[3:]).sum(axis=0)) / np.where(slides, 1.0, turns)
    lever = arm.reach + (out * np.where(slides, np.linalg.norm(arm.screws[:3], axis=0), pitches)).sum(axis=1)
    reaches = np.where(slides, np.linalg.norm(arm.screws[:3], axis=0), lever[:, None] * turns + pitches)
    w = rate * turns
    before = np.cumsum(w, axis=1) - w
    return _Motion(
        (reaches * rate).sum(axis=1),
        (reaches * (change + rate * (w + 2.0 * before))).sum(axis=1),
        w.sum(axis=1),
        (change * turns).sum(axis=1) + (w * before).sum(axis=1),
    )
