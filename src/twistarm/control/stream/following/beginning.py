"""Checks of a motion before it is followed, and the way to its start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ....arm.arm import Arm
from ....limits.joint_limits import JointLimits
from ....planning import Trajectory, plan_joint
from ....planning.piecewise import derivative, evaluate
from ....planning.within import require_within
from ....support.checks import Array, require
from ....support.errors import InputError, closest, listed
from ....support.messages import Argument, Quantity, Text, joined

BEYOND_LIMIT = 1e-6
"""Excess over a position limit [rad, m] that is rounding of a file."""

JUMP = 1e-4
"""Jump of a velocity, as a share of its limit, that is rounding."""


def motion_of(arm: Arm, trajectory: Trajectory) -> Trajectory:
    """The trajectory with the arm's joints in order.

    Raises InputError for other joints, jumps, or an end that is not at rest. Raises LimitError if it leaves the
    position limits.
    """
    require(trajectory, Trajectory, "trajectory", "as plan_joint returns")
    motion = _ordered(arm, trajectory)
    _require_smooth(motion, arm.limits)
    wide = np.full(arm.n, np.inf)
    lower, upper = arm.limits.lower - BEYOND_LIMIT, arm.limits.upper + BEYOND_LIMIT
    positions = replace(arm.limits, lower=lower, upper=upper, velocity=wide, acceleration=wide, jerk=wide)
    require_within(motion, positions, f"plan it for {arm.name} in its present state")
    return motion


def way_there(arm: Arm, theta: Array, motion: Trajectory) -> Trajectory:
    """The straight joint move from the measured theta (n,) to the start. theta may be slightly beyond a limit."""
    lower, upper = np.minimum(arm.limits.lower, theta), np.maximum(arm.limits.upper, theta)
    start = np.clip(motion.waypoints[0], lower, upper)
    return plan_joint(arm, [theta, start], limits=replace(arm.limits, lower=lower, upper=upper))


def why_elsewhere(arm: Arm, theta: Array, start: Array, near: Array) -> str:
    """Joints farther from the start than `near` (n,), their distances and a remedy; "" for none."""
    away = np.abs(theta - start)
    if not (away > near).any():
        return ""
    far = [
        Text("{joint} {away}", joint=arm.joint_names[j], away=Quantity(float(away[j]), arm.units[j]))
        for j in np.flatnonzero(away > near)
    ]
    move = Argument("approach", True)
    return Text("{far} away; {approach} moves it there first", far=joined(", ", far), approach=move)


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
    for order, most, what in ((0, BEYOND_LIMIT, "position"), (1, JUMP * limits.velocity, "velocity")):
        values = derivative(motion.coefficients, order)
        outside = ends if order == 0 else np.zeros_like(ends)  # what holds before the start and after the end
        before = np.vstack([outside[:1], evaluate(values, durations)])
        after = np.vstack([evaluate(values, np.zeros_like(durations)), outside[1:]])
        jump = np.abs(after - before)
        if (jump > most).any():
            k, j = (int(index) for index in np.argwhere(jump > most)[0])
            unit = motion.units[j] + ("/s" if order else "")
            raise InputError(
                Text(
                    "the {what} of joint {joint!r} jumps by {jump} at t = {time:.4g} s, and no robot can: a motion has "
                    "no corners, and begins and ends at rest; plan one through these positions",
                    what=what,
                    joint=motion.joint_names[j],
                    jump=Quantity(float(jump[k, j]), unit),
                    time=motion.breakpoints[k],
                )
            )
