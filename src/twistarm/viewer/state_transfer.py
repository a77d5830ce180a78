"""State transfer between arms by joint names."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..limits.joint_limits import JointLimits
from ..planning.trajectory import Trajectory
from ..planning.within import require_within
from ..support.checks import Array
from ..support.errors import LimitError, listed
from ..sweeps.voxel_map import digest_of
from .parts.arm_data import LIMIT_TOL, extra_joints, tool_path
from .parts.pose_list import LeftOut, collecting_refusals
from .stage import Stage


def carry(old: Stage, new: Stage) -> list[str]:
    """Give `new` the state of `old`.

    Returns the changes and omissions in words.

    Common joints keep their values, or their limits. New joints take the ready pose. Layers and obstacles stay. Poses,
    the motion and a map stay if they fit the arm; omitted poses return with an arm that allows them.
    """
    new.visible, new.needed, new.tolerances = old.visible, old.needed, old.tolerances
    new.controls.take_over(old.controls)
    new.drawings = old.drawings
    new.collisions.follow(old.collisions)
    if digest_of(new.arm) == digest_of(old.arm):
        new.reach.drawn = old.reach.drawn
    return [*_configuration(old, new), *_poses(old, new), *_motion(old, new)]


def _configuration(old: Stage, new: Stage) -> Iterator[str]:
    values = dict(zip(old.arm.joint_names, old.theta.tolist(), strict=True)) | dict(old.others)
    names, limits = new.arm.joint_names, new.arm.limits
    stood: Array = np.array([values.get(name, start) for name, start in zip(names, new.theta, strict=True)])
    new.theta = np.clip(stood, limits.lower, limits.upper)
    rest = {name: values.get(name, start) for name, start in new.others.items()}
    new.others = {
        name: float(np.clip(rest[name], joint.lower, joint.upper)) for name, joint in extra_joints(new.arm).items()
    }
    moved = [name for name, a, b in zip(names, stood, new.theta, strict=True) if abs(a - b) > LIMIT_TOL]
    moved += [name for name, value in rest.items() if abs(value - new.others[name]) > LIMIT_TOL]
    if moved:
        yield f"moved to the nearer limit: {listed(moved, 6)}"


def _poses(old: Stage, new: Stage) -> Iterator[str]:
    joints = old.arm.joint_names
    here = [(joints, pose.entry()) for pose in old.poses.poses]
    left: list[LeftOut] = []
    reasons: list[str] = []
    for moved, pose in [*here, *old.left]:
        before = len(reasons)
        with collecting_refusals(reasons):
            reasons += new.poses.take(moved, [pose])
        if len(reasons) > before:
            left.append((moved, pose))
    new.left = tuple(left)
    if left:
        which = f"{len(left)} poses are left out until they fit, the first" if len(left) > 1 else "a pose is left out"
        yield f"{which}: {reasons[0]}"


def _motion(old: Stage, new: Stage) -> Iterator[str]:
    playback = old.playback
    if playback is None:
        return
    if not _fits(playback.trajectory, old, new):
        yield "the motion does not fit the arm any more and is gone"
        return
    new.playback = playback
    new.program.follow(old.program)
    if old.path["points"]:
        new.draw_path(tool_path(new.arm, playback.trajectory))


def _fits(motion: Trajectory, old: Stage, new: Stage) -> bool:
    """Whether it fits the new arm's joints and limits. Limits that it broke before do not count."""
    if tuple(motion.joint_names) != tuple(new.arm.joint_names):
        return False
    return _within(motion, new.arm.limits) or not _within(motion, old.arm.limits)


def _within(motion: Trajectory, limits: JointLimits) -> bool:
    try:
        require_within(motion, limits)
    except LimitError:
        return False
    return True
