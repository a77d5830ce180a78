"""Checks before showing a configuration, a trajectory or a joint value."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array, require
from ...support.errors import InputError, LimitError
from ..protocol.messages import LARGEST_VALUE

LIMIT_TOL = 1e-6
"""Rounding of a slider's end at a limit [rad, m], from decimal text."""


def checked_theta(arm: Arm, theta: ArrayLike) -> Array:
    """`theta` as one configuration (n,) that can be drawn."""
    array = arm.theta_from(theta)
    if array.ndim != 1:
        raise InputError(f"theta must be one configuration, shape ({arm.n},); got {array.shape}")
    if np.abs(array).max(initial=0.0) > LARGEST_VALUE:
        raise InputError(f"theta must be at most {LARGEST_VALUE:g} in size; got {np.abs(array).max():g}")
    return array


def check_trajectory(arm: Arm, trajectory: Trajectory) -> None:
    """InputError where `trajectory` is not one of this arm's joints."""
    require(trajectory, Trajectory, "trajectory", "as plan_joint returns it")
    if tuple(trajectory.joint_names) != tuple(arm.joint_names):
        raise InputError(
            f"the trajectory moves {', '.join(trajectory.joint_names)}; "
            f"{arm.name} has {', '.join(arm.joint_names)}: plan it for this arm"
        )
    checked_theta(arm, trajectory(0.0))


def require_all_inside(arm: Arm, theta: Array) -> None:
    """LimitError where a joint of `theta` (n,) is outside its limits."""
    limits = arm.limits
    for joint in zip(arm.joint_names, theta, limits.lower, limits.upper, arm.units, strict=True):
        require_inside(*joint)


def require_inside(name: str, value: float, lower: float, upper: float, unit: str) -> None:
    """Raise LimitError if a joint would leave its limits, in degrees first for angles."""
    if lower - LIMIT_TOL <= value <= upper + LIMIT_TOL:
        return
    in_si = f"{name} = {value:g} is outside its limits {lower:g} … {upper:g} {unit}"
    if unit != "rad":
        raise LimitError(in_si)
    low, given, high = np.degrees([lower, value, upper])
    in_rad = f"{value:g} rad, allowed {lower:g} … {upper:g} rad"
    raise LimitError(f"{name} = {given:.6g}° is outside its limits {low:.6g}° … {high:.6g}° ({in_rad})")
