"""The errors between rotations that solvers iterate on: one matrix at a time, unchecked.

`rotations` has the same logarithm checked and batched. It costs ten times as much as a solver's whole iteration.
"""

from __future__ import annotations

import math

import numpy as np

from ..support.checks import Array
from ..theory.rotations import skew

# Trace below which (beyond 139°) the axis is read from R + Rᵀ, because R − Rᵀ fades towards a half turn.
NEAR_HALF_TURN = -0.5
SMALL_ANGLE = 1e-4  # Below this [rad] the series' next term is under double precision.


def chord(R: Array) -> Array:
    """2 sin(φ/2) u (3,) of the rotation R by φ about u: the chordal error, without arctangent.

    ‖R − I‖_F = √2 ‖chord‖. With (R − Rᵀ)^∨ = 2 sin φ u and 1 + tr R = 4 cos²(φ/2), the chord is their quotient (R −
    Rᵀ)^∨ / √(1 + tr R). As R turns with the body velocity ω, dφ/dt = u · ω. With J the rows of the body velocity, Jᵀ
    chord(R) is the exact gradient of 4 (1 − cos φ/2). That grows with φ up to the half turn. At φ = π the sign of u is
    arbitrary.
    """
    w = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    trace = float(R[0, 0] + R[1, 1] + R[2, 2])
    if trace > NEAR_HALF_TURN:
        return w / math.sqrt(1.0 + trace)
    # (R + Rᵀ)/2 − cos φ I = (1 − cos φ) u uᵀ: its longest column has the direction of u.
    columns = 0.5 * (R + R.T) - 0.5 * (trace - 1.0) * np.eye(3)
    u = columns[:, int(np.argmax(columns.diagonal()))]
    u = u * (math.sqrt(3.0 - trace) / math.sqrt(u @ u))
    return u if u @ w >= 0 else -u


def angle(R: Array) -> float:
    """φ [rad] in [0, π] of the rotation R, accurate near 0 and near π: atan2(2 sin φ, 2 cos φ)."""
    w = (R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1])
    return math.atan2(math.hypot(*w), float(R[0, 0] + R[1, 1] + R[2, 2]) - 1.0)


def log(R: Array) -> Array:
    """φ u (3,) [rad] of the rotation R by φ in [0, π] about u."""
    c = chord(R)
    length = math.sqrt(c @ c)
    return c if length < 1e-8 else c * (angle(R) / length)


def log_rate(phi: Array) -> Array:
    """J_r⁻¹(φ) (..., 3, 3) with d log(R)/dt = J_r⁻¹(log R) ω, φ (..., 3) and ω the body velocity of R.

    J_r⁻¹ = I + φ̂/2 + c φ̂², c = 1/φ² − cot(φ/2)/(2φ) → 1/12 + φ²/720 near 0. Source: G. Chirikjian, Stochastic
    Models, Information Theory, and Lie Groups, vol. 2, 2012, §10.8.
    """
    size = np.sqrt((phi * phi).sum(axis=-1))
    safe = np.maximum(size, SMALL_ANGLE)
    c = np.where(size < SMALL_ANGLE, 1.0 / 12.0 + size**2 / 720.0, 1.0 / safe**2 - 0.5 / (safe * np.tan(0.5 * safe)))
    phi_hat = skew(phi)
    return np.eye(3) + 0.5 * phi_hat + c[..., None, None] * (phi_hat @ phi_hat)
