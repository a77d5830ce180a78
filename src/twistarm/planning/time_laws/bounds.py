"""PathBounds: speed limits along a path, as rows C q' of joints and motors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ...limits.actuators import Actuators
from ...limits.joint_limits import JointLimits
from ...support.checks import Array, frozen
from ..joint_path import JointPath

RISE = 0.1
"""Rise time [s] to the acceleration limit for joints without a jerk limit, in laws that limit the jerk."""

Owner = tuple[Literal["joint", "motor"], int]


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Limits along a path: of the joints, of any motors, and a cap of ṡ.

    Every moving joint, or a motor of it, has an acceleration limit. `limits` are of n joints. `actuators` have their
    limits on the motor side, motor = G theta + o. Velocity, acceleration and jerk count; positions do not. `ceiling`
    (m,) [1/s] is the largest ṡ per piece of the path, from limits of the tool's speed.
    """

    limits: JointLimits
    actuators: Actuators | None = None
    ceiling: Array | None = None

    @cached_property
    def C(self) -> Array:
        """(r, n): the rates of joints and motors are C theta_dot."""
        motors = () if self.actuators is None else (self.actuators.G,)
        return frozen(np.vstack([np.eye(len(self.limits.lower)), *motors]))

    @cached_property
    def owners(self) -> tuple[Owner, ...]:
        """The joint or motor of each row of C."""
        n = len(self.limits.lower)
        return tuple(("joint", row) if row < n else ("motor", row - n) for row in range(len(self.C)))

    @cached_property
    def rates(self) -> JointLimits:
        """Velocity, acceleration and given jerk of every row (r,), inf where there is no limit."""
        both = [self.limits, *([] if self.actuators is None else [self.actuators.limits])]
        names = ("velocity", "acceleration", "jerk")
        rates = {name: np.concatenate([getattr(each, name) for each in both]) for name in names}
        return replace(JointLimits.unbounded(len(self.C)), **rates)

    @property
    def velocity(self) -> Array:
        """(r,), inf where there is no limit."""
        return self.rates.velocity

    @property
    def acceleration(self) -> Array:
        """(r,), inf where there is no limit."""
        return self.rates.acceleration

    @cached_property
    def jerk(self) -> Array:
        """(r,); where none was given what brings the acceleration to its limit in 0.1 s."""
        given = self.rates.jerk
        return frozen(np.where(np.isinf(given), self.acceleration / RISE, given))

    def ceiling_of(self, path: JointPath) -> Array:
        """The largest ṡ on each of the path's pieces (m,), inf without a limit."""
        return np.full(len(path.breakpoints) - 1, np.inf) if self.ceiling is None else self.ceiling
