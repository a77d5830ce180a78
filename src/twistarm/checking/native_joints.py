"""A chain of Pinocchio's joint models, one per lower pair, also for joints that URDF lacks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..arm.pinocchio_model import MAX_MOVING_JOINTS, import_pinocchio
from ..support.checks import Array
from ..support.errors import InputError
from ..theory.lower_pairs import LowerPair


class NativeChain:
    """A serial chain of Pinocchio's joint models from the base to the tool at `home` (4, 4), at rest.

    Pinocchio's coordinates of a ball are Euler angles, ZYX. Those of a planar joint are (x, y, cos, sin), and its
    velocities are in the moved frame. N(x) maps ẋ to those velocities. Then g_st = g(q(x)) and J = J_native N(x).

    Raises InputError for more moving joints than Pinocchio's data holds.
    """

    def __init__(self, pairs: Sequence[LowerPair], home: Array) -> None:
        count = sum(pair.span for pair in pairs)
        if count > MAX_MOVING_JOINTS:
            raise InputError(f"{count} moving joints; Pinocchio's data has room for {MAX_MOVING_JOINTS}")
        self._pin = import_pinocchio()
        self._pairs, self._count = tuple(pairs), count
        self.model = self._pin.Model()
        joint, last = 0, self._pin.SE3.Identity()
        for i, pair in enumerate(pairs):
            here = self._pin.SE3(pair.frame)
            joint = self.model.addJoint(joint, self._joint_model(pair), last.actInv(here), f"{pair.kind}{i}")
            last = here
        tool = last.actInv(self._pin.SE3(home))
        frame = self._pin.Frame("tool", joint, 0, tool, self._pin.FrameType.OP_FRAME)
        self._tool = self.model.addFrame(frame)
        self._data = self._pin.Data(self.model)

    def kinematics(self, x: Array) -> tuple[Array, Array, Array]:
        """g_st (..., 4, 4), J^s and J^b (..., 6, m) at the joint values x (..., m)."""
        rows = [self._at(row) for row in x.reshape(-1, self._count)]
        g, spatial, body = (np.array(parts) for parts in zip(*rows, strict=True))
        batch = x.shape[:-1]
        return g.reshape(*batch, 4, 4), spatial.reshape(*batch, 6, -1), body.reshape(*batch, 6, -1)

    def configuration(self, x: Array) -> tuple[Array, Array]:
        """Pinocchio's q (nq,) and the map N (nv, m) from ẋ to its velocities, at the joint values x (m,)."""
        parts, N = [], np.zeros((self.model.nv, self._count))
        row = 0
        for pair in self._pairs:
            rows = list(pair.rows)
            value = pair.rates * x[rows]
            q, rates = _planar(value) if pair.kind == "planar" else (value, np.eye(len(value)))
            parts.append(q)
            N[row : row + len(rates), rows] = rates * pair.rates
            row += len(rates)
        return np.concatenate(parts), N

    def _at(self, x: Array) -> tuple[Array, Array, Array]:
        frames, data = self._pin.ReferenceFrame, self._data
        q, N = self.configuration(x)
        self._pin.computeJointJacobians(self.model, data, q)
        g = self._pin.updateFramePlacement(self.model, data, self._tool).homogeneous
        # A model of one degree of freedom returns (6,).
        spatial, body = (
            self._pin.getFrameJacobian(self.model, data, self._tool, frame).reshape(6, -1) @ N
            for frame in (frames.WORLD, frames.LOCAL)
        )
        return g, spatial, body

    def _joint_model(self, pair: LowerPair) -> Any:
        pin = self._pin
        if pair.kind == "cylindrical":
            model = pin.JointModelComposite(2)
            model.addJoint(pin.JointModelRZ())
            model.addJoint(pin.JointModelPZ())
            return model
        if pair.kind == "helical":
            return pin.JointModelHZ(pair.pitch)
        made = {"revolute": pin.JointModelRZ, "prismatic": pin.JointModelPZ, "planar": pin.JointModelPlanar}
        return made.get(pair.kind, pin.JointModelSphericalZYX)()


def _planar(x: Array) -> tuple[Array, Array]:
    """(x, y, cos θ, sin θ); its velocity is the body's: R(θ)ᵀ (ẋ, ẏ), θ̇."""
    c, s = np.cos(x[2]), np.sin(x[2])
    return np.array([x[0], x[1], c, s]), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
