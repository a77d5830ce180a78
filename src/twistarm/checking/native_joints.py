"""A chain of Pinocchio's joint models, one per lower pair, also for joints that URDF lacks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arm.pinocchio_model import MAX_MOVING_JOINTS, import_pinocchio
from ..support.checks import Array
from ..support.errors import InputError
from ..theory.lower_pairs import LowerPair


def native_kinematics(pairs: Sequence[LowerPair], home: Array, x: Array) -> tuple[Array, Array, Array]:
    """g_st (N, 4, 4), J^s and J^b (N, 6, m) at joint values x (N, m), of a tool at `home` (4, 4) at rest.

    Pinocchio's coordinates of a ball are Euler angles, ZYX. Those of a planar joint are (x, y, cos, sin), and its
    velocities are in the moved frame. N(x) maps ẋ to those velocities. Then g_st = g(q(x)) and J = J_native N(x).

    Raises InputError for more moving joints than Pinocchio's data holds.
    """
    if x.shape[1] > MAX_MOVING_JOINTS:
        raise InputError(f"{x.shape[1]} moving joints; Pinocchio's data has room for {MAX_MOVING_JOINTS}")
    pin = import_pinocchio()
    model, tool = _model(pin, pairs, home)
    data = pin.Data(model)
    parts: list[tuple[Array, Array, Array]] = []
    for row in x:
        q, N = _configuration(pairs, row)
        pin.computeJointJacobians(model, data, q)
        g = pin.updateFramePlacement(model, data, tool).homogeneous
        # A model of one degree of freedom returns (6,).
        spatial, body = (
            pin.getFrameJacobian(model, data, tool, frame).reshape(6, -1) @ N
            for frame in (pin.ReferenceFrame.WORLD, pin.ReferenceFrame.LOCAL)
        )
        parts.append((g, spatial, body))
    g, spatial, body = map(np.array, zip(*parts, strict=True))
    return g, spatial, body


def _model(pin: Any, pairs: Sequence[LowerPair], home: Array) -> tuple[Any, int]:
    """Pinocchio's model, and the number of the tool's frame."""
    model = pin.Model()
    joint, last = 0, pin.SE3.Identity()
    for i, pair in enumerate(pairs):
        here = pin.SE3(pair.frame)
        joint = model.addJoint(joint, _joint_model(pin, pair), last.actInv(here), f"{pair.kind}{i}")
        last = here
    frame = pin.Frame("tool", joint, 0, last.actInv(pin.SE3(home)), pin.FrameType.OP_FRAME)
    return model, model.addFrame(frame)


def _joint_model(pin: Any, pair: LowerPair) -> Any:
    if pair.kind == "cylindrical":
        model = pin.JointModelComposite(2)
        model.addJoint(pin.JointModelRZ())
        model.addJoint(pin.JointModelPZ())
        return model
    if pair.kind == "helical":
        return pin.JointModelHZ(pair.pitch)
    made = {"revolute": pin.JointModelRZ, "prismatic": pin.JointModelPZ, "planar": pin.JointModelPlanar}
    return made.get(pair.kind, pin.JointModelSphericalZYX)()


def _configuration(pairs: Sequence[LowerPair], x: Array) -> tuple[Array, Array]:
    """Pinocchio's q (nq,) and the map N (nv, m) from ẋ to its velocities, at the joint values x (m,)."""
    coordinates, maps = [], []
    for pair in pairs:
        rows = list(pair.rows)
        value = pair.rates * x[rows]
        q, rates = _planar(value) if pair.kind == "planar" else (value, np.eye(len(value)))
        coordinates.append(q)
        maps.append((rates * pair.rates) @ np.eye(len(x))[rows])
    return np.concatenate(coordinates), np.concatenate(maps)


def _planar(x: Array) -> tuple[Array, Array]:
    """(x, y, cos θ, sin θ); its velocity is the body's: R(θ)ᵀ (ẋ, ẏ), θ̇."""
    c, s = np.cos(x[2]), np.sin(x[2])
    return np.array([x[0], x[1], c, s]), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
