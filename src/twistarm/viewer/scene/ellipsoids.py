"""Manipulability ellipsoids: the tool's velocities for joint rates with a norm of at most 1 rad/s."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ...theory.manipulability import scaled_jacobian


def ellipsoids(hybrid: Array, prismatic: Array, length: float) -> tuple[Array, Array]:
    """Semi-axes (2, 3), descending, and directions (2, 3, 3) as columns in base axes: linear, then angular.

    They describe {J θ̇ : ‖θ̇‖ ≤ 1 rad/s} for the linear [m/s] and angular [rad/s] rows of the hybrid Jacobian (6, n). A
    slide counts 1 m/s as 1/length rad/s. The semi-axes are singular values, the directions left singular vectors; 0
    where the tool does not move. Yoshikawa 1985, "Manipulability of robotic mechanisms"; MLS §3.4.4.
    """
    halves = scaled_jacobian(hybrid, prismatic, length).reshape(2, 3, -1)
    # Of fewer than three joints there would be fewer than three directions.
    padded = np.concatenate([halves, np.zeros((2, 3, max(0, 3 - halves.shape[-1])))], axis=-1)
    directions, semi_axes, _ = np.linalg.svd(padded, full_matrices=False)
    return semi_axes * np.array([[length], [1.0]]), directions
