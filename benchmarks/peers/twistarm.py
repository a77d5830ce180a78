"""twistarm: its public calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import twistarm
from twistarm.arm import engine


class Solver:
    settings = f"solve_ik(arm, g, theta0), as it comes; core: {engine.instruction_set() or engine.why_not()}"
    distributions = ("twistarm",)

    def __init__(self, robot: dict[str, Any]) -> None:
        limits = {side: dict(zip(robot["joints"], robot[side], strict=True)) for side in ("lower", "upper")}
        self.arm = twistarm.load_arm(robot["whole_urdf"], base=robot["base"], tip=robot["tip"], limits=limits)

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, bool, twistarm.IKResult]:
        solution = twistarm.solve_ik(self.arm, g, start)
        return solution.theta, solution.converged, solution

    def reason(self, solution: twistarm.IKResult) -> str:
        """The reason is found by the call, and put into words only when it is read."""
        return solution.stop.name

    def batch(self, targets: np.ndarray, starts: np.ndarray, threads: int) -> tuple[np.ndarray, np.ndarray]:
        solutions = twistarm.solve_ik_batch(self.arm, targets, starts, threads=threads)
        return solutions.theta, solutions.converged

    def kinematics(self) -> dict[str, dict[str, Callable[[np.ndarray], Any]]]:
        both = self.arm.fk_and_body_jacobian
        return {
            "one": {
                "fk": self.arm.fk,
                "fk_jacobian": lambda theta: (self.arm.fk(theta), self.arm.body_jacobian(theta)),
            },
            "unchecked": {"fk_jacobian": both},
            "batch": {"fk": self.arm.fk, "fk_jacobian": both},
        }
