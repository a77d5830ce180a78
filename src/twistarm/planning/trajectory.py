"""Trajectory: a joint motion in time, as plain data; and what files hold of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..limits.actuators import Actuators
from ..limits.joint_limits import JointLimits
from ..support.checks import Array, as_floats, as_number, frozen, require, require_names
from ..support.display import in_brief, short_repr
from ..support.errors import InputError, listed, quote
from .piecewise import derivative, evaluate, largest

RATE_UNITS = ("", "/s", "/s²", "/s³")  # What follows a joint's unit for the derivative of each order.
MAX_SAMPLES = 10_000_000  # More samples than this are a mistaken `dt`.
LAST_STEP = 1e-3  # A last step shorter than this share of `dt` joins the step before it.


class Samples(NamedTuple):
    """A trajectory at m instants: `t` (m,) [s], strictly increasing, positions and rates (m, n) [rad, m]."""

    t: Array
    theta: Array
    theta_dot: Array
    theta_ddot: Array

    def __repr__(self) -> str:
        return short_repr("Samples", self._asdict())


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """theta(t) of n joints, a polynomial on each of s pieces. The motion begins and ends at rest.

    `breakpoints` (s + 1,) [s] starts at 0 and increases. `coefficients` (degree + 1, s, n) has the highest power of t −
    breakpoints[i] first, like `PPoly` of SciPy. The motion passes the planned `waypoints` (k, n) at `times` (k,) [s].
    Merged waypoints have equal times. A motion from a point to itself has duration 0 and one piece of no length.
    `actuators` are the arm's motors or None; files hold their values too. `labels` are actions on the way in order of
    time, pairs such as (1.5, "close gripper"). Every file contains them. `notes` say what was assumed, such as limits.
    `limits` are those that the motion was planned with, or None. No file contains notes and limits.
    """

    joint_names: tuple[str, ...]
    units: tuple[str, ...]
    waypoints: Array
    times: Array
    breakpoints: Array
    coefficients: Array
    actuators: Actuators | None = None
    labels: tuple[tuple[float, str], ...] = ()
    notes: tuple[str, ...] = ()
    limits: JointLimits | None = None

    def __post_init__(self) -> None:
        for name in ("joint_names", "units"):
            object.__setattr__(self, name, require_names(getattr(self, name), name))
        for name in ("waypoints", "times", "breakpoints", "coefficients"):
            object.__setattr__(self, name, frozen(as_floats(getattr(self, name), name)))
        n, k, s = len(self.joint_names), self.times.size, self.breakpoints.size - 1
        shapes = {"waypoints": (k, n), "times": (k,), "breakpoints": (s + 1,)}
        wrong = any(getattr(self, name).shape != shape for name, shape in shapes.items())
        if wrong or self.coefficients.shape[1:] != (s, n) or len(self.units) != n:
            raise InputError(
                f"a trajectory of {n} joints with {k} times and {s + 1} breakpoints needs waypoints {(k, n)} and "
                f"coefficients (degree + 1, {s}, {n}); got {self.waypoints.shape} and {self.coefficients.shape}"
            )
        steps = np.diff(self.breakpoints)
        if s < 1 or self.breakpoints[0] != 0 or not ((steps > 0).all() or (s == 1 and steps[0] == 0)):
            raise InputError("the breakpoints of a trajectory must increase from 0")
        if self.actuators is not None:
            require(self.actuators, Actuators, "actuators", "as arm.actuators")
        object.__setattr__(self, "labels", _as_labels(self.labels, self.duration))

    def __repr__(self) -> str:
        through = f"{self.duration:.4g} s through {len(self.times)} waypoints"
        return f"Trajectory({through}; joints {in_brief(self.joint_names)})"

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.joint_names)

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(self.breakpoints[-1])

    def __call__(self, t: ArrayLike, order: int = 0) -> Array:
        """Return that derivative (0 … 3) at t (...) [s], (..., n): rad or m, and per s, s², s³.

        Outside [0, duration] the position of the nearer end holds and derivatives are zero. At both ends the velocity
        is zero and other derivatives are the limits from inside. At a breakpoint, where a derivative may jump, it is
        the limit from above.
        """
        _check_order(order)
        times = as_floats(t, "t")
        at = times.ravel()
        piece = np.clip(np.searchsorted(self.breakpoints, at, side="right") - 1, 0, len(self.breakpoints) - 2)
        tau = (at - self.breakpoints[piece])[:, None]
        values = evaluate(derivative(self.coefficients[:, piece], order), tau)
        before, after = at <= 0, at >= self.duration
        if order == 0:  # to the bit: the polynomials end at the waypoints up to rounding
            values[before], values[after] = self.waypoints[0], self.waypoints[-1]
        elif order == 1:
            values[before | after] = 0.0
        else:
            values[(at < 0) | (at > self.duration)] = 0.0
        return values.reshape(*times.shape, self.n)

    def peak(self, order: int) -> Array:
        """Return the largest magnitude of that derivative (0 … 3) over the whole motion, (n,), to 1e-10."""
        _check_order(order)
        rates, steps = derivative(self.coefficients, order), np.diff(self.breakpoints)
        return np.array([largest(rates[:, :, j : j + 1], steps) for j in range(self.n)])

    def sample(self, dt: float) -> Samples:
        """Return position, velocity and acceleration every `dt` [s] from 0 on, and at `duration` exactly.

        The last step may be shorter. A trajectory of duration 0 gives one sample.
        """
        step = as_floats(dt, "dt")
        if step.ndim or step <= 0 or self.duration / float(step) > MAX_SAMPLES:
            raise InputError(
                f"dt must be one positive number [s] that gives at most {MAX_SAMPLES:,} samples of "
                f"{self.duration:g} s; got {dt}"
            )
        steps = max(ceil(self.duration / float(step) - LAST_STEP), int(self.duration > 0))
        t = np.append(step * np.arange(steps), self.duration)
        return Samples(t, self(t), self(t, 1), self(t, 2))

    def to_motors(self, actuators: Actuators | None = None) -> Trajectory:
        """Return the same motion of its k motors, motor = G theta + o [rad or m].

        `actuators` default to those of the arm. Raises InputError without motors, or if they drive other joints.
        """
        motors = require_motors(motors_of(self, actuators))
        if motors.joint_names != self.joint_names:
            raise InputError(
                f"actuators must drive the trajectory's joints, {listed(self.joint_names)}, in this order; "
                f"these drive {listed(motors.joint_names)}"
            )
        coefficients = self.coefficients @ motors.G.T
        coefficients[-1] += motors.offset
        waypoints = motors.to_motor(self.waypoints)
        return Trajectory(
            motors.names, motors.motor_units, waypoints, self.times, self.breakpoints, coefficients, labels=self.labels
        )


def _as_labels(labels: Iterable[tuple[float, str]], duration: float) -> tuple[tuple[float, str], ...]:
    try:
        pairs = [(time, text) for time, text in labels]
    except (TypeError, ValueError) as error:
        raise InputError(f"labels must be pairs such as (1.5, 'close gripper'); got {quote(labels)}") from error
    checked, earliest = [], 0.0
    for time, text in pairs:
        at = as_number(time, "the time of a label")
        if not earliest <= at <= duration:
            allowed = f"must not decrease and lie within [0, {duration:g}] s"
            raise InputError(f"the times of labels {allowed}; got {at:g} s of {quote(text)}")
        if not isinstance(text, str) or not text.strip() or not text.isprintable():
            raise InputError(f"a label must be one line of text, such as 'close gripper'; got {quote(text)}")
        checked.append((at, text))
        earliest = at
    return tuple(checked)


def _check_order(order: int) -> None:
    if not isinstance(order, int | np.integer) or not 0 <= order < len(RATE_UNITS):
        raise InputError(f"order must be 0 (position), 1, 2 or 3 (jerk); got {quote(order)}")


def motors_of(trajectory: Trajectory, actuators: Actuators | None) -> Actuators | None:
    """Return the motors to write: those given, else those of the planned arm, else None."""
    motors = trajectory.actuators
    if actuators is not None:
        motors = require(actuators, Actuators, "actuators", "as arm.actuators is")
    return motors if motors is not None and motors.names else None


def require_motors(motors: Actuators | None) -> Actuators:
    """Return the motors. Raises InputError for None."""
    if motors is None:
        raise InputError("this trajectory knows no motors: give actuators=, or plan for an arm with [actuators]")
    return motors


def require_joint_of(arm: Arm, names: list[str], file: str) -> None:
    """Raise InputError for a motion of such joints if the arm has none of them."""
    if names and not {*names} & {*arm.joint_names}:
        raise InputError(f"{file} moves another arm, with {listed(names)}; {arm.name} has {listed(arm.joint_names)}")


def motor_values(trajectory: Trajectory, motors: Actuators, t: Array) -> list[Array]:
    """Return position and velocity of the k motors at t (m,), also in counts: four arrays (m, k)."""
    moved = trajectory.to_motors(motors)
    turned = [moved(t), moved(t, 1)]
    return [*turned, *map(motors.to_counts, turned)]


class Writing(NamedTuple):
    """How a motion is written: the arguments of `save_trajectory`, and the name of the file."""

    dt: float = 0.01
    arm: Arm | None = None
    actuators: Actuators | None = None
    counts: bool = False
    name: str = "motion.h"


class Points(NamedTuple):
    """k instants t (k,) [s] of n joints (k, n) in a file. Rates and accelerations are optional.

    `place(i)` tells the place of point i in the file.
    """

    t: Array
    labels: list[tuple[float, str]]
    place: Callable[[int], str]
    theta: Array
    theta_dot: Array | None = None
    theta_ddot: Array | None = None
