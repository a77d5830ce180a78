"""TRAC-IK by its bindings of pytracik: two solvers race in two threads."""

from __future__ import annotations

from typing import Any

import numpy as np
from trac_ik import TracIK

# EPSILON bounds each component of the error; a norm of 1e-6 needs less than 1e-6 / √3.
EPSILON, SECONDS = 5e-7, 0.05


class Solver:
    settings = f"TracIK(epsilon={EPSILON:g}, timeout={SECONDS:g} s, solver_type='Speed'); it runs two threads"
    distributions = ("pytracik",)

    def __init__(self, robot: dict[str, Any]) -> None:
        self.tracik = TracIK(
            robot["base"], robot["tip"], robot["urdf"], timeout=SECONDS, epsilon=EPSILON, solver_type="Speed"
        )

    def solve(self, g: np.ndarray, start: np.ndarray) -> tuple[np.ndarray | None, bool]:
        theta = self.tracik.ik(g[:3, 3], g[:3, :3], start)
        return theta, theta is not None
