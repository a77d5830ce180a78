"""Bounds of the tool's motion along a joint path: speed, acceleration, and curvature of a deviation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...ik.targets import Position, TolerancedPose
from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import Indices, JointPath
from ..piecewise import derivative, spread
from .moving_target import MovingTarget

FIRST_SAMPLES = 8
"""Intervals in each piece for the first samples of the tool's velocity."""

NEAR = 1e-4
"""A bound that matters exceeds the greatest sampled speed by at most this part."""

MAX_SAMPLES = 512
"""The most intervals of one piece."""


class ToolDerivatives(NamedTuple):
    """Bounds (m,) per piece of a path for derivatives by s of the tool's origin p and rotation.

    velocity, acceleration, jerk: of ‖p'‖, ‖p''‖, ‖p'''‖ [m]. turn_velocity, turn_acceleration, turn_jerk: of ‖ω‖, ‖ω'‖,
    ‖ω''‖ [rad].
    """

    velocity: Array
    acceleration: Array
    jerk: Array
    turn_velocity: Array
    turn_acceleration: Array
    turn_jerk: Array

    @classmethod
    def along(cls, arm: Arm, path: JointPath) -> ToolDerivatives:
        """Return the bounds from the joints' values x = A θ. Joint k has the axis ω_k and the greatest lever ρ.

        A joint moves only what comes after it (MLS §3.4). So ∂p/∂x_k is at most D_k = ‖ω_k‖ ρ + |h_k|, or ‖v_k‖ for a
        slide. Further derivatives are cross products: ∂²p/∂x_j∂x_k = ω_j × ∂p/∂x_k for j not after k,
        ∂³p/∂x_i∂x_j∂x_k = ω_i × (ω_j × ∂p/∂x_k) for i not after j. ω is Σ ω_k x_k', with ∂ω_k/∂x_j = ω_j × ω_k for j
        before k, else 0. Let w_k = ‖ω_k x_k'‖, u_k = ‖ω_k x_k''‖, and W, U their sums over the joints before k. Then

            ‖p''‖ ≤ Σ D_k (|x_k''| + |x_k'| (w_k + 2 W)),
            ‖p'''‖ ≤ Σ D_k (|x_k'''| + 3 |x_k''| (w_k + W) + 3 |x_k'| U + |x_k'| (w_k² + 3 w_k W + 3 W²)),
            ‖ω'‖ ≤ Σ u_k + w_k W,
            ‖ω''‖ ≤ Σ ‖ω_k x_k'''‖ + 2 u_k W + w_k U + w_k W².

        The lever is the arm's reach plus the extension of its slides.
        """
        h = np.diff(path.breakpoints)
        values = path.coefficients @ arm.coupling.A.T
        out, x1, x2, x3 = (np.abs(bernstein(derivative(values, k), h)).max(axis=0) for k in range(4))
        turns, pushes = np.linalg.norm(arm.screws[3:], axis=0), np.linalg.norm(arm.screws[:3], axis=0)
        slides = turns == 0.0
        pitches = np.abs((arm.screws[:3] * arm.screws[3:]).sum(axis=0)) / np.where(slides, 1.0, turns)
        lever = arm.reach + (out * np.where(slides, pushes, pitches)).sum(axis=1)
        D = np.where(slides, pushes, lever[:, None] * turns + pitches)
        w, u = x1 * turns, x2 * turns
        W, U = np.cumsum(w, axis=1) - w, np.cumsum(u, axis=1) - u
        bounds = (
            D * x1,
            D * (x2 + x1 * (w + 2.0 * W)),
            D * (x3 + 3.0 * x2 * (w + W) + 3.0 * x1 * U + x1 * (w**2 + 3.0 * w * W + 3.0 * W**2)),
            w,
            u + w * W,
            x3 * turns + 2.0 * u * W + w * U + w * W**2,
        )
        return cls(*(each.sum(axis=1) for each in bounds))


