"""A motion to follow: its checks, the way to its start, and its clock, which keeps the limits."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...limits.joint_limits import JointLimits
from ...planning import Trajectory, plan_joint
from ...planning.piecewise import derivative, evaluate, shifted
from ...planning.within import GIVEN_TOL, require_positions, returning, stretch_needed
from ...support.checks import Array, require
from ...support.errors import InputError, closest, listed
from ...support.messages import Argument, Quantity, Text, joined

JUMP = 1e-4  # Jump of a velocity, as a share of its limit, that is rounding.
# Greatest change of the rate per second: from full speed to rest in at least a quarter of a second.
SLOPE = 4.0
HALVINGS = 20  # Bisections for the change of rate: precise to a millionth.


def motion_of(arm: Arm, trajectory: Trajectory) -> Trajectory:
    """The trajectory with the arm's joints in order.

    Raises InputError for other joints, jumps, or an end that is not at rest. Raises LimitError if it leaves the
    position limits.
    """
    motion = _ordered(arm, require(trajectory, Trajectory, "trajectory", "as plan_joint returns"))
    _require_smooth(motion, arm.limits)
    allowed = returning(arm.limits, motion.waypoints[0], arm.units)
    require_positions(motion, allowed, f"plan it for {arm.name} in its present state")
    return motion


def way_there(arm: Arm, theta: Array, goal: Array) -> Trajectory:
    """The straight joint move from the measured theta (n,) to goal (n,). theta may be slightly beyond a limit."""
    lower, upper = np.minimum(arm.limits.lower, theta), np.maximum(arm.limits.upper, theta)
    return plan_joint(arm, [theta, np.clip(goal, lower, upper)], limits=replace(arm.limits, lower=lower, upper=upper))


def why_elsewhere(arm: Arm, theta: Array, start: Array, near: Array) -> str:
    """Joints farther from the start than `near` (n,), their distances and a remedy; "" for none."""
    away = np.abs(theta - start)
    far = [
        Text("{joint} {away}", joint=arm.joint_names[j], away=Quantity(float(away[j]), arm.units[j]))
        for j in np.flatnonzero(away > near)
    ]
    template, move = "{far} away; {approach} moves it there first", Argument("approach", True)
    return Text(template, far=joined(", ", far), approach=move) if far else ""


def _ordered(arm: Arm, trajectory: Trajectory) -> Trajectory:
    given = trajectory.joint_names
    if sorted(given) != sorted(arm.joint_names):
        foreign = [name for name in given if name not in arm.joint_names]
        missing = [name for name in arm.joint_names if name not in given]
        what = f"{listed(foreign)} are not its own" if foreign else f"it lacks {listed(missing)}"
        hint = closest(foreign[0], missing) if foreign else ""
        raise InputError(
            f"a trajectory for {arm.name} has its joints, {listed(arm.joint_names)}; got {listed(given)}: {what}{hint}"
        )
    order = [given.index(name) for name in arm.joint_names]
    units = tuple(trajectory.units[k] for k in order)
    if units != arm.units:
        raise InputError(f"the joints of {arm.name} are in {listed(arm.units)}; those of the trajectory in {units}")
    return replace(
        trajectory, joint_names=arm.joint_names, units=units, waypoints=trajectory.waypoints[:, order],
        coefficients=trajectory.coefficients[:, :, order], actuators=None,
    )  # fmt: skip


def _require_smooth(motion: Trajectory, limits: JointLimits) -> None:
    durations, ends = np.diff(motion.breakpoints)[:, None], motion.waypoints[[0, -1]]
    for order, most, what in ((0, GIVEN_TOL, "position"), (1, JUMP * limits.velocity, "velocity")):
        values = derivative(motion.coefficients, order)
        outside = ends if order == 0 else np.zeros_like(ends)  # what holds before the start and after the end
        before = np.vstack([outside[:1], evaluate(values, durations)])
        after = np.vstack([evaluate(values, np.zeros_like(durations)), outside[1:]])
        jump = np.abs(after - before)
        if (jump > most).any():
            k, j = (int(index) for index in np.argwhere(jump > most)[0])
            unit = motion.units[j] + ("/s" if order else "")
            template = (
                "the {what} of joint {joint!r} jumps by {jump} at t = {time:.4g} s, and no robot can: a motion has "
                "no corners, and begins and ends at rest; plan one through these positions"
            )
            value, joint, time = Quantity(float(jump[k, j]), unit), motion.joint_names[j], motion.breakpoints[k]
            raise InputError(Text(template, what=what, joint=joint, jump=value, time=time))


class LimitedMotion(NamedTuple):
    """A motion and its limits: x = C theta + c of its joints and motors, in r rows.

    rows (degree + 1, s, r): the coefficients of x, laid out as the motion's. acceleration (r,): the limits. rate: the
    largest rate, at most 1, within the velocity and acceleration limits.
    """

    motion: Trajectory
    rows: Array
    acceleration: Array
    rate: float

    @classmethod
    def of(cls, arm: Arm, motion: Trajectory) -> LimitedMotion:
        """With the limits of `arm` and of its motors."""
        motors = arm.actuators
        limited = None if motors is None else motors.motion_limits(arm.limits)
        limits = arm.limits if limited is None else limited.limits
        rows = motion.coefficients if limited is None else motion.coefficients @ limited.C.T
        no_jerk = replace(limits, jerk=np.full(rows.shape[-1], np.inf))
        stretch = float(stretch_needed(rows, np.diff(motion.breakpoints), no_jerk).max())
        return cls(motion, rows, limits.acceleration, 1.0 / max(1.0, stretch))


class MotionClock(NamedTuple):
    """The motion's `time` s [s] and `rate` r = ds/dt, from 0 (at rest) to 1 (as planned).

    Joint rates are q'(s) r, and accelerations q'(s) dr/dt + q''(s) r².
    """

    time: float
    rate: float

    def after(self, dt: float, leg: LimitedMotion, target: float) -> MotionClock:
        """The clock `dt` [s] later, with a rate as near to `target` as limits allow.

        The rate changes linearly over dt. Bounds of q' and q'' over dt keep each joint and motor within its
        acceleration limit throughout. No change is always allowed: the motion keeps its limits at the leg's rate and
        below. While a joint brakes at its limit, the clock cannot slow down.
        """
        change = float(np.clip(target - self.rate, -SLOPE * dt, SLOPE * dt))
        if change:
            bounds = Enclosure.of(leg, self.time, self.time + max(self.rate, self.rate + change) * dt)
            change *= bounds.largest_share(self.rate, change, dt, leg.acceleration)
        # The target itself where it is reached: a sum would leave a rate of 1e-17, which is not at rest.
        rate = target if change == target - self.rate else self.rate + change
        return MotionClock(min(self.time + 0.5 * (self.rate + rate) * dt, leg.motion.duration), rate)


class Enclosure(NamedTuple):
    """Between what x' and x'' stay on a stretch of a leg, each (r,)."""

    lowest_velocity: Array
    highest_velocity: Array
    lowest_acceleration: Array
    highest_acceleration: Array

    @classmethod
    def of(cls, leg: LimitedMotion, begin: float, end: float) -> Enclosure:
        """From `begin` to `end` [s], by the Taylor series about the middle of each piece."""
        knots = leg.motion.breakpoints
        first = int(np.clip(np.searchsorted(knots, begin, side="right") - 1, 0, len(knots) - 2))
        last = int(np.clip(np.searchsorted(knots, end, side="left") - 1, first, len(knots) - 2))
        pieces = slice(first, last + 1)
        starts, ends = knots[pieces], knots[first + 1 : last + 2]
        low, high = np.clip(begin, starts, ends) - starts, np.clip(end, starts, ends) - starts
        moved, half = shifted(leg.rows[:, pieces], 0.5 * (low + high)), 0.5 * (high - low)
        return cls(*_enclosed(derivative(moved)[::-1], half), *_enclosed(derivative(moved, 2)[::-1], half))

    def largest_share(self, rate: float, change: float, dt: float, limit: Array) -> float:
        """The largest share 0 … 1 of a rate change over dt that keeps the accelerations below `limit`.

        They are a convex function of it, and the accelerations without a change are allowed.
        """
        allowed = np.maximum(limit, self._acceleration(rate, 0.0, dt))
        if (self._acceleration(rate, change, dt) <= allowed).all():
            return 1.0
        share, step = 0.0, 0.5
        for _ in range(HALVINGS):
            if (self._acceleration(rate, (share + step) * change, dt) <= allowed).all():
                share += step
            step *= 0.5
        return share

    def _acceleration(self, rate: float, change: float, dt: float) -> Array:
        """The largest |x' dr/dt + x'' r²| (r,) on the stretch while the rate changes evenly."""
        slope, square = change / dt, max(rate, rate + change) ** 2
        along = slope * self.lowest_velocity, slope * self.highest_velocity
        highest = np.maximum(*along) + np.maximum(self.highest_acceleration, 0.0) * square
        lowest = np.minimum(*along) + np.minimum(self.lowest_acceleration, 0.0) * square
        return np.maximum(highest, -lowest)


def _enclosed(series: Array, half: Array) -> tuple[Array, Array]:
    """Least and greatest value (r,) within `half` (s,) of the series' centres, or beyond them."""
    powers = np.arange(1.0, len(series))
    spread = (np.abs(series[1:]) * half[:, None] ** powers[:, None, None]).sum(axis=0)
    return (series[0] - spread).min(axis=0), (series[0] + spread).max(axis=0)
