"""Pinocchio: the loop of its inverse kinematics example with limits and restarts, and its forward kinematics."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from .restarts import ITERATIONS, SETTINGS, Restarts, met

STEP, DAMPING = 1.0, 1e-12  # The whole step (the example's 0.1 is slower) and the example's damping.


class Solver:
    settings = (
        f"the loop of its example (log6, damped pseudo-inverse, step {STEP:g}), clipped to the limits; {SETTINGS}"
    )
    distributions = ("pin",)

    def __init__(self, robot: dict[str, Any]) -> None:
        self.model = pin.buildModelFromUrdf(robot["urdf"])
        self.data = self.model.createData()
        self.tip = self.model.getFrameId(robot["tip"])
        self.restarts = Restarts(robot["lower"], robot["upper"])

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, bool]:
        goal = pin.SE3(g)
        return self.restarts.until_met(lambda theta: self._search(goal, theta), start)

    def _search(self, goal: pin.SE3, theta: np.ndarray) -> tuple[np.ndarray, bool]:
        lower, upper = self.restarts.lower, self.restarts.upper
        for _ in range(ITERATIONS):
            pin.forwardKinematics(self.model, self.data, theta)
            to_goal = pin.updateFramePlacement(self.model, self.data, self.tip).actInv(goal)
            error = pin.log6(to_goal).vector
            if met(error):
                return theta, True
            J = pin.computeFrameJacobian(self.model, self.data, theta, self.tip, pin.LOCAL)
            J = -pin.Jlog6(to_goal.inverse()) @ J
            step = -J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(6), error)
            theta = np.clip(theta + STEP * step, lower, upper)
        return theta, False

    def kinematics(self) -> dict[str, dict[str, Callable[[np.ndarray], Any]]]:
        return {
            "one": {"fk": lambda x: self._fk(self._checked(x)), "fk_jacobian": lambda x: self._both(self._checked(x))},
            "unchecked": {"fk": self._fk, "fk_jacobian": self._both},
            "batch": {"fk": self._fk_batch, "fk_jacobian": self._both_batch},
        }

    def _checked(self, theta: np.ndarray) -> np.ndarray:
        """What twistarm checks of a theta: numbers, finite, as many as joints."""
        theta = np.asarray(theta, dtype=float)
        if theta.shape != (self.model.nq,) or not np.isfinite(theta).all():
            raise ValueError("theta")
        return theta

    def _fk(self, theta: np.ndarray) -> np.ndarray:
        pin.forwardKinematics(self.model, self.data, theta)
        pose: np.ndarray = pin.updateFramePlacement(self.model, self.data, self.tip).homogeneous
        return pose

    def _both(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        pin.computeJointJacobians(self.model, self.data, theta)  # and forward kinematics
        pose = pin.updateFramePlacement(self.model, self.data, self.tip).homogeneous
        return pose, pin.getFrameJacobian(self.model, self.data, self.tip, pin.LOCAL)

    def _fk_batch(self, theta: np.ndarray) -> np.ndarray:
        g = np.empty((len(theta), 4, 4))
        for i, row in enumerate(theta):
            g[i] = self._fk(row)
        return g

    def _both_batch(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        g, J = np.empty((len(theta), 4, 4)), np.empty((len(theta), 6, self.model.nv))
        for i, row in enumerate(theta):
            g[i], J[i] = self._both(row)
        return g, J
