"""Unwrapping: configurations moved by whole turns of joints, so that joints take the shorter way."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..ik.ranges import joint_ranges
from ..support.checks import Array
from ..support.messages import Argument, Quantity, Text

HALF_TURN = np.pi * (1.0 + 1e-9)
"""A joint that turns farther than this [rad] can reach the same place by a shorter way."""

UNWRAP = Argument("unwrap", True)


def unwrapped(arm: Arm, theta: Array, near: Array, where: str, asked: bool) -> tuple[Array, list[str]]:
    """Return theta (n,) and notes. If `asked`, whole turns bring it nearest to `near` (n,) within the limits.

    It moves only joints that come back to the same place after a whole turn.
    """
    nearest = joint_ranges(arm).wrapped(theta, near)
    shorter = np.abs(nearest - near) < np.minimum(np.abs(theta - near), HALF_TURN)
    notes: list[str] = []
    for j in np.flatnonzero(shorter & (np.abs(theta - near) > HALF_TURN)):
        unit = arm.units[j]
        given, taken = Quantity(float(theta[j]), unit), Quantity(float(nearest[j]), unit)
        long, short = (Quantity(abs(float(value - near[j])), unit, 4) for value in (theta[j], nearest[j]))
        offered = Text("turns by {long}; {unwrap} makes that {short}", long=long, short=short, unwrap=UNWRAP)
        done = Text("goes to {taken} in place of {given}, by whole turns", taken=taken, given=given)
        does = done if asked else offered
        notes.append(Text("{where}: joint {joint!r} {does}", where=where, joint=arm.joint_names[j], does=does))
    return np.where(shorter, nearest, theta) if asked else theta, notes
