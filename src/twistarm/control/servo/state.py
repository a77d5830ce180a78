"""The servo's state, carried from one step to the next."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...support.checks import Array, as_theta, frozen
from ...support.display import Brief
from ...support.errors import InputError

MAX_VALUE = 1e6
"""Greatest position and rate [rad, m, per s]."""


@dataclass(frozen=True, eq=False, repr=False)
class ServoState(Brief):
    """The commanded arm: theta (n,) [rad, m], its rates theta_dot (n,), and the held pose.

    theta integrates the commands and never the measurements, so noise cannot make it drift. `held` (4, 4) is the pose
    with held components, or None. `holding` are the flags of the command that holds them. `period` [s] is a slow mean
    of the steps, 0 before the first.
    """

    theta: Array
    theta_dot: Array
    held: Array | None = None
    holding: int | None = None
    period: float = 0.0

    @classmethod
    def at(cls, arm: Arm, theta: ArrayLike) -> ServoState:
        """At rest at the measured theta (n,). Raises InputError for anything but n finite numbers.

        Args:
            arm: The arm.
            theta: The measured configuration (n,) [rad, m].

        Returns:
            The state.

        Raises:
            InputError: theta is not one configuration of finite numbers.
        """
        return cls.moving(arm, require_arm(arm).theta_from(theta), np.zeros(arm.n))

    @classmethod
    def moving(cls, arm: Arm, theta: ArrayLike, theta_dot: ArrayLike) -> ServoState:
        """At the measured theta (n,), moving at theta_dot (n,). Raises InputError for anything but finite numbers.

        Args:
            arm: The arm.
            theta: The measured configuration (n,) [rad, m].
            theta_dot: The measured rates (n,) [rad/s, m/s].

        Returns:
            The state.

        Raises:
            InputError: One of them is not n finite numbers.
        """
        require_arm(arm)
        values = {"theta": theta, "theta_dot": theta_dot}
        checked = {name: as_theta(value, arm.n, name, arm.joint_names) for name, value in values.items()}
        for name, value in checked.items():
            if value.ndim != 1:
                raise InputError(f"{name} must be one configuration, shape ({arm.n},); got {value.shape}")
            if np.abs(value).max(initial=0.0) > MAX_VALUE:
                raise InputError(f"{name} must be at most {MAX_VALUE:g} in size; got {np.abs(value).max():g}")
        return cls(frozen(checked["theta"]), frozen(checked["theta_dot"]))
