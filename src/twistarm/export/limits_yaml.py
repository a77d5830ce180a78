"""An arm's limits as the joint_limits.yaml of MoveIt and ros2_control."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..support.files import WRITTEN_YAML

SUFFIXES = (".yaml", ".yml")

RATES = ("velocity", "acceleration", "jerk", "effort")


def limits_yaml(arm: Arm) -> str:
    """The file's text: the known limits of each joint, and `has_…_limits: false` for the rest.

    Positions in rad or m, the rates per s, s², s³, effort in N m or N. `load_arm(…, limits=FILE)` reads it back.
    """
    import yaml  # few calls need it

    joints = {name: _joint(arm, i) for i, name in enumerate(arm.joint_names)}
    first = f"{WRITTEN_YAML}: limits in rad or m and per s, s^2, s^3\n"
    return first + yaml.safe_dump({"joint_limits": joints}, sort_keys=False, allow_unicode=True)


def _joint(arm: Arm, i: int) -> dict[str, bool | float]:
    lower, upper = float(arm.limits.lower[i]), float(arm.limits.upper[i])
    bounded = bool(np.isfinite([lower, upper]).any())
    entries: dict[str, bool | float] = {"has_position_limits": bounded}
    if bounded:
        entries |= {"min_position": lower, "max_position": upper}
    for rate in RATES:
        limit = float(getattr(arm.limits, rate)[i])
        entries[f"has_{rate}_limits"] = bool(np.isfinite(limit))
        if np.isfinite(limit):
            entries[f"max_{rate}"] = limit
    return entries
