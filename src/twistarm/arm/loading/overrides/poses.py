"""Named poses of an arm.toml and named states of an SRDF as configurations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ....description.companions.arm_file import ArmSpecification
from ....description.companions.srdf import GroupState, Semantics
from ....description.findings import Finding, Place, finding, refusal
from ....support.checks import Array
from ....support.errors import listed
from ...arm import Arm

LOCK_TOL = 1e-6
"""A pose that puts a locked joint this near [rad, m] to where it is locked means the same."""

STATE_TOL = 1e-4
"""MoveIt's assistant writes four decimals: a state at a limit may read that far [rad, m] beyond it."""


def fitted_poses(arm: Arm, specification: ArmSpecification) -> tuple[dict[str, Array], list[Finding]]:
    """The arm.toml's poses, complete and inside the limits.

    Raises DescriptionError otherwise.

    A pose that contradicts locked joints, or is incomplete for another chain, is left out.
    """
    poses: dict[str, Array] = {}
    noted: list[Finding] = []
    for name, values in specification.poses.items():
        reason = _contradiction(values, specification.locked_joints) or _of_another_chain(values, arm, specification)
        if reason:
            place = Place(specification.source, None, "pose", name)
            noted.append(finding("pose-left-out", place, f"{reason}; it is left out", "nothing, where that is meant"))
        else:
            poses[name] = _pose(arm, name, values, specification)
    return poses, noted


def _pose(arm: Arm, name: str, values: Mapping[str, float], specification: ArmSpecification) -> Array:
    place = Place(specification.source)
    skipped = set(specification.locked_joints)
    if specification.other_chain and arm.description is not None:
        skipped |= set(arm.description.joints) - set(arm.joint_names)
    try:
        theta = arm.theta_from({joint: value for joint, value in values.items() if joint not in skipped})
    except (ValueError, LookupError) as error:
        raise refusal("pose-unusable", place, f"poses.{name}: {error}") from error
    if not arm.limits.contains(theta):
        raise refusal("pose-unusable", place, f"poses.{name} lies outside the limits", "correct it or the limits")
    return theta


def _contradiction(values: Mapping[str, float], locked_joints: Mapping[str, float]) -> str:
    """Why a pose cannot be taken with these joints locked; empty if it can."""
    for joint, value in locked_joints.items():
        if abs(values.get(joint, value) - value) > LOCK_TOL:
            return f"it puts {joint} elsewhere than where it is locked"
    return ""


def _of_another_chain(values: Mapping[str, float], arm: Arm, specification: ArmSpecification) -> str:
    missing = [name for name in arm.joint_names if name not in values]
    return f"it says nothing of {listed(missing)}" if specification.other_chain and missing else ""


def fitted_states(
    arm: Arm, semantics: Semantics, group: str, locked_joints: Mapping[str, float]
) -> tuple[dict[str, Array], list[Finding]]:
    """The SRDF's states that give every coordinate; of several with one name that of `group`, else the first.

    Incomplete states and those outside the limits are left out with a finding. Values rounded beyond a limit are moved
    onto it.
    """
    states: dict[str, Array] = {}
    noted: list[Finding] = []
    for state in sorted(semantics.states, key=lambda state: state.group != group):
        given = [name for name in arm.joint_names if name in state.values]
        if not given or state.name in states:
            continue
        code, reason = _unfit(arm, state, locked_joints)
        if reason:
            place = Place(semantics.path.name, None, "group_state", state.name)
            noted.append(finding(code, place, f"{reason}; it is left out", "correct it, where the arm needs it"))
        else:
            states[state.name] = np.clip(_theta(arm, state), arm.limits.lower, arm.limits.upper)
    return states, noted


def _unfit(arm: Arm, state: GroupState, locked_joints: Mapping[str, float]) -> tuple[str, str]:
    """Code and reason why a state does not fit this arm; empty if it does."""
    missing = [name for name in arm.joint_names if name not in state.values]
    if missing:
        return "state-incomplete", f"it says nothing of {listed(missing)}"
    contradiction = _contradiction(state.values, locked_joints)
    if contradiction:
        return "pose-left-out", contradiction
    theta = _theta(arm, state)
    if not arm.limits.contains(theta, STATE_TOL):
        lower, upper = arm.limits.lower, arm.limits.upper
        i = int(np.argmax(np.maximum(lower - theta, theta - upper)))
        what = f"{arm.joint_names[i]} = {theta[i]:g} lies outside its limits [{lower[i]:g}, {upper[i]:g}]"
        return "state-outside-limits", what
    return "", ""


def _theta(arm: Arm, state: GroupState) -> Array:
    return arm.theta_from({name: state.values[name] for name in arm.joint_names})
