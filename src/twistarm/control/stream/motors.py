"""Setpoints and joint states on the motors' side, in rad and m or in counts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array, as_theta, require_choice
from ...support.errors import InputError, listed
from .protocols import Setpoint

UNITS = ("joint", "motor", "counts")
"""Units of values to and from a robot."""


class MotorSide:
    """The arm as its drives see it, motor = G theta + o, differentials included.

    units: "motor", rad and m on the motor side, or "counts" of the drives, not rounded.

    Raises InputError if the arm has no actuators, or joints that no motor determines.
    """

    def __init__(self, arm: Arm, units: str) -> None:
        if arm.actuators is None or arm.actuators.joint_names != arm.joint_names:
            raise InputError(
                f"units {units!r} need actuators for each joint of {arm.name}: [actuators] in its arm.toml"
            )
        if arm.actuators.undriven:
            raise InputError(f"no motor determines {listed(arm.actuators.undriven)} of {arm.name}")
        self._actuators = arm.actuators
        self.units = units
        self.names = arm.actuators.names
        self._scale = arm.actuators.counts_per_unit if units == "counts" else np.ones(len(self.names))

    def of(self, setpoint: Setpoint) -> tuple[Array, Array]:
        """Where the motors are to be (k,) and how fast they turn (k,), per second."""
        position = self._actuators.to_motor(setpoint.theta) * self._scale
        return position, self._actuators.velocity_to_motor(setpoint.theta_dot) * self._scale

    def theta(self, values: Sequence[float]) -> Array:
        """theta (n,) from what the motors (k,) say, in their order. InputError where they are not k finite numbers."""
        return self._actuators.to_theta(
            as_theta(values, len(self.names), "the motors' state", self.names) / self._scale
        )


def motor_side(arm: Arm, units: str) -> MotorSide | None:
    """The motors' side in these `UNITS`, None for "joint". InputError for other units, and as `MotorSide`."""
    require_choice(units, UNITS, "units")
    return None if units == "joint" else MotorSide(arm, units)
