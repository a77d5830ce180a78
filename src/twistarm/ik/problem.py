"""An arm and a target as a problem of two levels, position and rotation, in joints and slack inside bounds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..arm import Arm
from ..checks import Array
from .task_space import Rows, Target

ROUNDING = 1e-12
"""A coordinate this near to its bound [rad, m] stands at it."""


@dataclass(frozen=True, eq=False)
class Problem:
    """An arm and a target as a problem in x = (theta, slack) inside bounds: a tolerance is a slack within ± itself."""

    arm: Arm
    target: Target
    lower: Array
    upper: Array

    def start(self, theta: Array) -> Array:
        """x of a configuration (n,), with no slack taken up yet."""
        return np.clip(np.pad(theta, (0, len(self.lower) - len(theta))), self.lower, self.upper)

    def holding_bounds(self, x: Array) -> Problem:
        """The same problem with every coordinate that x has at a bound held there.

        A step along a bound would otherwise be bent off it on the way back to the position, and follow it in tiny hops.
        """
        low, high = x <= self.lower + ROUNDING, x >= self.upper - ROUNDING
        return replace(self, lower=np.where(high, self.upper, self.lower), upper=np.where(low, self.lower, self.upper))

    def position(self, x: Array) -> Rows:
        """Position error [m] less its slack, and the derivative with respect to x."""
        rows = self.target.position_rows(*self.arm.fk_and_body_jacobian(x[: self.arm.n]))
        return self._slackened(rows, self.target.position_tolerance, x, self.arm.n)

    def rotation(self, x: Array) -> Rows:
        """Rotation error less its slack, and its rows."""
        rows = self.target.rotation_rows(*self.arm.fk_and_body_jacobian(x[: self.arm.n]))
        first = self.arm.n + int(np.count_nonzero(self.target.position_tolerance))
        return self._slackened(rows, self.target.rotation_tolerance, x, first)

    def distance(self, x: Array) -> float:
        """Length of the position error [m]."""
        return float(np.linalg.norm(self.position(x)[0]))

    def turn(self, x: Array) -> float:
        """Length of the rotation error."""
        return float(np.linalg.norm(self.rotation(x)[0]))

    def position_slope(self, x: Array) -> Array:
        """Gradient of ½ distance²."""
        error, J = self.position(x)
        slope: Array = J.T @ error
        return slope

    def rotation_slope(self, x: Array) -> Array:
        """Gradient of a function that grows with the rotation error."""
        error, J = self.rotation(x)
        slope: Array = J.T @ error
        return slope

    def _slackened(self, rows: Rows, tolerance: Array, x: Array, first: int) -> Rows:
        if len(x) == self.arm.n:
            return rows
        error, J = rows
        banded = np.flatnonzero(tolerance)
        wide = np.zeros((len(error), len(x)))
        wide[:, : self.arm.n] = J
        wide[banded, first + np.arange(len(banded))] = -1.0
        return error + wide[:, self.arm.n :] @ x[self.arm.n :], wide


@dataclass(frozen=True, eq=False)
class PositionAlone(Target):
    """The position that a target asks for, its rotation left free."""

    whole: Target

    rotation_tolerance: ClassVar[Array] = np.zeros(0)

    @property
    def position_tolerance(self) -> Array:
        """That of the whole target."""
        return self.whole.position_tolerance

    def position_rows(self, g: Array, J_b: Array) -> Rows:
        """Those of the whole target."""
        return self.whole.position_rows(g, J_b)

    def rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """None."""
        return np.zeros(0), J_b[:0]

    def position_error(self, g: Array) -> float:
        """That of the whole target [m]."""
        return self.whole.position_error(g)

    def orientation_error(self, g: Array) -> float:
        """0: the rotation is free."""
        return 0.0

    def at(self, g: Array) -> PositionAlone:
        """That of the whole target at g."""
        return PositionAlone(self.whole.at(g))

    def asked(self) -> str:
        """The target in words."""
        return f"the position of {self.whole.asked()}"


def problem_of(arm: Arm, target: Target, lower: Array, upper: Array) -> Problem:
    """The problem inside the joint bounds `lower`, `upper` (n,), which may be infinite."""
    slack = np.concatenate([t[t > 0] for t in (target.position_tolerance, target.rotation_tolerance)])
    return Problem(arm, target, np.concatenate([lower, -slack]), np.concatenate([upper, slack]))
