"""Projection: many configurations brought onto a curve's targets by Newton's method, inside the limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...ik.rotation_errors import log_rate
from ...ik.targets import AnyTarget, Approach, Pose, TolerancedPose
from ...ik.task_space import Tolerances
from ...support.checks import Array
from ...theory import rotations
from .moving_target import errors_from

STEPS = 12

DAMPING, LEAST_DAMPING = 0.05, 1e-12
"""Of a step, as part of the squared error and at least. Far from targets and near singularities it is short."""

TOLERANCE_DAMPING = 1e-6
"""Least damping within tolerances. It keeps joints from turning far to correct rounding of an axis."""

GROWTH, MOST_GROWTH = 10.0, 1e8
"""Factor and limit of the least damping within tolerances, which grows where a step increases errors."""

MOST_WEIGHT = 1e3
"""Greatest weight of an error with a narrow tolerance relative to one with a wide tolerance."""

LIMIT = 1e-12
"""A joint this near to a limit [rad, m] is at it."""


def projected(
    arm: Arm, like: AnyTarget, ideal: Array, theta: Array, exact: float, within: Tolerances | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Return configurations near theta (k, n) for targets at `ideal` (k, 4, 4), and which meet them.

    Damped Gauss-Newton takes the shortest step: θ ← θ − Jᵀ (J Jᵀ + λ 1)⁻¹ e (Nakamura & Hanafusa 1986). So what a
    target leaves free stays. A joint at a limit is held if it would leave. Targets are met to `exact` [m, rad], or
    `within` tolerances. These weigh the errors, and λ grows where errors do not shrink.
    """
    lower, upper = arm.limits.lower, arm.limits.upper
    theta = np.clip(theta, lower, upper)
    more, best, kept = np.ones(len(theta)), np.full(len(theta), np.inf), theta
    for _ in range(STEPS):
        e, J = errors_and_rows(like, ideal, arm.fk(theta), arm.body_jacobian(theta))
        met: NDArray[np.bool_] = np.abs(e).max(axis=1) <= 0.5 * exact
        if met.all():
            break
        if within is None:
            damping = DAMPING * (e**2).sum(axis=1) + LEAST_DAMPING
        else:
            weights = _weights(within, e.shape[1])
            e, J = e * weights, J * weights[:, None]
            size = (e**2).sum(axis=1)
            less = size < best
            more = np.clip(np.where(less, more / GROWTH, more * GROWTH), 1.0, MOST_GROWTH)
            kept, best = np.where(less[:, None], theta, kept), np.minimum(size, best)
            if not less.all():
                theta = kept
                e, J = errors_and_rows(like, ideal, arm.fk(theta), arm.body_jacobian(theta))
                e, J = e * weights, J * weights[:, None]
            damping = DAMPING * best + TOLERANCE_DAMPING * more
        damped = damping[:, None, None] * np.eye(e.shape[1])
        step = _shortest(e, J, damped)
        held = ((theta <= lower + LIMIT) & (step < 0.0)) | ((theta >= upper - LIMIT) & (step > 0.0))
        if held.any():
            step = _shortest(e, J * ~held[:, None], damped)
        theta = np.where(met[:, None], theta, np.clip(theta + step, lower, upper))
    if within is not None:
        position, angle = errors_from(like, ideal, arm.fk(theta))
        met = (position <= within.position) & (angle <= within.orientation)
    return theta, met


def _weights(within: Tolerances, count: int) -> Array:
    """Return weights (r,) of an error's rows, greater for the narrower tolerance."""
    tolerances = np.array([within.position] * 3 + [within.orientation] * (count - 3))
    return np.minimum(max(within.position, within.orientation) / tolerances, MOST_WEIGHT)


def _shortest(e: Array, J: Array, damping: Array) -> Array:
    across = np.swapaxes(J, 1, 2)
    return -(across @ np.linalg.solve(J @ across + damping, e[..., None]))[..., 0]


def errors_and_rows(like: AnyTarget, ideal: Array, g: Array, J_b: Array) -> tuple[Array, Array]:
    """Errors (k, r) of poses g (k, 4, 4) from targets at `ideal`, and their rows (k, r, n).

    They match the targets' `position_rows` and `rotation_rows`, except for the size of large errors. What a
    `TolerancedPose` tolerates is no error and has no rows.
    """
    turned = np.swapaxes(ideal[:, :3, :3], -1, -2)
    R, offset = g[:, :3, :3], (g[:, :3, 3] - ideal[:, :3, 3])[..., None]
    if isinstance(like, TolerancedPose):
        axes = np.broadcast_to(np.eye(3), R.shape) if like.frame == "base" else turned
        phi = rotations.log(turned @ R)
        back = axes @ np.swapaxes(turned, -1, -2)
        e = np.concatenate([(axes @ offset)[..., 0], (back @ phi[..., None])[..., 0]], axis=1)
        J = np.concatenate([axes @ R @ J_b[:, :3], back @ log_rate(phi) @ J_b[:, 3:]], axis=1)
        over = np.abs(e) > like.tolerance
        return np.where(over, e - np.clip(e, -like.tolerance, like.tolerance), 0.0), J * (
            over | (like.tolerance == 0.0)
        )[..., None]
    e, J = (np.swapaxes(R, 1, 2) @ offset)[..., 0], J_b[:, :3]
    if isinstance(like, Pose):
        E = turned @ R
        spin = 0.5 * np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        return np.concatenate([e, spin], axis=1), J_b
    if isinstance(like, Approach):
        wanted = (np.swapaxes(R, 1, 2) @ ideal[:, :3, :3] @ like.axis[:, None])[..., 0]
        spin = np.cross(wanted, like.axis) @ like.across.T
        return np.concatenate([e, spin], axis=1), np.concatenate([J, like.across @ J_b[:, 3:]], axis=1)
    return e, J