def deviation_bend(arm: Arm, moving: MovingTarget, path: JointPath) -> Array:
    """Bound the second derivatives of position [m] and rotation error [rad] on each piece, (m, 2).

    The curve has p_c and a constant ω_c. Then ‖p'' − p_c''‖ ≤ ‖p''‖ + ‖p_c''‖. For E = R_cᵀ R, E'' = R_cᵀ (ω̂' + (ω −
    ω_c)^ ω̂ − ω̂_c (ω − ω_c)^) R, so the angle's is at most ‖ω'‖ + (‖ω‖ + ‖ω_c‖)². Errors in axes that turn with the
    target, R_cᵀ (p − p_c), have two more terms.
    """
    motion = ToolDerivatives.along(arm, path)
    curve, w = moving.curve, moving.angle
    position = motion.acceleration + curve.bend
    if isinstance(moving.like, TolerancedPose) and moving.like.frame == "target":
        apart = motion.velocity + curve.length
        offset = np.linalg.norm(arm.fk(path(path.breakpoints))[:, :3, 3] - curve(path.breakpoints)[:, :3, 3], axis=1)
        farthest = np.maximum(offset[:-1], offset[1:]) + apart * np.diff(path.breakpoints)
        position = position + 2.0 * w * apart + w**2 * farthest
    rotation = motion.turn_acceleration + (motion.turn_velocity + w) ** 2
    return np.stack([position, 0.0 * rotation if isinstance(moving.like, Position) else rotation], axis=1)


def greatest_tool_speeds(
    arm: Arm, path: JointPath, limits: JointLimits, linear_speed: float, angular_speed: float
) -> tuple[Array, Array]:
    """Bound ‖p'‖ [m] and ‖ω‖ [rad] by s on each piece, (m,) each.

    Between samples a distance d apart, a vector v(s) is within d² max ‖v''‖ / 8 of the chord. ‖v‖ exceeds its larger
    end by at most that. `ToolDerivatives` bounds v''. Samples are refined until the bound is tight. They stay coarse
    where the joints' velocity limits (n,) keep the tool below both speeds.
    """
    bounds = ToolDerivatives.along(arm, path)
    bend = np.stack([bounds.jerk, bounds.turn_jerk], axis=1)
    most = np.array([linear_speed, angular_speed])
    count = np.full(len(bend), FIRST_SAMPLES)
    seen, pace = _sampled_speeds(arm, path, limits, count)
    slack = (np.diff(path.breakpoints) / FIRST_SAMPLES)[:, None] ** 2 / 8.0 * bend
    with np.errstate(divide="ignore", invalid="ignore"):
        counts = (slack > NEAR * seen) & ((seen + slack) * pace[:, None] > most)
        finer = np.where(counts, np.sqrt(slack / (NEAR * seen)), 1.0).max(axis=1)
    if counts.any():
        count = np.ceil(FIRST_SAMPLES * np.minimum(finer, MAX_SAMPLES / FIRST_SAMPLES)).astype(np.int64)
        seen, _ = _sampled_speeds(arm, path, limits, count)
        slack = (np.diff(path.breakpoints) / count)[:, None] ** 2 / 8.0 * bend
    linear, angular = (seen + slack).T
    return linear, angular


def _sampled_speeds(arm: Arm, path: JointPath, limits: JointLimits, count: Indices) -> tuple[Array, Array]:
    """Greatest speeds (m, 2) by s at the ends of `count` intervals of each piece.

    The second array (m,) is the greatest ṡ there by the joints' velocity limits.
    """
    piece, nth = spread(count + 1)
    sigma = (np.diff(path.breakpoints) / count)[piece] * nth
    theta, rate = (path.within(piece, sigma, order) for order in (0, 1))
    twist = (arm.body_jacobian(theta) @ rate[..., None])[..., 0]
    speeds = np.linalg.norm(twist.reshape(-1, 2, 3), axis=2)
    with np.errstate(divide="ignore"):
        pace = 1.0 / (np.abs(rate) / limits.velocity).max(axis=1)
    first = np.flatnonzero(nth == 0)
    return np.maximum.reduceat(speeds, first), np.maximum.reduceat(pace, first)
