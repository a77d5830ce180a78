"""Default velocity and acceleration limits for arms that give none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ..limits.joint_limits import AS_GOOD_AS_UNBOUNDED, JointLimits
from ..support.checks import Array
from ..support.messages import Quantity, Text, joined
from .arm import Arm

DEFAULTS = {"velocity": {"rad": 1.0, "m": 0.25}, "acceleration": {"rad": 3.0, "m": 1.0}}
"""Default limits per s and s². They leave time to let go of a key."""

POWERS = {"velocity": "s", "acceleration": "s²"}


def with_defaults(arm: Arm, limits: JointLimits | None = None) -> JointLimits:
    """`limits`, by default the arm's, with `DEFAULTS` for missing velocities and accelerations.

    A number from `AS_GOOD_AS_UNBOUNDED` on counts as missing. Some files write it for no limit.
    """
    given = arm.limits if limits is None else limits
    changes = {}
    for name, by_unit in DEFAULTS.items():
        values, usual = getattr(given, name), np.array([by_unit[unit] for unit in arm.units])
        changes[name] = np.where(_lacking(values), usual, values)
    return given.with_(changes, arm.joint_names)


def usually_limited(arm: Arm) -> Arm:
    """The arm with `with_defaults` as its limits, or the same arm if it gives them all."""
    lacks = any(_lacking(getattr(arm.limits, name)).any() for name in DEFAULTS)
    return replace(arm, limits=with_defaults(arm)) if lacks else arm


def defaults_line(arm: Arm, limits: JointLimits | None = None) -> str:
    """A line about the limits that are missing and their defaults, "" if there are none."""
    parts = [
        Text("{limit} {usual} for {joints}", limit=name, usual=usual, joints=", ".join(joints))
        for name, unit, joints in _missing(arm, arm.limits if limits is None else limits)
        for usual in [Quantity(DEFAULTS[name][unit], f"{unit}/{POWERS[name]}")]
    ]
    return Text("no limits given, used instead: {limits}", limits=joined("; ", parts)) if parts else ""


def _missing(arm: Arm, limits: JointLimits) -> Iterator[tuple[str, str, list[str]]]:
    """(limit, unit, joints of that unit without the limit) for each limit that is missing."""
    for name in DEFAULTS:
        for unit in ("rad", "m"):
            rows = zip(arm.joint_names, arm.units, _lacking(getattr(limits, name)), strict=True)
            joints = [joint for joint, its_unit, unlimited in rows if unlimited and its_unit == unit]
            if joints:
                yield name, unit, joints


def _lacking(values: Array) -> Any:
    return values >= AS_GOOD_AS_UNBOUNDED
