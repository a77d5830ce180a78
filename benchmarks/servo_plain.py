"""The yardstick: a damped pseudo-inverse with clipping, as in textbooks."""

from __future__ import annotations

import numpy as np

from twistarm import Arm

from .servo_arms import Array

DAMPING = 0.05
"""λ of x = Jᵀ (J Jᵀ + λ²)⁻¹ V, metres measured in the arm's reach."""


def plain_rates(arm: Arm, theta: Array, twist: Array, frame: str, dt: float, seconds: float) -> Array:
    """Rates cycle by cycle under a held twist, clipped joint by joint: velocity, acceleration, position.

    A joint that meets its position limit stops at once and ignores its acceleration limit.
    """
    limits, scale = arm.limits, np.repeat([1 / arm.reach, 1.0], 3)
    jacobian = arm.hybrid_jacobian if frame == "base" else arm.body_jacobian
    rates, done = np.zeros(arm.n), []
    for _ in range(round(seconds / dt)):
        J = scale[:, None] * jacobian(theta)
        wanted = J.T @ np.linalg.solve(J @ J.T + DAMPING**2 * np.eye(6), scale * twist)
        wanted = np.clip(wanted, -limits.velocity, limits.velocity)
        wanted = np.clip(wanted, rates - limits.acceleration * dt, rates + limits.acceleration * dt)
        after = np.clip(theta + dt * wanted, limits.lower, limits.upper)
        theta, rates = after, (after - theta) / dt
        done.append(rates)
    return np.array(done)
