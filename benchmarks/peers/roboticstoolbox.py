"""Robotics Toolbox: its compiled Levenberg-Marquardt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import roboticstoolbox as rtb
from roboticstoolbox.models.URDF.URDFRobot import URDF_read

TOL = 5e-13  # On E = ½ eᵀe: an error of 1e-6. The default, 1e-6, is an error of 1.4e-3.


class Solver:
    settings = "ets.ik_LM(method='chan', k=0.1, tol=5e-13): tol is on ½ eᵀe; 100 searches of 30 iterations (defaults)"
    distributions = ("roboticstoolbox-python",)

    def __init__(self, robot: dict[str, Any]) -> None:
        links, name, *_ = URDF_read(robot["urdf"])
        self.ets = rtb.Robot(links, name=name).ets(start=robot["base"], end=robot["tip"])

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, bool]:
        solution = self.ets.ik_LM(g, q0=start, tol=TOL, k=0.1, method="chan")
        return solution.q, solution.success

    def kinematics(self) -> dict[str, dict[str, Callable[[np.ndarray], Any]]]:
        return {
            "one": {"fk": self.ets.eval, "fk_jacobian": lambda theta: (self.ets.eval(theta), self.ets.jacobe(theta))},
            "batch": {"fk": self.ets.eval},
        }
