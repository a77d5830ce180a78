"""Poses of all moving nodes at a configuration: one matrix for each node."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import accumulate
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...ik import IKResult
from ...support.checks import Array
from ...theory.rotations import to_rpy
from ...theory.screws import exp
from ..memo import Memo
from .nodes import link_path, rod_path, screw_path


class Placement:
    """What all frames of one arm share: node names and link poses at rest."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self._links = () if arm.description is None else tuple(arm.description.links)
        m = arm.screws.shape[1]
        rods = [rod_path(i) for i in range(m)] if arm.description is None else []
        self._paths = [*map(link_path, self._links), *map(screw_path, range(m)), *rods, "/frames/tool"]
        self.at = Memo(self._at)

    def _at(self, theta: Array, others: Mapping[str, float]) -> dict[str, Any]:
        """Joint values [rad, m], the matrix of each moving node by columns, and the tool's position [m] and rpy [rad].

        Links and tool are exactly at `arm.poses`.
        """
        poses = self.arm.poses(theta, others)
        g_st = poses[self.arm.tip]
        moved = carried(self.arm, theta)
        rods = moved if self.arm.description is None else moved[:0]
        stacked = np.array([*(poses[name] for name in self._links), *moved, *rods, g_st])
        columns = stacked.transpose(0, 2, 1).reshape(-1, 16).tolist()
        return {
            "theta": theta.tolist(),
            "others": dict(others),
            "transforms": dict(zip(self._paths, columns, strict=True)),
            "tool": {"position": g_st[:3, 3].tolist(), "rpy": to_rpy(g_st[:3, :3]).tolist()},
        }


def carried(arm: Arm, theta: Array) -> Array:
    """The motion of space due to the joints up to i, (m, 4, 4): Π_{j≤i} exp(ξ_j (A θ)_j) (MLS §3.2).

    The pose g_i of a joint's link is that product times g_i(0).
    """
    steps = exp(arm.screws.T, arm.coupling.A @ theta)
    return np.array(list(accumulate(steps, np.matmul)))


def ghost(solution: IKResult, others: Mapping[str, float]) -> dict[str, list[float]] | None:
    """Where each link would stand without joint limits, {node: matrix by columns}.

    None if limits are not the reason: the target is met, or out of reach of any configuration.
    """
    if solution.unlimited is None:
        return None
    return standing_at(Placement(solution.arm), solution.unlimited, others)


def standing_at(placement: Placement, theta: Array, others: Mapping[str, float]) -> dict[str, list[float]]:
    """Where each link stands at theta (n,), {node: matrix by columns}."""
    transforms = placement.at(theta, others)["transforms"]
    return {path: matrix for path, matrix in transforms.items() if path.startswith("/arm/")}
