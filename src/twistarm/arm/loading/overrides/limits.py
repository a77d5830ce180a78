"""Limits from the description, a joint_limits.yaml, the arm.toml and the caller."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

from ....description.companions.arm_file import ArmSpecification
from ....description.companions.joint_limits import LimitsFile, read_joint_limits
from ....description.findings import Finding, Place, refusal
from ....limits.joint_limits import JointLimits
from ....support.errors import InputError

Changes = JointLimits | Mapping[str, Any] | str | os.PathLike[str]
"""What a caller may give as limits=: all of them, some of them, or a joint_limits.yaml."""


def fitted_limits(
    limits: JointLimits,
    names: tuple[str, ...],
    specification: ArmSpecification,
    changes: Changes,
    joints: Iterable[str],
) -> tuple[JointLimits, list[Finding]]:
    """The description's limits, then the arm.toml's file and entries by joint, then the caller's.

    `names` are the chain's coordinates, `joints` all joints of the description.
    """
    noted: list[Finding] = []
    joints = tuple(joints)
    if specification.joint_limits is not None:
        limits = _with_file(limits, read_joint_limits(specification.joint_limits), names, joints, noted)
    try:
        limits = limits.with_(_by_field(specification, names, set(joints)), names)
    except (ValueError, LookupError) as error:
        raise refusal("limits-unusable", Place(specification.source), str(error)) from error
    if isinstance(changes, (str, os.PathLike)):
        return _with_file(limits, read_joint_limits(changes), names, joints, noted), noted
    if not isinstance(changes, JointLimits):
        return limits.with_(changes, names), noted
    if changes.lower.size != len(names):
        raise InputError(f"limits must be those of {len(names)} joints ({', '.join(names)}); got {changes.lower.size}")
    return changes, noted


def _by_field(specification: ArmSpecification, names: tuple[str, ...], joints: set[str]) -> dict[str, dict[str, float]]:
    """The arm.toml's limits by field and joint, without locked joints and those off the requested chain."""
    by_field: dict[str, dict[str, float]] = {}
    for joint, values in specification.limits.items():
        beyond = specification.other_chain and joint in joints and joint not in names
        if joint in specification.locked_joints or beyond:
            continue
        for field, value in values.items():
            by_field.setdefault(field, {})[joint] = value
    return by_field


def _with_file(
    limits: JointLimits, file: LimitsFile, names: tuple[str, ...], joints: tuple[str, ...], noted: list[Finding]
) -> JointLimits:
    changes, findings = file.of(names, joints)
    noted += findings
    try:
        return limits.with_(changes, names)
    except InputError as error:
        raise refusal("limits-unusable", Place(str(file.path)), str(error)) from error
