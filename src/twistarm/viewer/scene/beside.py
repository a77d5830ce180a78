"""Another arm in the scene, as translucent rods that follow the joints of the arm on show."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory.screws import exp
from .axes import draw_rods
from .drawing import BLUE, Colour
from .nodes import rod_path

ROOT = "/beside"
FAINT: Colour = (*BLUE[:3], 0.35)


class Beside:
    """The other arm's rods, and where they are.

    Its turning joints follow the turning joints of `leader` in order, and its slides the slides, inside its limits. Its
    other joints keep its ready pose.
    """

    def __init__(self, arm: Arm, leader: Arm) -> None:
        self.arm, self.objects = arm, draw_rods(arm, ROOT, FAINT)
        pairs = [
            pair
            for unit in ("rad", "m")
            for pair in zip(*(np.flatnonzero(np.array(each.units) == unit) for each in (arm, leader)), strict=False)
        ]
        self._own, self._its = np.array(pairs, dtype=int).reshape(-1, 2).T

    def transforms(self, theta: Array) -> dict[str, list[float]]:
        """The matrix of each node by columns, where the leader is at theta."""
        x = self.arm.ready.copy()
        x[self._own] = theta[self._its]
        x = np.clip(x, self.arm.limits.lower, self.arm.limits.upper)
        steps = exp(self.arm.screws.T, self.arm.coupling.A @ x)
        moved = accumulate(steps, np.matmul)
        return {rod_path(i, ROOT): g.T.ravel().tolist() for i, g in enumerate(moved)}
