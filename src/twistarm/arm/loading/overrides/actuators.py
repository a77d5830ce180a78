"""An arm.toml's motors on the coordinates of the chain."""

from __future__ import annotations

import numpy as np

from ....description.companions.arm_file import ArmSpecification
from ....description.companions.motors import Motor
from ....description.coupling import Affine
from ....description.findings import Finding, Place, finding, refusal
from ....limits.actuators import Actuators
from ....limits.joint_limits import JointLimits
from ....support.checks import Array
from ....support.errors import DescriptionError, InputError, closest, listed
from ...arm import Arm


def fitted_actuators(arm: Arm, specification: ArmSpecification) -> tuple[Actuators | None, list[Finding]]:
    """The motors on theta.

    G and o include locked joints and mimic followers.

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
            what = f"it drives {listed(beyond)} outside the chain asked for; it is left out"
            noted.append(finding("actuator-left-out", place, what, "nothing, where that is meant"))
        else:
            raise _undrivable(motor, beyond[0], arm, specification)
    return _actuators(motors, arm, specification) if motors else None, noted


def _actuators(motors: list[Motor], arm: Arm, specification: ArmSpecification) -> Actuators:
    rows = [_row(motor, arm) for motor in motors]
    try:
        return Actuators(
            names=tuple(motor.name for motor in motors),
            joint_names=arm.joint_names,
            G=np.array([row for row, _ in rows]),
            offset=np.array([offset for _, offset in rows]),
            units=tuple(motor.unit for motor in motors),
            ticks_per_turn=np.array([np.nan if m.ticks_per_turn is None else m.ticks_per_turn for m in motors]),
            limits=_limits(motors),
        )
    except InputError as error:
        raise refusal("arm-file-unusable", Place(specification.source), str(error)) from error


def _limits(motors: list[Motor]) -> JointLimits:
    fields = {name for motor in motors for name in motor.limits}
    given = {name: {motor.name: motor.limits[name] for motor in motors if name in motor.limits} for name in fields}
    return JointLimits.unbounded(len(motors)).with_(given, tuple(motor.name for motor in motors))


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


def _undrivable(motor: Motor, joint: str, arm: Arm, specification: ArmSpecification) -> DescriptionError:
    what = f"actuators.{motor.name}.ratio: no joint {joint!r} in {arm.name}{closest(joint, arm.joint_names)}"
    remedy = f"its joints, base to tip: {listed(arm.joint_names)}"
    return refusal("arm-file-unusable", Place(specification.source), what, remedy)
