"""Settings of the servo, and the bounds that they and an arm give it, prepared once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...arm import engine
from ...arm.abilities import NO_MOTION
from ...arm.arm import Arm
from ...arm.arm_data import kept
from ...limits.actuators import MotionLimits
from ...support.checks import Array, as_number, as_positive, frozen, require_choice, require_radians
from ...support.errors import InputError

SLIDE, STOP = "slide", "stop"
ON_UNREACHABLE = (SLIDE, STOP)


@dataclass(frozen=True)
class ServoSettings:
    """Settings of `servo_step`.

    length [m]: makes metres and radians comparable in singular values. None: the arm's `reach`.

    damping [s]: the τ of the servo's law (docs/servo.md), at least three steps. A twist of size V, in rad/s, is exact
    where the Jacobian's singular values are above √(τ V). More damping is calmer near singularities.

    on_unreachable: "slide" or "stop", at a joint limit or the end of the reach. The tool slides along as far as it can,
    or slows down and stops on course.

    singularity_threshold: singular values below this (rad per rad, see `Manipulability`) count as singular.

    position_margin [rad or m]: distance that joints keep from their position limits.

    max_dt [s]: longer steps are refused, because the arm was unwatched for so long.

    Raises InputError for numbers that are not positive (the margin may be 0).
    """

    length: float | None = None
    singularity_threshold: float = 0.04
    damping: float = 0.03
    on_unreachable: str = SLIDE
    position_margin: float = 0.0
    max_dt: float = 0.1

    def __post_init__(self) -> None:
        for name in ("length", "singularity_threshold", "damping", "max_dt"):
            value = getattr(self, name)
            if value is not None or name != "length":
                object.__setattr__(self, name, as_positive(value, name))
        if self.singularity_threshold <= NO_MOTION:
            raise InputError(f"singularity_threshold must be more than {NO_MOTION:g}, which counts as no motion at all")
        require_choice(self.on_unreachable, ON_UNREACHABLE, "on_unreachable")
        margin = require_radians(as_number(self.position_margin, "position_margin", 0.0), "position_margin")
        object.__setattr__(self, "position_margin", margin)


@dataclass(frozen=True, eq=False)
class ServoBounds:
    """The data of an arm for a servo step.

    motion: the limits of motors with limits and then of joints (the last n rows), less the position margin. unit (n,):
    1 for an angle, `length` for a slide: so far it moves for a scaled rad. ready (n,): the configuration that shows an
    exactly singular arm the way out. The rest as in `ServoSettings`.
    """

    motion: MotionLimits
    unit: Array
    ready: Array
    length: float
    singularity_threshold: float
    damping: float
    stops: bool
    compiled: engine.Servo

    def stopping_time(self, theta_dot: Array) -> float:
        """How long a straight stop from these rates (n,) takes [s]."""
        return float(max(map(abs, (self._slowness @ theta_dot).tolist())))

    @cached_property
    def _slowness(self) -> Array:
        return self.motion.C / self.motion.limits.acceleration[:, None]


def bounds_of(arm: Arm, settings: ServoSettings) -> ServoBounds:
    """The bounds of an arm, kept for as long as the arm lives."""
    return kept(arm, ("servo bounds", settings), lambda: _prepare(arm, settings))


Numbers = tuple[float, float, float]


def servo_numbers(arm: Arm, settings: ServoSettings) -> tuple[MotionLimits, tuple[Array, ...], Numbers]:
    """The limits of motors and joints, and what the core's servo takes: arrays, and length, threshold and damping."""
    length = arm.reach if settings.length is None else settings.length
    unit = np.where(np.array(arm.units) == "m", length, 1.0)
    motion = _motion(arm, settings.position_margin)
    motors, limits = len(motion.names) - arm.n, motion.limits
    rows = (limits.lower, limits.upper, limits.velocity, limits.acceleration)
    arrays = (arm.screws, arm.home, arm.coupling.A, motion.C[:motors], motion.c[:motors], *rows, unit, arm.ready)
    doubles = tuple(np.ascontiguousarray(array, dtype=np.float64) for array in arrays)
    return motion, doubles, (length, settings.singularity_threshold, settings.damping)


def _prepare(arm: Arm, settings: ServoSettings) -> ServoBounds:
    (motion, arrays, numbers), stops = servo_numbers(arm, settings), settings.on_unreachable == STOP
    compiled = engine.servo_of(arrays, *numbers, stops)
    return ServoBounds(motion, frozen(arrays[-2]), arm.ready, *numbers, stops, compiled)


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
