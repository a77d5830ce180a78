"""An arm as a page receives it once: its joints and poses."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...description.tree import Joint
from ...limits.joint_limits import unit_of, usual_half, usual_range
from ...support.checks import Array
from ..scene.axes import screw_kinds


def describe_arm(arm: Arm) -> dict[str, Any]:
    """Names, joints and poses, as the panel shows them; infinite limits are null."""
    lower, upper = arm.limits.lower, arm.limits.upper
    joints = zip(arm.joint_names, arm.joint_types, lower, upper, arm.usual_half, strict=True)
    others = [(name, j.type, j.lower, j.upper, usual_half(j.type)) for name, j in extra_joints(arm).items()]
    return {
        "name": arm.name,
        "base": arm.base,
        "tip": arm.tip,
        "tool_axis": arm.tool_axis.tolist(),
        "joints": [_describe(*joint) for joint in joints],
        "others": [_describe(*joint) for joint in others],
        "poses": list(named_poses(arm)),
        "screws": sorted(set(screw_kinds(arm))),
    }


def named_poses(arm: Arm) -> dict[str, Array]:
    """The poses one can go to by name: zero, ready, and the arm's own."""
    named = {name: np.asarray(theta, dtype=np.float64) for name, theta in arm.named_states.items()}
    return {"zero": np.zeros(arm.n), "ready": arm.ready, **named}


def extra_joints(arm: Arm) -> dict[str, Joint]:
    """The independent one-degree joints outside the chain, a gripper's say, by name."""
    if arm.description is None:
        return {}
    return {
        name: joint
        for name, joint in arm.description.joints.items()
        if joint.type in ("revolute", "continuous", "prismatic")
        and arm.couplings[name].master == name
        and name not in arm.joint_names
    }


def rest(joint: Joint) -> float:
    """The default of a joint outside the chain: 0, or the limit nearest to it."""
    return float(np.clip(0.0, joint.lower, joint.upper))


def _describe(name: str, kind: str, lower: float, upper: float, half: float) -> dict[str, Any]:
    return {
        "name": name,
        "type": kind,
        "unit": unit_of(kind),
        "limits": [float(bound) if np.isfinite(bound) else None for bound in (lower, upper)],
        "range": [float(end) for end in usual_range(lower, upper, half)],
    }
