"""Limits, named configurations and actuators that are given beside a description, fitted to the chain."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ...description.chain import Affine
from ...description.companions.arm_file import ArmSpecification, Motor
from ...description.companions.joint_limits import read_joint_limits
from ...description.findings import Finding, Place, finding, refusal
from ...description.tree import Semantics
from ...limits.actuators import Actuators
from ...limits.joint_limits import JointLimits, by_field
from ...support.checks import Array
from ...support.errors import InputError, closest, listed
from ..arm import Arm

# What a caller may give as limits=: all of them, some of them, or a joint_limits.yaml.
Changes = JointLimits | Mapping[str, Any] | str | os.PathLike[str]
LOCK_TOL = 1e-6  # A pose that puts a locked joint this near [rad, m] to where it is locked means the same.
# MoveIt's assistant writes four decimals: a state at a limit may read that far [rad, m] beyond it.
STATE_TOL = 1e-4


def fitted_limits(
    limits: JointLimits,
    names: tuple[str, ...],
    specification: ArmSpecification,
    changes: Changes,
    joints: Iterable[str],
) -> tuple[JointLimits, tuple[Finding, ...]]:
    """The description's limits, then the arm.toml's file and entries by joint, then the caller's.

    `names` are the chain's coordinates, `joints` all joints of the description. The arm.toml's limits of locked joints
    and of those off a requested chain are left out.
    """
    noted: tuple[Finding, ...] = ()
    joints = tuple(joints)
    left_out = {*specification.locked_joints, *(set(joints).difference(names) if specification.other_chain else ())}
    own = {joint: its for joint, its in specification.limits.items() if joint not in left_out}
    if specification.joint_limits is not None:
        limits, noted = read_joint_limits(specification.joint_limits).onto(limits, names, joints)
    with _in_the_arm_file(specification):
        limits = limits.with_(by_field(own), names)
    if isinstance(changes, (str, os.PathLike)):
        limits, more = read_joint_limits(changes).onto(limits, names, joints)
        return limits, (*noted, *more)
    if not isinstance(changes, JointLimits):
        return limits.with_(changes, names), noted
    if changes.lower.size != len(names):
        raise InputError(f"limits must be those of {len(names)} joints ({', '.join(names)}); got {changes.lower.size}")
    return changes, noted


@contextmanager
def _in_the_arm_file(specification: ArmSpecification, entry: str = "") -> Iterator[None]:
    """Errors about names and values as those of the arm.toml, and of its `entry`."""
    try:
        yield
    except (ValueError, LookupError) as error:
        what = f"{entry}: {error}" if entry else str(error)
        raise refusal("companion-unusable", Place(specification.source), what) from error


def fitted_poses(arm: Arm, specification: ArmSpecification) -> tuple[dict[str, Array], list[Finding]]:
    """The arm.toml's poses, complete and inside the limits; DescriptionError otherwise.

    A pose that contradicts locked joints, or is incomplete for another chain, is left out.
    """
    poses: dict[str, Array] = {}
    noted: list[Finding] = []
    skipped = set(specification.locked_joints)
    if specification.other_chain and arm.description is not None:
        skipped |= set(arm.description.joints) - set(arm.joint_names)
    for name, values in specification.poses.items():
        code, reason = _unfit(arm, values, specification.locked_joints, 0.0)
        if code == "companion-doubtful" or (code == "companion-not-used" and specification.other_chain):
            place = Place(specification.source, None, "pose", name)
            noted.append(finding("companion-doubtful", place, f"{reason}; it is left out", "nothing, if that is meant"))
            continue
        with _in_the_arm_file(specification, f"poses.{name}"):
            poses[name] = arm.theta_from({joint: value for joint, value in values.items() if joint not in skipped})
        if reason:
            what, remedy = f"poses.{name}: {reason}", "correct it or the limits"
            raise refusal("companion-unusable", Place(specification.source), what, remedy)
    return poses, noted


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
        if state.name in states or not any(name in state.values for name in arm.joint_names):
            continue
        code, reason = _unfit(arm, state.values, locked_joints, STATE_TOL)
        if reason:
            place = Place(semantics.path.name, None, "group_state", state.name)
            noted.append(finding(code, place, f"{reason}; it is left out", "correct it, where the arm needs it"))
        else:
            theta = np.array([state.values[name] for name in arm.joint_names])
            states[state.name] = np.clip(theta, arm.limits.lower, arm.limits.upper)
    return states, noted


def _unfit(arm: Arm, values: Mapping[str, float], locked_joints: Mapping[str, float], tol: float) -> tuple[str, str]:
    """Code and reason why a pose or state does not fit this arm; empty if it does."""
    for joint, value in locked_joints.items():
        if abs(values.get(joint, value) - value) > LOCK_TOL:
            return "companion-doubtful", f"it moves the locked joint {joint}"
    if missing := [name for name in arm.joint_names if name not in values]:
        return "companion-not-used", f"it gives no value for {listed(missing)}"
    theta, lower, upper = np.array([values[name] for name in arm.joint_names]), arm.limits.lower, arm.limits.upper
    beyond = np.maximum(lower - theta, theta - upper)
    worst = int(beyond.argmax())
    if beyond[worst] > tol:
        what = f"{arm.joint_names[worst]} = {theta[worst]:g} lies outside its limits"
        return "outside-limits", f"{what} [{lower[worst]:g}, {upper[worst]:g}]"
    return "", ""


def fitted_actuators(arm: Arm, specification: ArmSpecification) -> tuple[Actuators | None, list[Finding]]:
    """The motors of an arm.toml on theta. G and o include locked joints and mimic followers.

    Raises DescriptionError for a joint outside the chain. If the caller asks for another chain, motors beyond it are
    left out.
    """
    noted: list[Finding] = []
    motors: list[Motor] = []
    for motor in specification.motors:
        beyond = [joint for joint in motor.ratio if _affine(joint, arm) is None]
        if not beyond:
            motors.append(motor)
        elif specification.other_chain and set(beyond) <= set(arm.couplings):
            place = Place(specification.source, None, "actuator", motor.name)
            what = f"it drives {listed(beyond)}, outside this chain; it is left out"
            noted.append(finding("off-the-chain", place, what, "nothing, where that is meant"))
        else:
            joint, names = beyond[0], arm.joint_names
            what = f"actuators.{motor.name}.ratio: no joint {joint!r} in {arm.name}{closest(joint, names)}"
            remedy = f"its joints, base to tip: {listed(names)}"
            raise refusal("companion-unusable", Place(specification.source), what, remedy)
    if not motors:
        return None, noted
    rows, names = [_row(motor, arm) for motor in motors], tuple(motor.name for motor in motors)
    with _in_the_arm_file(specification):
        actuators = Actuators(
            names=names,
            joint_names=arm.joint_names,
            G=np.array([row for row, _ in rows]),
            offset=np.array([offset for _, offset in rows]),
            units=tuple(motor.unit for motor in motors),
            ticks_per_turn=np.array([np.nan if m.ticks_per_turn is None else m.ticks_per_turn for m in motors]),
            limits=JointLimits.unbounded(len(motors)).with_(by_field({m.name: m.limits for m in motors}), names),
        )
    return actuators, noted


def _affine(joint: str, arm: Arm) -> Affine | None:
    """The joint's value as a function of one coordinate, or fixed; None for a joint off the chain."""
    if joint in arm.joint_names:
        return Affine(joint, 1.0, 0.0)
    affine = arm.couplings.get(joint)
    return affine if affine and (affine.master is None or affine.master in arm.joint_names) else None


def _row(motor: Motor, arm: Arm) -> tuple[Array, float]:
    """G's row and the motor's offset: the sum of ratio · (multiplier · theta_master + offset) over its joints."""
    row, offset = np.zeros(arm.n), motor.offset
    for joint, ratio in motor.ratio.items():
        affine = _affine(joint, arm)
        assert affine is not None, "fitted_actuators has seen it"
        offset += ratio * affine.offset
        if affine.master is not None:
            row[arm.joint_names.index(affine.master)] += ratio * affine.multiplier
    return row, offset
