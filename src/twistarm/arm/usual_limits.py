"""Default velocity and acceleration limits for arms that give none.

URDF has no acceleration limits, and many files write 0 or -1 for a velocity: a bare URDF is the usual start.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..limits.joint_limits import AS_GOOD_AS_UNBOUNDED, JointLimits
from ..support.messages import Quantity, Text, joined
from .arm import Arm

# Default limits per s and s². They leave time to let go of a key.
DEFAULTS = {"velocity": {"rad": 1.0, "m": 0.25}, "acceleration": {"rad": 3.0, "m": 1.0}}

POWERS = {"velocity": "s", "acceleration": "s²"}


def with_defaults(arm: Arm, limits: JointLimits | None = None) -> JointLimits:
    """`limits`, by default the arm's, with `DEFAULTS` for missing velocities and accelerations.

    A number from `AS_GOOD_AS_UNBOUNDED` on counts as missing. Some files write it for no limit.
    """
    given = arm.limits if limits is None else limits
    changes = {}
    for name, by_unit in DEFAULTS.items():
        values = getattr(given, name)
        changes[name] = np.where(values >= AS_GOOD_AS_UNBOUNDED, [by_unit[unit] for unit in arm.units], values)
    return given.with_(changes, arm.joint_names)


def usually_limited(arm: Arm) -> Arm:
    """The arm with `with_defaults` as its limits, or the same arm if it gives them all."""
    return replace(arm, limits=with_defaults(arm)) if defaults_line(arm) else arm


def defaults_line(arm: Arm, limits: JointLimits | None = None) -> str:
    """A line about the limits that are missing and their defaults, "" if there are none."""
    given = arm.limits if limits is None else limits
    parts = []
    for name, by_unit in DEFAULTS.items():
        missing = getattr(given, name) >= AS_GOOD_AS_UNBOUNDED
        for unit, value in by_unit.items():
            rows = zip(arm.joint_names, arm.units, missing, strict=True)
            joints = ", ".join(joint for joint, its_unit, is_missing in rows if is_missing and its_unit == unit)
            if joints:
                usual = Quantity(value, f"{unit}/{POWERS[name]}")
                parts.append(Text("{limit} {usual} for {joints}", limit=name, usual=usual, joints=joints))
    return Text("no limits given, used instead: {limits}", limits=joined("; ", parts)) if parts else ""
