"""Every arm against Pinocchio loaded by its own means: the raw URDF, its own q for continuous joints."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import twistarm
from twistarm import poe, screws

POSE_TOL = 1e-12  # Double precision over some ten joints.

SAMPLES = 50


def raw_q(model: pin.Model, values: dict[str, float]) -> np.ndarray:
    """Pinocchio's own configuration: continuous joints as (cos, sin)."""
    q = pin.neutral(model)
    for name, value in values.items():
        j = model.getJointId(name)
        i = model.idx_qs[j]
        if model.nqs[j] == 2:
            q[i : i + 2] = np.cos(value), np.sin(value)
        else:
            q[i] = value
    return q


def joint_values(arm: twistarm.Arm, theta: np.ndarray) -> dict[str, float]:
    """Every moving joint's value from theta, masters outside the chain at 0, by the mimic elements themselves."""
    assert arm.description is not None
    known = dict(zip(arm.joint_names, theta, strict=True))

    def value(name: str) -> float:
        mimic = arm.description.joints[name].mimic
        return known.get(name, 0.0) if mimic is None else mimic.multiplier * value(mimic.joint) + mimic.offset

    return {name: value(name) for name, joint in arm.description.joints.items() if joint.moving}


def compare(arm: twistarm.Arm, text: str) -> None:
    """Product of exponentials, and what `arm` answers, against a model made from `text` alone."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    base, tip = (model.getFrameId(link, pin.FrameType.BODY) for link in (arm.base, arm.tip_link))
    A = arm.coupling.A
    for theta in arm.random_theta(np.random.default_rng(11), SAMPLES):
        q = raw_q(model, joint_values(arm, theta))
        pin.computeJointJacobians(model, data, q)
        pin.framesForwardKinematics(model, data, q)
        expected = (data.oMf[base].inverse() * data.oMf[tip]).homogeneous
        assert np.abs(poe.fk(arm.screws, arm.home, A @ theta) - expected).max() <= POSE_TOL
        assert np.abs(arm.fk(theta) - expected).max() <= POSE_TOL
        columns = [model.idx_vs[model.getJointId(joint.name)] for joint in chain(arm)]
        local = pin.getFrameJacobian(model, data, tip, pin.ReferenceFrame.LOCAL)[:, columns] @ A
        world = pin.getFrameJacobian(model, data, tip, pin.ReferenceFrame.WORLD)[:, columns] @ A
        spatial = data.oMf[base].toActionMatrixInverse() @ world
        assert np.abs(poe.body_jacobian(arm.screws, arm.home, A @ theta) @ A - local).max() <= POSE_TOL
        assert np.abs(poe.spatial_jacobian(arm.screws, A @ theta) @ A - spatial).max() <= POSE_TOL
        assert np.abs(arm.body_jacobian(theta) - local).max() <= POSE_TOL
        assert np.abs(arm.spatial_jacobian(theta) - spatial).max() <= POSE_TOL
        assert np.abs(screws.adjoint(arm.fk(theta)) @ local - spatial).max() <= POSE_TOL


def chain(arm: twistarm.Arm) -> list[twistarm.description.tree.Joint]:
    assert arm.description is not None
    return [joint for joint in arm.description.chain(arm.base, arm.tip_link) if joint.moving]


def test_catalogue_arms_equal_pinocchio_on_the_raw_urdf(catalogue_arm: twistarm.Arm) -> None:
    assert catalogue_arm.description is not None
    compare(catalogue_arm, catalogue_arm.description.text)
