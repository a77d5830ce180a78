"""An arm for the pages: joints, poses, findings, the tool's path, and checks of what to show."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...checking.doctor import examine_arm
from ...description.findings import Finding, Place, Severity
from ...description.tree import Joint
from ...limits.joint_limits import unit_of, usual_half, usual_range
from ...planning.trajectory import Trajectory
from ...support.checks import Array, as_theta, require
from ...support.errors import InputError, LimitError, one_line, without_places
from ..messages import LARGEST_VALUE, LONGEST_NAME, Message, page_words, words_of
from ..scene.arm_drawing import arm_size, screw_kinds
from ..scene.drawing import link_path, screw_path


def describe_arm(arm: Arm) -> dict[str, Any]:
    """Names, joints and poses, as the panel shows them. Infinite limits are null."""
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
        "poses": {name: theta.tolist() for name, theta in arm.configurations.items()},
        "screws": sorted(set(screw_kinds(arm))),
    }


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


LIMIT_TOL = 1e-6  # Rounding of a slider's end at a limit [rad, m], from decimal text.


def checked_theta(arm: Arm, theta: ArrayLike) -> Array:
    """`theta` as one configuration (n,) that can be drawn."""
    array = arm.theta_from(theta)
    if array.ndim != 1:
        raise InputError(f"theta must be one configuration, shape ({arm.n},); got {array.shape}")
    if np.abs(array).max(initial=0.0) > LARGEST_VALUE:
        raise InputError(f"theta must be at most {LARGEST_VALUE:g} in size; got {np.abs(array).max():g}")
    return array


def check_trajectory(arm: Arm, trajectory: Trajectory) -> None:
    """InputError where `trajectory` is not one of this arm's joints."""
    require(trajectory, Trajectory, "trajectory", "as plan_joint returns it")
    if tuple(trajectory.joint_names) != tuple(arm.joint_names):
        raise InputError(
            f"the trajectory moves {', '.join(trajectory.joint_names)}; "
            f"{arm.name} has {', '.join(arm.joint_names)}: plan it for this arm"
        )
    checked_theta(arm, trajectory(0.0))


def require_all_inside(arm: Arm, theta: Array) -> None:
    """LimitError where a joint of `theta` (n,) is outside its limits."""
    limits = arm.limits
    for joint in zip(arm.joint_names, theta, limits.lower, limits.upper, arm.units, strict=True):
        require_inside(*joint)


def require_inside(name: str, value: float, lower: float, upper: float, unit: str) -> None:
    """Raise LimitError if a joint would leave its limits, in degrees for angles."""
    if lower - LIMIT_TOL <= value <= upper + LIMIT_TOL:
        return
    if unit != "rad":
        raise LimitError(f"{name} = {value:g} is outside its limits {lower:g} … {upper:g} {unit}")
    low, angle, high = np.degrees([lower, value, upper])
    raise LimitError(f"{name} = {angle:.6g}° is outside its limits {low:.6g}° … {high:.6g}°")


MOST_POINTS = 400  # Most points: enough for any curve on a screen.
STILL = 1e-4  # Least visible step, as a share of the arm's size.
# points: the way of the tool; ideal: that of its segments; stopped: where a segment cannot be followed any farther;
# waypoints: the configurations of the poses; ids: the numbers of these poses.
NO_PATH: dict[str, Any] = {"points": [], "radius": 0.0, "ideal": [], "stopped": None, "waypoints": [], "ids": []}


def tool_path(arm: Arm, motion: Trajectory | ArrayLike) -> dict[str, Any]:
    """Points [[x, y, z], …] [m] of the tool's origin and the line's radius [m].

    A path without length has no points.

    `motion` is a trajectory of this arm or configurations (k, n) in order.
    """
    return {
        **NO_PATH,
        "points": distinct_points(arm, arm.fk(_configurations(arm, motion))[:, :3, 3]),
        "radius": 0.004 * arm_size(arm),
    }


def distinct_points(arm: Arm, points: Array) -> list[list[float]]:
    """The distinguishable points of (k, 3) [m]. None if all are in one place."""
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > STILL * arm_size(arm):
            kept.append(point)
    return np.round(kept, 6).tolist() if len(kept) > 1 else []


def _configurations(arm: Arm, motion: Trajectory | ArrayLike) -> Array:
    if isinstance(motion, Trajectory):
        check_trajectory(arm, motion)
        return motion(np.linspace(0.0, float(motion.duration), MOST_POINTS))
    theta = as_theta(motion, arm.n, "motion", names=arm.joint_names)
    if theta.ndim != 2 or len(theta) == 0:
        raise InputError(f"motion must be a Trajectory or configurations (k, {arm.n}); got shape {theta.shape}")
    for row in theta:
        checked_theta(arm, row)
    chosen: Array = theta[np.unique(np.linspace(0, len(theta) - 1, MOST_POINTS).round().astype(int))]
    return chosen


# findings ---------------------------------------------------------------------------------------------

MAX_FINDINGS = 500  # Most findings on the page. The rest is counted.

PENDING = "These findings are from loading. The doctor examines the arm once no servo drives it."


def loading_findings(arm: Arm) -> Message:
    """What the loading noted, until the doctor has looked."""
    return _findings(arm, arm.findings, PENDING if arm.description is not None else "")


def doctor_findings(arm: Arm) -> Message:
    """The doctor's findings, or those of loading without a description or if the doctor fails."""
    if arm.description is None:
        return _findings(arm, arm.findings, "")
    try:
        found = examine_arm(arm).findings
    except Exception as error:  # whatever ails the doctor, the page lives, and says so
        reason = words_of(error)
        failed = one_line(f"These findings are from loading. The doctor failed: {reason}")
        return _findings(arm, arm.findings, without_places(failed, arm.description.path))
    return _findings(arm, found, "")


def node_of(arm: Arm, place: Place) -> str | None:
    """The node of the link or joint at `place`. A joint of the chain has its screw, any other its link."""
    name = place.name
    joints, links = ({}, {}) if arm.description is None else (arm.description.joints, arm.description.links)
    if place.element == "link" and name in links:
        return link_path(name)
    if place.element != "joint":
        return None
    for i, moving in enumerate(arm.moving_names):
        if name == moving or (moving in joints and name == joints[moving].part_of):  # a planar joint is its first part
            return screw_path(i)
    return link_path(joints[name].child) if name in joints else None


def _findings(arm: Arm, findings: Iterable[Finding], note: str) -> Message:
    """{"type": "findings", "findings": [...], "counts": {severity: how many}, "note": text}, gravest first."""
    severities = get_args(Severity)
    ordered = sorted(findings, key=lambda finding: severities.index(finding.severity), reverse=True)
    more = f"{len(ordered) - MAX_FINDINGS} more: twistarm doctor lists them." if len(ordered) > MAX_FINDINGS else ""
    return {
        "type": "findings",
        "findings": [_finding(arm, finding) for finding in ordered[:MAX_FINDINGS]],
        "counts": dict(Counter(finding.severity for finding in ordered)),
        "note": " ".join(part for part in (note, more) if part),
    }


def _finding(arm: Arm, found: Finding) -> dict[str, Any]:
    """A finding as plain text. Its node is null if it concerns no single link or joint."""
    node = node_of(arm, found.place)
    path = None if arm.description is None else arm.description.path
    return {
        "severity": found.severity,
        "code": found.code,
        "place": without_places(str(found.place), path),
        "what": without_places(page_words(found.what), path),
        "remedy": without_places(page_words(found.remedy), path),
        "node": node,
        "name": one_line(found.place.name, LONGEST_NAME) if node else "",
    }
