"""Bounds of the servo: the limits of joints and motors, prepared once for each arm."""

from __future__ import annotations

import weakref
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...arm import engine
from ...arm.arm import Arm
from ...limits.motion_limits import MotionLimits
from ...support.checks import Array, frozen
from .settings import STOP, ServoSettings


@dataclass(frozen=True, eq=False)
class ServoBounds:
    """The data of an arm for a servo step.

    motion: the limits of motors with limits and of joints, less the position margin. The joints are its last n rows.
    unit (n,): the factor from a coordinate's scaled number in rad, 1 or `length` for a slide. ready (n,): the
    configuration that shows an exactly singular arm the way out. The rest as in `ServoSettings`.
    """

    motion: MotionLimits
    unit: Array
    ready: Array
    length: float
    singularity_threshold: float
    damping: float
    stops: bool
    compiled: engine.Servo

    @property
    def n(self) -> int:
        """Degrees of freedom."""
        return len(self.unit)

    def stopping_time(self, theta_dot: Array) -> float:
        """How long a straight stop from these rates (n,) takes [s]."""
        return float(max(map(abs, (self._slowness @ theta_dot).tolist())))

    @cached_property
    def _slowness(self) -> Array:
        return self.motion.C / self.motion.limits.acceleration[:, None]


_KEPT: weakref.WeakKeyDictionary[Arm, dict[ServoSettings, ServoBounds]] = weakref.WeakKeyDictionary()


def bounds_of(arm: Arm, settings: ServoSettings) -> ServoBounds:
    """The bounds of an arm, kept for as long as the arm lives."""
    kept = _KEPT.get(arm)
    if kept is None:
        kept = _KEPT.setdefault(arm, {})
    found = kept.get(settings)
    if found is None:
        found = kept.setdefault(settings, _made(arm, settings))
    return found


def _made(arm: Arm, settings: ServoSettings) -> ServoBounds:
    length = arm.reach if settings.length is None else settings.length
    unit = frozen(np.where(np.array(arm.units) == "m", length, 1.0))
    motion, stops = _motion(arm, settings.position_margin), settings.on_unreachable == STOP
    numbers = length, settings.singularity_threshold, settings.damping
    compiled = engine.servo_of(_core_arguments(arm, motion, unit), *numbers, stops)
    return ServoBounds(motion, unit, arm.ready, *numbers, stops, compiled)


def _core_arguments(arm: Arm, motion: MotionLimits, unit: Array) -> tuple[Array, ...]:
    """What the core's servo takes: chain, motors' rows, limits of all rows, unit and ready."""
    motors, limits = len(motion.names) - arm.n, motion.limits
    rates = (limits.lower, limits.upper, limits.velocity, limits.acceleration)
    arrays = (arm.screws, arm.home, arm.coupling.A, motion.C[:motors], motion.c[:motors], *rates, unit, arm.ready)
    return tuple(np.ascontiguousarray(array, dtype=np.float64) for array in arrays)


def _motion(arm: Arm, margin: float) -> MotionLimits:
    limits, motors = arm.limits, arm.actuators
    lower, upper = limits.lower + margin, limits.upper - margin
    # A margin wider than the range leaves the middle of it.
    crossed = lower > upper
    lower[crossed] = upper[crossed] = (limits.lower[crossed] + limits.upper[crossed]) / 2
    inside = replace(limits, lower=lower, upper=upper)
    if motors is None:
        return MotionLimits(arm.joint_names, np.eye(arm.n), np.zeros(arm.n), inside)
    # The end of a motor that drives one joint is that joint's end, at which the others keep what is left of the motion.
    own = motors.joint_limits
    ends = np.maximum(inside.lower, own.lower), np.minimum(inside.upper, own.upper)
    if (ends[0] <= ends[1]).all():
        inside = replace(inside, lower=ends[0], upper=ends[1])
    return motors.motion_limits(inside)
