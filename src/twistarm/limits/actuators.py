"""Joint coordinates to motors and back, motor = G theta + o: geared, belted and differential joints."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_floats, as_reals, as_theta, frozen, require, require_names
from ..support.display import Brief, short_repr
from ..support.errors import InputError, listed
from ..support.units import factor
from .joint_limits import JointLimits

TURNING_UNITS, LINEAR_UNITS = ("rad", "deg", "turn"), ("m", "mm")
# Units of the counts of a drive that turns or pushes. For ticks see `ticks_per_turn`.
UNITS = (*TURNING_UNITS, "tick", *LINEAR_UNITS)
# Relative to the equilibrated G. Gear ratios have a few digits, so their differences are not smaller.
RANK_TOL = 1e-9
NOT_GIVEN = JointLimits.unbounded(0)  # Limits of no motor: replaced by unbounded ones for all motors.


@dataclass(frozen=True, eq=False, repr=False)
class MotionLimits(Brief):
    """Limits of x = C theta + c, one row per motor or joint. C (r, n), c (r,) [rad or m]. The servo keeps them all."""

    names: tuple[str, ...]
    C: Array
    c: Array
    limits: JointLimits

    def __post_init__(self) -> None:
        for name in ("C", "c"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        r = len(self.names)
        if not r or self.C.ndim != 2 or {len(self.C), self.c.size, self.limits.lower.size} != {r}:
            shapes = f"C {self.C.shape}, c {self.c.shape}"
            raise InputError(f"{r} names, {shapes} and limits must have the same number of rows, at least 1")


@dataclass(frozen=True, eq=False, repr=False)
class Actuators:
    """k motors that drive n joints: motor = G theta + o, in rad, or m for slides.

    `G` (k, n) holds motor rad per joint rad (rad per m for a slide). `offset` (k,) holds the motors at theta = 0. A
    motor on one joint has one entry in its row. Each motor of a differential wrist has two. `units` are those of each
    drive's counts (`UNITS`), `ticks_per_turn` (k,) their resolution or NaN. `limits` are those of the k motors, on the
    motors' side of the gears.

    - Positions [rad, m]: `to_motor` is G theta + o, `to_theta` is P (motor − o).
    - Velocities and accelerations [per s, s²]: `velocity_to_motor` is G theta_dot. `velocity_to_theta` is P motor_dot.
    - Torques [N m, N]: `torque_to_motor` is Pᵀ tau, `torque_to_theta` is Gᵀ tau_motor.

    Torques follow from the power, tau_motor · motor_dot = tau · theta_dot, in gears without friction. P = G⁻¹ for as
    many motors as joints. With more motors P is the pseudo-inverse. Positions and velocities are then least squares
    over all motors [rad, m]. Torques have the least ‖tau_motor‖. Where a joint is `undriven`, methods that need P raise
    InputError. All take leading axes: (..., n), (..., k).

    Raises InputError for wrong shapes, numbers that are not finite, an unknown unit or bad ticks. It does so too for
    position limits that leave a joint no place.
    """

    names: tuple[str, ...]
    joint_names: tuple[str, ...]
    G: Array
    offset: Array
    units: tuple[str, ...]
    ticks_per_turn: Array
    limits: JointLimits = NOT_GIVEN

    def __post_init__(self) -> None:
        for name in ("names", "joint_names", "units"):
            object.__setattr__(self, name, require_names(getattr(self, name), name))
        require(self.limits, JointLimits, "limits", "of the motors")
        k, n = len(self.names), len(self.joint_names)
        for name, shape in {"G": (k, n), "offset": (k,)}.items():
            values = as_floats(getattr(self, name), name)
            if values.shape != shape:
                raise InputError(f"{name} of {k} actuators and {n} joints must have shape {shape}; got {values.shape}")
            object.__setattr__(self, name, frozen(values))
        ticks = frozen(as_reals(self.ticks_per_turn, "ticks_per_turn"))
        if ticks.shape != (k,) or len(self.units) != k:
            raise InputError(f"{k} actuators need {k} units and ticks_per_turn; got {len(self.units)}, {ticks.shape}")
        object.__setattr__(self, "ticks_per_turn", ticks)
        for name, unit, count in zip(self.names, self.units, ticks, strict=True):
            if unit not in UNITS:
                raise InputError(f"actuator {name!r} counts in {unit!r}; allowed: {', '.join(UNITS)}")
            if not (np.isnan(count) or 0 < count < np.inf):
                raise InputError(f"actuator {name!r}: ticks_per_turn must be positive; got {count:g}")
            if unit == "tick" and np.isnan(count):
                raise InputError(f"actuator {name!r} counts in ticks: give its ticks_per_turn")
            if unit in LINEAR_UNITS and not np.isnan(count):
                raise InputError(f"actuator {name!r} counts in {unit} and makes no turns: leave out ticks_per_turn")
        if self.limits.lower.size not in (0, k):
            raise InputError(f"limits of {k} actuators must be those of {k} motors; got {self.limits.lower.size}")
        if self.limits.lower.size != k:
            object.__setattr__(self, "limits", JointLimits.unbounded(k))
        _ = self.joint_limits

    def __repr__(self) -> str:
        return short_repr("Actuators", {"names": self.names, "joint_names": self.joint_names})

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def undriven(self) -> tuple[str, ...]:
        """Joints in the null space of G, which the motors do not determine."""
        scaled = self.G * _factors(self.G, axis=1)
        scaled = scaled * _factors(scaled, axis=0)
        _, values, Vt = np.linalg.svd(scaled)
        null = Vt[int((values > RANK_TOL * max(values.max(initial=0.0), 1.0)).sum()) :]
        free = np.abs(null).max(axis=0, initial=0.0) > RANK_TOL
        return tuple(name for name, loose in zip(self.joint_names, free, strict=True) if loose)

    @property
    def motor_units(self) -> tuple[str, ...]:
        """The unit of each motor's position: rad, or m where its drive pushes."""
        return tuple("m" if unit in LINEAR_UNITS else "rad" for unit in self.units)

    # -- positions, velocities, torques ------------------------------------------------------------------------------

    def to_motor(self, theta: ArrayLike) -> Array:
        """Return motor = G theta + o: theta (..., n) to motors (..., k) [rad or m]."""
        return self._joints(theta, "theta") @ self.G.T + self.offset

    def to_theta(self, motor: ArrayLike) -> Array:
        """Return theta (..., n) with G theta + o = motor, from motors (..., k) [rad or m].

        With more motors than joints it minimizes ‖G theta + o − motor‖ [rad, m]. Raises InputError with the joints that
        the motors do not determine.
        """
        return (self._motors(motor, "motor") - self.offset) @ self.P.T

    def velocity_to_motor(self, theta_dot: ArrayLike) -> Array:
        """motor_dot = G theta_dot, (..., n) to (..., k) [rad/s or m/s]. Accelerations work alike."""
        return self._joints(theta_dot, "theta_dot") @ self.G.T

    def velocity_to_theta(self, motor_dot: ArrayLike) -> Array:
        """theta_dot (..., n) with G theta_dot = motor_dot (..., k) [rad/s or m/s], like `to_theta`."""
        return self._motors(motor_dot, "motor_dot") @ self.P.T

    def torque_to_motor(self, tau: ArrayLike) -> Array:
        """tau_motor (..., k) with Gᵀ tau_motor = tau (..., n) [N m or N] and the least ‖tau_motor‖.

        Raises InputError with the joints that the motors do not determine.
        """
        return self._joints(tau, "tau") @ self.P

    def torque_to_theta(self, tau_motor: ArrayLike) -> Array:
        """Joint torques tau = Gᵀ tau_motor (..., n) [N m or N] of motor torques (..., k)."""
        return self._motors(tau_motor, "tau_motor") @ self.G

    def to_counts(self, motor: ArrayLike) -> Array:
        """Return motors (..., k) [rad or m] in each drive's `units`. Ticks are not rounded. Rates alike."""
        return self._motors(motor, "motor") * self.counts_per_unit

    def from_counts(self, counts: ArrayLike) -> Array:
        """Return motors (..., k) [rad or m] from counts: the inverse of `to_counts`."""
        return self._motors(counts, "counts") / self.counts_per_unit

    # -- limits ------------------------------------------------------------------------------------------------------

    def motion_limits(self, joints: JointLimits) -> MotionLimits:
        """Return the limits of the motors, by rows of G, and of the n joints."""
        n = len(self.joint_names)
        if require(joints, JointLimits, "joints", "as an arm's limits are").lower.size != n:
            raise InputError(f"joints must be the limits of {n} joints ({listed(self.joint_names)})")
        both = {field: np.concatenate([getattr(self.limits, field), getattr(joints, field)]) for field in vars(joints)}
        C, c = np.vstack([self.G, np.eye(n)]), np.concatenate([self.offset, np.zeros(n)])
        return MotionLimits(self.names + self.joint_names, C, c, JointLimits(**both))

    @cached_property
    def joint_limits(self) -> JointLimits:
        """Limits of each joint while the others are at rest; ∓inf without limits of the motors.

        velocity_j = min_i velocity_i / |G_ij|, acceleration alike. effort_j = min_i effort_i / |P_ij| holds a torque at
        joint j and none elsewhere. Positions come only from motors that drive joint j alone. Other bounds would depend
        on the other joints.
        """
        n = len(self.joint_names)
        alone = np.where((self.G != 0).sum(axis=1, keepdims=True) == 1, self.G, 0.0)
        ends = (np.stack([self.limits.lower, self.limits.upper]) - self.offset)[..., None] / _divisor(alone)
        lower = np.where(alone, ends.min(axis=0), -np.inf).max(axis=0, initial=-np.inf)
        upper = np.where(alone, ends.max(axis=0), np.inf).min(axis=0, initial=np.inf)
        if (lower > upper).any():
            j = int(np.argmax(lower > upper))
            raise InputError(f"the position limits of the motors allow joint {self.joint_names[j]!r} no position")
        effort = np.full(n, np.inf) if self.undriven else _least(self.limits.effort, self.P.T)
        velocity, acceleration = _least(self.limits.velocity, self.G), _least(self.limits.acceleration, self.G)
        return JointLimits(lower, upper, velocity, acceleration, np.full(n, np.inf), effort)

    # -- inside ------------------------------------------------------------------------------------------------------

    @cached_property
    def P(self) -> Array:
        """P (n, k), with P G = I. Raises InputError naming the joints that the motors do not determine."""
        if self.undriven:
            raise InputError(
                f"the motors {listed(self.names)} do not determine joint {listed(self.undriven)}: "
                "G must have full column rank; describe the motors that drive them"
            )
        # A square G has one solution, however its rows are scaled; least squares would be weighed by that.
        rows = _factors(self.G, axis=1) if len(self.names) == len(self.joint_names) else np.ones((len(self.names), 1))
        columns = _factors(self.G * rows, axis=0)
        return frozen(columns.T * np.linalg.pinv(self.G * rows * columns) * rows.T)

    @cached_property
    def counts_per_unit(self) -> Array:
        """Counts of each drive for one rad (or m) of its motor, (k,)."""
        ticks = self.ticks_per_turn / (2 * np.pi)
        units = zip(self.units, self.motor_units, ticks, strict=True)
        return frozen([count if unit == "tick" else 1.0 / factor(unit, si) for unit, si, count in units])

    def _joints(self, values: ArrayLike, name: str) -> Array:
        return as_theta(values, len(self.joint_names), name, self.joint_names)

    def _motors(self, values: ArrayLike, name: str) -> Array:
        return as_theta(values, len(self.names), name, self.names)


def _factors(G: Array, axis: int) -> Array:
    """Return factors that make rows (axis 1) or columns (axis 0) of G unit vectors."""
    size = np.linalg.norm(G, axis=axis, keepdims=True)
    return 1.0 / np.where(size == 0, 1.0, size)


def _least(limit: Array, ratio: Array) -> Array:
    """Return min_i limit_i / |ratio_ij|, (n,), for motors (k,) and ratios (k, n)."""
    by_motor = np.where(ratio, limit[:, None] / _divisor(np.abs(ratio)), np.inf)
    return by_motor.min(axis=0, initial=np.inf)


def _divisor(ratio: Array) -> Array:
    """Return the ratios, with 1 for 0."""
    return np.where(ratio, ratio, 1.0)
