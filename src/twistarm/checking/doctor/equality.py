"""Equality of descriptions: whether two move as the same robot."""

from __future__ import annotations

import numpy as np

from ...description.tree import Description, Joint

SAMPLES = 20
"""Random joint values at which every link's pose is compared."""

SAME = 1e-12
"""[m, rad], for each metre that the robot is large: the numbers are written in full."""


def difference(one: Description, other: Description) -> str:
    """The first difference in links, joints, limits, couplings or poses, in words; empty without one."""
    for what in ("links", "joints"):
        ours, theirs = getattr(one, what), getattr(other, what)
        if list(ours) != list(theirs):
            return f"its {what} are others"
    for joint in one.joints.values():
        changed = _joint_difference(joint, other.joints[joint.name])
        if changed:
            return f"joint {joint.name!r} has another {changed}"
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(-1.0, 1.0, SAMPLES) for name, joint in one.joints.items() if joint.scalar}
    ours, theirs = one.link_poses(values), other.link_poses(values)
    worst = max(float(np.abs(ours[link] - theirs[link]).max()) for link in ours)
    size = max(float(np.abs(g).max()) for g in ours.values())
    return "" if worst <= SAME * size else f"its links stand {worst:.2g} off"


def _joint_difference(one: Joint, other: Joint) -> str:
    """The field in which two joints differ; turning joints without bounds count as one type."""
    names = ("parent", "child", "lower", "upper", "velocity", "effort", "acceleration", "jerk", "mimic")
    for name in names:
        if getattr(one, name) != getattr(other, name):
            return name
    kinds = {joint.type.replace("continuous", "revolute") for joint in (one, other)}
    return "type" if len(kinds) > 1 else ""
