"""Limits of efforts: of joints, and of motors on their side of the gears."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..limits.joint_limits import AS_GOOD_AS_UNBOUNDED
from ..support.checks import Array
from .arm import Arm

RATIO_ROUNDING = 1e-9  # Entries of P below this share of the largest are the rounding of 0.


class EffortLimits(NamedTuple):
    """Rows of joints, then motors: |W τ| ≤ `limits` (r,) [N m, N], for W (r, n). Their velocities are C θ̇.

    `unlimited` (n,) marks the joints without a limit.
    """

    names: tuple[str, ...]
    W: Array
    C: Array
    limits: Array
    unlimited: NDArray[np.bool_]


def effort_limits(arm: Arm, effort: Array | None = None) -> EffortLimits:
    """The limits of joints, `effort` (n,) or those of the arm, and of its motors.

    A joint has a limit by itself, or if all its motors have one. Motors count if they determine every joint.
    """
    limits = arm.limits.effort if effort is None else effort
    names, W, C = arm.joint_names, np.eye(arm.n), np.eye(arm.n)
    unlimited, motors = limits >= AS_GOOD_AS_UNBOUNDED, arm.actuators
    if motors is not None and not motors.undriven:
        carries = np.abs(motors.P) > RATIO_ROUNDING * np.abs(motors.P).max()
        unlimited = unlimited & (carries & (motors.limits.effort >= AS_GOOD_AS_UNBOUNDED)).any(axis=1)
        names += tuple(f"motor {name}" for name in motors.names)
        W, C, limits = np.vstack([W, motors.P.T]), np.vstack([C, motors.G]), np.append(limits, motors.limits.effort)
    return EffortLimits(names, W, C, np.where(limits < AS_GOOD_AS_UNBOUNDED, limits, np.inf), unlimited)
