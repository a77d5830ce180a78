"""PathBounds: what limits the speed along a path, as rows C q' of joints and motors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from ...limits.actuators import Actuators
from ...limits.joint_limits import JointLimits
from ...support.checks import Array, as_reals, frozen
from ...support.errors import InputError
from ..joint_path import JointPath

RISE = 0.1
"""In this time [s] what has no jerk limit comes to its acceleration limit, in laws that limit the jerk."""

Owner = tuple[Literal["joint", "motor"], int]


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Limits along a path: those of the joints, of the motors where there are any, and a cap of ṡ.

    `limits` are of n joints, and `actuators` have theirs on the motors' side of the gears, motor = G theta + o; their
    velocity, acceleration and jerk count (positions are the path's own matter). `ceiling` (m,) [1/s] is the largest ṡ
    on each piece of the path, ∞ where there is none: limits of the tool's speed come by it.
    """

    limits: JointLimits
    actuators: Actuators | None = None
    ceiling: Array | None = None

    def __post_init__(self) -> None:
        if self.ceiling is not None:
            ceiling = frozen(as_reals(self.ceiling, "ceiling"))
            if ceiling.ndim != 1 or not (ceiling > 0).all():
                raise InputError(f"ceiling must be a positive ṡ for each piece of the path; got {ceiling.tolist()}")
            object.__setattr__(self, "ceiling", ceiling)

    @cached_property
    def C(self) -> Array:
        """(r, n): the rates of joints and motors are C theta_dot."""
        motors = () if self.actuators is None else (self.actuators.G,)
        return frozen(np.vstack([np.eye(len(self.limits.lower)), *motors]))

    @cached_property
    def owners(self) -> tuple[Owner, ...]:
        """Whose rate each row of C is."""
        n = len(self.limits.lower)
        return tuple(("joint", row) if row < n else ("motor", row - n) for row in range(len(self.C)))

    @cached_property
    def velocity(self) -> Array:
        """(r,), inf where there is no limit."""
        return self._both("velocity")

    @cached_property
    def acceleration(self) -> Array:
        """(r,), inf where there is no limit."""
        return self._both("acceleration")

    @cached_property
    def jerk(self) -> Array:
        """(r,); where none was given what brings the acceleration to its limit in 0.1 s."""
        return frozen(np.where(np.isinf(self.given_jerk), self.acceleration / RISE, self.given_jerk))

    @cached_property
    def given_jerk(self) -> Array:
        """(r,), inf where there is no limit."""
        return self._both("jerk")

    @cached_property
    def rates(self) -> JointLimits:
        """Velocity, acceleration and given jerk of every row, (r,)."""
        rates = {"velocity": self.velocity, "acceleration": self.acceleration, "jerk": self.given_jerk}
        return replace(JointLimits.unbounded(len(self.C)), **rates)

    def ceiling_of(self, path: JointPath) -> Array:
        """The largest ṡ on each of the path's pieces (m,), inf where there is none."""
        m = len(path.breakpoints) - 1
        if self.ceiling is None:
            return np.full(m, np.inf)
        if len(self.ceiling) != m:
            raise InputError(f"ceiling must be {m} numbers, one for each piece of the path; got {len(self.ceiling)}")
        return self.ceiling

    def require(self, path: JointPath) -> None:
        """Raise InputError where the limits are not those of the path's joints, or a joint that moves has none."""
        if path.n != len(self.limits.lower):
            raise InputError(f"the limits are of {len(self.limits.lower)} joints, the path is of {path.n}")
        held = (self.C[np.isfinite(self.acceleration)] != 0).any(axis=0)
        free = np.flatnonzero(path.coefficients[:-1].any(axis=(0, 1)) & ~held)
        if free.size:
            raise InputError(
                f"no acceleration limit for joint {free[0]} (counted from 0): neither its own nor a motor's"
            )

    def _both(self, rate: str) -> Array:
        joints: Array = getattr(self.limits, rate)
        if self.actuators is None:
            return joints
        return frozen(np.concatenate([joints, getattr(self.actuators.limits, rate)]))
