"""Time laws: s(t) along a path in joint space, the limits they keep, and the quintic law.

The limits are rows C q' of joints and motors, torques, and a cap of ṡ from the tool's speed.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..limits.actuators import Actuators
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, frozen
from .piecewise import Indices, JointPath, bisected, composed, derivative, largest, rescaled, shifted
from .torque_limits import TorqueLimits
from .within import MARGIN, require_span, slowed_by

# Rise time [s] to the acceleration limit for joints without a jerk limit, in laws that limit the jerk.
RISE = 0.1
APART = 1e-12  # Instants nearer than this part of the whole are one.
# Coefficients of the fraction travelled in the fraction u of the time, highest power first.
UNIT = np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])

BISECTIONS = 60


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Limits along a path: of the joints, of any motors, and a cap of ṡ.

    Every moving joint, or a motor of it, has an acceleration limit. `limits` are of n joints. `actuators` have their
    limits on the motor side, motor = G theta + o. Velocity, acceleration and jerk count; positions do not. `ceiling`
    (m,) [1/s] is the largest ṡ per piece of the path, from limits of the tool's speed. `torques` None: any torque.
    """

    limits: JointLimits
    actuators: Actuators | None = None
    ceiling: Array | None = None
    torques: TorqueLimits | None = None

    @cached_property
    def C(self) -> Array:
        """(r, n): the rates of joints and motors are C theta_dot."""
        motors = () if self.actuators is None else (self.actuators.G,)
        return frozen(np.vstack([np.eye(len(self.limits.lower)), *motors]))

    @cached_property
    def rates(self) -> JointLimits:
        """Velocity, acceleration and given jerk of every row (r,), inf where there is no limit."""
        both = [self.limits, *([] if self.actuators is None else [self.actuators.limits])]
        names = ("velocity", "acceleration", "jerk")
        rates = {name: np.concatenate([getattr(limits, name) for limits in both]) for name in names}
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

    def capped(self, ceiling: Array | None) -> PathBounds:
        """The same limits with another cap of ṡ. What was worked out of them is kept."""
        other = copy(self)  # `replace` would drop the cached C, rates and jerk
        object.__setattr__(other, "ceiling", ceiling)
        return other

    def ceiling_of(self, path: JointPath) -> Array:
        """The largest ṡ on each of the path's pieces (m,), inf without a limit."""
        return np.full(len(path.breakpoints) - 1, np.inf) if self.ceiling is None else self.ceiling


@dataclass(frozen=True, eq=False)
class TimeLaw:
    """s(t) along a path from rest to rest, a polynomial on each of k pieces.

    `breakpoints` (k + 1,) [s] starts at 0; `coefficients` (degree + 1, k), highest power of t − breakpoints[i] first.
    Each of its pieces lies within one of the path's.
    """

    breakpoints: Array
    coefficients: Array

    def __post_init__(self) -> None:
        for name in ("breakpoints", "coefficients"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @classmethod
    def at_once(cls) -> TimeLaw:
        """The law of a path that stays where it is: of duration 0."""
        return cls(np.zeros(2), np.zeros((1, 1)))

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.breakpoints[-1])

    def pieces(self, path: JointPath) -> Indices:
        """In which piece of the path each of the law's lies, (k,)."""
        middle = np.zeros(len(self.breakpoints) - 1)
        for row in self.coefficients:
            middle = middle * (0.5 * np.diff(self.breakpoints)) + row
        return path.piece_at(middle)

    def passes(self, places: Array) -> Array:
        """When s (...) is reached, [s], at ends of the law's pieces."""
        s = np.append(self.coefficients[-1], max(places[-1], self.coefficients[-1, -1]))
        return np.interp(places, s, self.breakpoints)

    def along(self, path: JointPath) -> tuple[Array, Array]:
        """Breakpoints (k + 1,) [s] and coefficients (d, k, n) of the exact motion q(s(t))."""
        piece = self.pieces(path)
        inner = self.coefficients.copy()
        inner[-1] -= path.breakpoints[piece]
        return self.breakpoints, composed(path.coefficients[:, piece], inner)

    def at_full_pace(self, path: JointPath, bounds: PathBounds, jerk: Array) -> TimeLaw:
        """The law slowed until one rate just meets its limit. `jerk` (r,) is the limit of the jerk.

        A law slowed by f has 1/f of the velocity, 1/f² of the acceleration, 1/f³ of the jerk.
        """
        breakpoints, coefficients = self.along(path)
        steps = np.diff(breakpoints)
        speed = derivative(self.coefficients[:, :, None]) / bounds.ceiling_of(path)[self.pieces(path)][:, None]
        rates = slowed_by(coefficients @ bounds.C.T, steps, replace(bounds.rates, jerk=jerk))
        torques = 0.0 if bounds.torques is None else bounds.torques.slowing(breakpoints, coefficients)
        factor = max(rates, largest(speed, steps), torques) * (1.0 + MARGIN)
        require_span(self.duration * factor)
        return TimeLaw(self.breakpoints * factor, rescaled(self.coefficients, 1.0 / factor))


def distinct_instants(instants: Array) -> Array:
    """The instants in order, from 0 on, without those that only rounding tells from the next."""
    times = np.sort(instants, axis=None)
    times = np.concatenate([times[:-1][np.diff(times) > APART * times[-1]], times[-1:]])
    times[0] = 0.0
    return times


def quintic(path: JointPath, bounds: PathBounds) -> TimeLaw:
    """s = L (10 u³ − 15 u⁴ + 6 u⁵), u = t/T, with the least T that keeps every limit.

    Velocity and acceleration are zero at both ends. The jerk is limited where a jerk limit was given. A path that
    stays where it is takes no time. Source: Lynch & Park, Modern Robotics, §9.2.2.1.
    """
    if not path.moves:
        return TimeLaw.at_once()
    fraction = path.breakpoints / path.length
    ends = np.zeros_like(fraction), np.ones_like(fraction)
    _, u = bisected(lambda u: np.polyval(UNIT, u) < fraction, *ends, BISECTIONS)
    u[0], u[-1] = 0.0, 1.0
    pieces = np.repeat(path.length * UNIT[:, None], len(u) - 1, axis=1)
    law = TimeLaw(u, shifted(pieces, u[:-1]))
    return law.at_full_pace(path, bounds, bounds.rates.jerk)
