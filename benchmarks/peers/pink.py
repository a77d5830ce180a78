"""Pink: a frame task solved step by step by daqp, with joint limits, from restarts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.exceptions import PinkError
from pink.tasks import FrameTask

from .restarts import ITERATIONS, SETTINGS, Restarts, met


class Solver:
    settings = f"a FrameTask (costs 1, gain 1) with joint limits, no velocity limits, daqp, in a loop; {SETTINGS}"
    distributions = ("pin-pink", "daqp")

    def __init__(self, robot: dict[str, Any]) -> None:
        self.model = pin.buildModelFromUrdf(robot["urdf"])
        self.task = FrameTask(robot["tip"], position_cost=1.0, orientation_cost=1.0)
        self.configuration = Configuration(self.model, self.model.createData(), pin.neutral(self.model))
        self.limits = [self.model.configuration_limit]
        self.restarts = Restarts(robot["lower"], robot["upper"])

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, bool]:
        self.task.set_target(pin.SE3(g))
        return self.restarts.until_met(self._search, start)

    def _search(self, start: np.ndarray) -> tuple[np.ndarray, bool]:
        configuration = self.configuration
        configuration.update(start)
        for _ in range(ITERATIONS):
            if met(self.task.compute_error(configuration)):
                return configuration.q.copy(), True
            try:
                step = solve_ik(configuration, [self.task], 1.0, solver="daqp", limits=self.limits, safety_break=False)
            except PinkError:  # the quadratic program has no solution from here
                break
            configuration.integrate_inplace(step, 1.0)
        return configuration.q.copy(), False
