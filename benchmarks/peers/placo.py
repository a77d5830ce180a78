"""placo: a frame task solved step by step, with joint limits, from restarts."""

from __future__ import annotations

from typing import Any

import numpy as np
import placo

from .restarts import ITERATIONS, SETTINGS, TOLERANCE, Restarts

FLOATING_BASE = 7  # Numbers of the state before the first joint.


class Solver:
    settings = f"a frame task (soft, weights 1) with joint limits, solver.solve(True) in a loop; {SETTINGS}"
    distributions = ("placo",)

    def __init__(self, robot: dict[str, Any]) -> None:
        self.robot = placo.RobotWrapper(robot["urdf"], placo.Flags.ignore_collisions)
        self.solver = placo.KinematicsSolver(self.robot)
        self.solver.mask_fbase(True)
        self.solver.enable_joint_limits(True)
        self.task = self.solver.add_frame_task(robot["tip"], np.eye(4))
        self.task.configure("tool", "soft", 1.0, 1.0)
        self.restarts = Restarts(robot["lower"], robot["upper"])

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, bool]:
        self.task.T_world_frame = g
        return self.restarts.until_met(self._search, start)

    def _search(self, start: np.ndarray) -> tuple[np.ndarray, bool]:
        state = self.robot.state
        state.q[FLOATING_BASE:] = start
        self.robot.update_kinematics()
        for _ in range(ITERATIONS):
            self.solver.solve(True)
            self.robot.update_kinematics()
            if self._met():
                return state.q[FLOATING_BASE:].copy(), True
        return state.q[FLOATING_BASE:].copy(), False

    def _met(self) -> bool:
        position, orientation = self.task.position(), self.task.orientation()
        return position.error_norm() <= TOLERANCE and orientation.error_norm() <= TOLERANCE
