"""Velocity and acceleration limits for arms that give none: what a servo or a plan on the page takes instead."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .arm import Arm
from .limits import JointLimits

DEFAULTS = {"velocity": {"rad": 1.0, "m": 0.25}, "acceleration": {"rad": 3.0, "m": 1.0}}
"""Limits where an arm gives none, per s and s²: brisk for a small arm, and slow enough to let go of a key."""

POWERS = {"velocity": "s", "acceleration": "s²"}


def with_defaults(arm: Arm, limits: JointLimits | None = None) -> JointLimits:
    """`limits`, the arm's own where not given, and `DEFAULTS` where they have no velocity or acceleration."""
    given = arm.limits if limits is None else limits
    changes = {}
    for name, by_unit in DEFAULTS.items():
        values, usual = getattr(given, name), np.array([by_unit[unit] for unit in arm.units])
        changes[name] = np.where(np.isfinite(values), values, usual)
    return given.with_(changes, arm.joint_names)


def defaults_line(arm: Arm, limits: JointLimits | None = None) -> str:
    """Which of the limits were not given and what stands in for them, "" where all were."""
    parts = [
        f"{name} {DEFAULTS[name][unit]:g} {unit}/{POWERS[name]} for {', '.join(joints)}"
        for name, unit, joints in _missing(arm, arm.limits if limits is None else limits)
    ]
    return f"no limits given, used instead: {'; '.join(parts)}" if parts else ""


def _missing(arm: Arm, limits: JointLimits) -> Iterator[tuple[str, str, list[str]]]:
    """(limit, unit, the joints of that unit without it), where there are such joints."""
    for name in DEFAULTS:
        for unit in ("rad", "m"):
            rows = zip(arm.joint_names, arm.units, np.isinf(getattr(limits, name)), strict=True)
            joints = [joint for joint, its_unit, unlimited in rows if unlimited and its_unit == unit]
            if joints:
                yield name, unit, joints
