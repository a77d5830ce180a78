"""Unwrapping: configurations moved by whole turns of joints, so that joints take the shorter way."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..ik.ranges import joint_ranges
from ..support.caller_words import argument, quantity
from ..support.checks import Array

HALF_TURN = np.pi * (1.0 + 1e-9)
"""A joint that turns farther than this [rad] can reach the same place by a shorter way."""


def unwrapped(arm: Arm, theta: Array, near: Array, where: str, asked: bool) -> tuple[Array, list[str]]:
    """Return theta (n,) and notes. If `asked`, whole turns bring it nearest to `near` (n,) within the limits.

    It moves only joints that come back to the same place after a whole turn.
    """
    nearest = joint_ranges(arm).wrapped(theta, near)
    shorter = np.abs(nearest - near) < np.minimum(np.abs(theta - near), HALF_TURN)
    notes = []
    for j in np.flatnonzero(shorter & (np.abs(theta - near) > HALF_TURN)):
        name, unit = arm.joint_names[j], arm.units[j]
        given, taken = (quantity(float(value), unit) for value in (theta[j], nearest[j]))
        ways = [quantity(float(f"{abs(value - near[j]):.4g}"), unit) for value in (theta[j], nearest[j])]
        offered = f"turns by {ways[0]}; {argument('unwrap', True)} makes that {ways[1]}"
        done = f"goes to {taken} in place of {given}, by whole turns"
        notes.append(f"{where}: joint {name!r} {done if asked else offered}")
    return np.where(shorter, nearest, theta) if asked else theta, notes
