"""ToolDerivatives: bounds of how fast the tool moves and turns along a joint path, and how fast that changes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import derivative


class ToolDerivatives(NamedTuple):
    """Bounds on each piece of a path, (m,), of the derivatives by s of the tool's origin p and of its turn, ω.

    velocity, acceleration, jerk: of ‖p'‖, ‖p''‖, ‖p'''‖ [m]; turn_velocity, turn_acceleration, turn_jerk: of ‖ω‖, ‖ω'‖,
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
        """The bounds by the joints' values x = A θ, joint k with ω_k and the greatest lever ρ about its axis.

        Joints act on what comes after them (MLS §3.4): ∂p/∂x_k is at most D_k = ‖ω_k‖ ρ + |h_k|, for a slide ‖v_k‖;
        ∂²p/∂x_j∂x_k = ω_j × ∂p/∂x_k for j not after k, and ∂³p/∂x_i∂x_j∂x_k = ω_i × (ω_j × ∂p/∂x_k) for i not after j.
        ω is Σ ω_k x_k', where ∂ω_k/∂x_j = ω_j × ω_k for j before k, 0 for others. With w_k = ‖ω_k x_k'‖,
        u_k = ‖ω_k x_k''‖, and W, U their sums over the joints before k,

            ‖p''‖ ≤ Σ D_k (|x_k''| + |x_k'| (w_k + 2 W)),
            ‖p'''‖ ≤ Σ D_k (|x_k'''| + 3 |x_k''| (w_k + W) + 3 |x_k'| U + |x_k'| (w_k² + 3 w_k W + 3 W²)),
            ‖ω'‖ ≤ Σ u_k + w_k W,
            ‖ω''‖ ≤ Σ ‖ω_k x_k'''‖ + 2 u_k W + w_k U + w_k W².

        The lever is the arm's reach and how far slides are out.
        """
        h = np.diff(path.breakpoints)
        values = path.coefficients @ arm.coupling.A.T
        out, x1, x2, x3 = (np.abs(bernstein(derivative(values, k), h)).max(axis=0) for k in range(4))
        turns = np.linalg.norm(arm.screws[3:], axis=0)
        slides = turns == 0.0
        pitches = np.abs((arm.screws[:3] * arm.screws[3:]).sum(axis=0)) / np.where(slides, 1.0, turns)
        lever = arm.reach + (out * np.where(slides, np.linalg.norm(arm.screws[:3], axis=0), pitches)).sum(axis=1)
        D = np.where(slides, np.linalg.norm(arm.screws[:3], axis=0), lever[:, None] * turns + pitches)
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
