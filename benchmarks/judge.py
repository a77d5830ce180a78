"""Pinocchio's verdict on every answer: does theta bring the tool to the target, inside the limits?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from .robots import Robot

STRICT = 1e-6
"""Position [m] and rotation [rad] that an answer may be off."""

LIMIT_SLACK = 1e-7
"""How far beyond a limit rounding may put a joint [rad]."""


@dataclass(frozen=True)
class Errors:
    """Errors of N answers: position [m], rotation [rad] and the largest excess over a limit [rad], each (N,).

    NaN where a solver gave no answer.
    """

    position: np.ndarray
    rotation: np.ndarray
    beyond: np.ndarray

    @property
    def strict(self) -> np.ndarray:
        """Whether an answer meets its target, (N,). No comparison with NaN holds."""
        return (self.position <= STRICT) & (self.rotation <= STRICT) & (self.beyond <= LIMIT_SLACK)


class Judge:
    """Forward kinematics and limits of a robot, by Pinocchio alone."""

    def __init__(self, robot: Robot) -> None:
        self.model = pin.buildModelFromUrdf(robot.urdf)
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot.tip)
        self.lower, self.upper = np.array(robot.lower), np.array(robot.upper)

    def fk(self, theta: np.ndarray) -> np.ndarray:
        """The tool seen from the base, (N, 4, 4), of configurations (N, n)."""
        return np.array([self._pose(row) for row in theta]).reshape(-1, 4, 4)

    def jacobian(self, theta: np.ndarray) -> np.ndarray:
        """The body Jacobian, (N, 6, n), linear part first."""
        each = [pin.computeFrameJacobian(self.model, self.data, row, self.tip, pin.LOCAL).copy() for row in theta]
        return np.array(each)

    def errors(self, theta: np.ndarray, targets: np.ndarray) -> Errors:
        """The errors of the answers (N, n), NaN rows for none, at the targets (N, 4, 4)."""
        if theta.shape != (len(targets), self.model.nq):
            raise ValueError(f"answers must have the shape {(len(targets), self.model.nq)}; got {theta.shape}")
        given = np.isfinite(theta).all(axis=1)
        position, rotation = np.full((2, len(targets)), np.nan)
        g, goal = self.fk(theta[given]), targets[given]
        position[given] = np.linalg.norm(g[:, :3, 3] - goal[:, :3, 3], axis=1)
        # ‖R_a − R_b‖ = 2√2 sin(angle / 2), in which nothing cancels for small angles.
        chord = np.linalg.norm(g[:, :3, :3] - goal[:, :3, :3], axis=(1, 2)) / np.sqrt(8)
        rotation[given] = 2 * np.arcsin(np.minimum(chord, 1.0))
        beyond = np.maximum(self.lower - theta, theta - self.upper).max(axis=1)
        return Errors(position, rotation, beyond)

    def _pose(self, theta: np.ndarray) -> np.ndarray:
        pin.forwardKinematics(self.model, self.data, theta)
        pose: np.ndarray = pin.updateFramePlacement(self.model, self.data, self.tip).homogeneous
        return pose
