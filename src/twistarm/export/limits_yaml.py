"""An arm's limits as the joint_limits.yaml of MoveIt and ros2_control."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..description.bounds import NO_LIMIT
from ..support.files import WRITTEN_YAML

SUFFIXES = (".yaml", ".yml")

RATES = ("velocity", "acceleration", "jerk", "effort")


def limits_yaml(arm: Arm) -> str:
    """The file's text: the known limits of each joint, and `has_…_limits: false` for the rest.

    Positions in rad or m, the rates per s, s², s³, effort in N m or N. An open side beside a position limit is
    `NO_LIMIT`, because ROS takes both sides or none. `load_arm(…, limits=FILE)` reads it back.
    """
    import yaml  # few calls need it

    joints = {name: _joint(arm, i) for i, name in enumerate(arm.joint_names)}
    first = f"{WRITTEN_YAML}: limits in rad or m and per s, s^2, s^3\n"
    return first + yaml.safe_dump({"joint_limits": joints}, sort_keys=False, allow_unicode=True)


def _joint(arm: Arm, i: int) -> dict[str, bool | float]:
    sides = np.array([arm.limits.lower[i], arm.limits.upper[i]])
    bounded = bool(np.isfinite(sides).any())
    entries: dict[str, bool | float] = {"has_position_limits": bounded}
    if bounded:
        entries["min_position"], entries["max_position"] = np.clip(sides, -NO_LIMIT, NO_LIMIT).tolist()
    for rate in RATES:
        limit = float(getattr(arm.limits, rate)[i])
        entries[f"has_{rate}_limits"] = bool(np.isfinite(limit))
        if np.isfinite(limit):
            entries[f"max_{rate}"] = limit
    return entries
