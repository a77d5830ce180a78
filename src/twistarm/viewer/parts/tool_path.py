"""The tool's path as a line through points in the base frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array, as_theta
from ...support.errors import InputError
from ..scene.axes import arm_size
from .limit_checks import check_trajectory, checked_theta

MOST_POINTS = 400
"""Most points: enough for any curve on a screen."""

STILL = 1e-4
"""Least visible step, as a share of the arm's size."""

NO_PATH: dict[str, Any] = {"points": [], "radius": 0.0, "ideal": [], "stopped": None, "waypoints": [], "ids": []}
"""points: the way of the tool; ideal: that of its segments; stopped: where a segment cannot be followed any farther;
waypoints: where everything stands at the poses, {node: matrix} each; ids: the numbers of these poses."""


def tool_path(arm: Arm, motion: Trajectory | ArrayLike) -> dict[str, Any]:
    """Points [[x, y, z], …] [m] of the tool's origin and the line's radius [m].

    A path without length has no points.

    `motion` is a trajectory of this arm or configurations (k, n) in order.
    """
    return {
        **NO_PATH,
        "points": drawn(arm, arm.fk(_configurations(arm, motion))[:, :3, 3]),
        "radius": 0.004 * arm_size(arm),
    }


def drawn(arm: Arm, points: Array) -> list[list[float]]:
    """The distinguishable points of (k, 3) [m]; none if all are in one place."""
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > STILL * arm_size(arm):
            kept.append(point)
    return np.round(kept, 6).tolist() if len(kept) > 1 else []


def _configurations(arm: Arm, motion: Trajectory | ArrayLike) -> Array:
    if isinstance(motion, Trajectory):
        check_trajectory(arm, motion)
        return motion(np.linspace(0.0, float(motion.duration), MOST_POINTS))
    theta = as_theta(motion, arm.n, "motion", names=arm.joint_names)
    if theta.ndim != 2 or len(theta) == 0:
        raise InputError(f"motion must be a Trajectory or configurations (k, {arm.n}); got shape {theta.shape}")
    for row in theta:
        checked_theta(arm, row)
    chosen: Array = theta[np.unique(np.linspace(0, len(theta) - 1, MOST_POINTS).round().astype(int))]
    return chosen
