"""EAIK: all closed-form solutions without the least-squares ones, shifted into the limits."""

from __future__ import annotations

from typing import Any

import numpy as np
from eaik.IK_Homogeneous import HomogeneousRobot

from . import Unfit

TURN = 2 * np.pi


class Solver:
    settings = "HomogeneousRobot.IK(g); of the solutions not marked least-squares and inside the limits the nearest"
    distributions = ("EAIK",)

    def __init__(self, robot: dict[str, Any]) -> None:
        if len(robot["joints"]) > 6:
            raise Unfit(f"no decomposition: {len(robot['joints'])} joints, unless some are locked")
        self.robot = HomogeneousRobot(np.array(robot["axis_frames"]))
        if not self.robot.hasKnownDecomposition():
            raise Unfit(f"no decomposition: {self.robot.getKinematicFamily()}")
        self.lower, self.upper = np.array(robot["lower"]), np.array(robot["upper"])

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray | None, bool]:
        return self._nearest(self.robot.IK(g), start)

    def batch(self, targets: np.ndarray, starts: np.ndarray, threads: int) -> tuple[np.ndarray, np.ndarray]:
        each = self.robot.IK_batched(targets, num_worker_threads=threads)
        theta = np.full(starts.shape, np.nan)
        for i, (solutions, start) in enumerate(zip(each, starts, strict=True)):
            nearest, found = self._nearest(solutions, start)
            if found:
                theta[i] = nearest
        return theta, np.isfinite(theta).all(axis=1)

    def _nearest(self, solutions: Any, start: np.ndarray) -> tuple[np.ndarray | None, bool]:
        exact = ~np.asarray(solutions.is_LS, dtype=bool)
        roots = np.asarray(solutions.Q).reshape(len(exact), -1)[exact]
        roots += TURN * np.round((start - roots) / TURN)
        roots += TURN * (roots < self.lower) - TURN * (roots > self.upper)
        roots = roots[((roots >= self.lower) & (roots <= self.upper)).all(axis=1)]
        if not len(roots):
            return None, False
        return roots[np.abs(roots - start).max(axis=1).argmin()], True
