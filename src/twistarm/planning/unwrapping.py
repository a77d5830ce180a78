"""Unwrapping: configurations moved by whole turns of joints, so that no joint turns farther than it must."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..ik.ranges import joint_ranges
from ..support.caller_words import argument, quantity
from ..support.checks import Array

FAR = np.pi * (1.0 + 1e-9)
"""A joint that turns farther than this [rad] could come to the same place by a shorter way."""


def unwrapped(arm: Arm, theta: Array, near: Array, where: str, asked: bool) -> tuple[Array, list[str]]:
    """theta (n,) by whole turns as near to `near` (n,) as the limits allow, if that is `asked`; and what is said of it.

    Only joints turn of which a whole turn moves nothing and whose limits leave room for one.
    """
    nearest = joint_ranges(arm).wrapped(theta, near)
    shorter = np.abs(nearest - near) < np.minimum(np.abs(theta - near), FAR)
    notes = []
    for j in np.flatnonzero(shorter & (np.abs(theta - near) > FAR)):
        name, unit = arm.joint_names[j], arm.units[j]
        given, taken = (quantity(float(value), unit) for value in (theta[j], nearest[j]))
        ways = [quantity(float(f"{abs(value - near[j]):.4g}"), unit) for value in (theta[j], nearest[j])]
        notes.append(
            f"{where}: joint {name!r} goes to {taken} in place of {given}, by whole turns"
            if asked
            else f"{where}: joint {name!r} turns by {ways[0]}; {argument('unwrap', True)} makes that {ways[1]}"
        )
    return np.where(shorter, nearest, theta) if asked else theta, notes
