"""Where everything that moves stands at a configuration: one matrix per node of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, hypot, sin
from typing import Any

import numpy as np

from ..arm import Arm
from ..checks import Array
from ..rotations import GIMBAL_LOCK_TOL
from ..screws import hat
from .nodes import link_path, rod_path, screw_path


class Placement:
    """What the frames of one arm have in common, computed once: the names of the nodes and the powers of its screws."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self._links = () if arm.description is None else tuple(arm.description.links)
        self._A = arm.coupling.A
        m = arm.screws.shape[1]
        rods = [rod_path(i) for i in range(m)] if arm.description is None else []
        self._paths = [*map(link_path, self._links), *map(screw_path, range(m)), *rods, "/frames/tool"]
        turn = np.linalg.norm(arm.screws[3:], axis=0)
        self._rate = np.where(turn > 0, turn, 1.0)
        xi = hat((arm.screws / self._rate).T)
        self._placed: tuple[Array | None, Mapping[str, float], dict[str, Any]] = (None, {}, {})
        self._powers = np.stack([xi, xi @ xi, xi + xi @ xi @ xi], axis=1).reshape(m, 3, 16)

    def at(self, theta: Array, others: Mapping[str, float]) -> dict[str, Any]:
        """Joint values [rad, m], the matrix of every moving node by columns, and the tool's position [m] and rpy [rad].

        Links and tool stand where `arm.poses` has them, exactly. The same objects as the last time get the same answer.
        """
        last_theta, last_others, placed = self._placed
        if theta is not last_theta or others is not last_others:
            placed = self._place(theta, others)
            self._placed = (theta, others, placed)
        return placed

    def _place(self, theta: Array, others: Mapping[str, float]) -> dict[str, Any]:
        poses = self.arm.poses(theta, others)
        g_st = poses[self.arm.tip]
        carried = self.carried(theta)
        rods = carried if self.arm.description is None else []
        stacked = np.array([*(poses[name] for name in self._links), *carried, *rods, g_st])
        columns = stacked.transpose(0, 2, 1).reshape(-1, 16).tolist()
        return {
            "theta": theta.tolist(),
            "others": dict(others),
            "transforms": dict(zip(self._paths, columns, strict=True)),
            "tool": {"position": g_st[:3, 3].tolist(), "rpy": rpy(g_st)},
        }

    def carried(self, theta: Array) -> list[Array]:
        """Π_{j≤i} exp(ξ_j (A θ)_j) for every moving joint i: what the joints up to i do to space (MLS §3.2).

        With ‖w‖ = 1, exp(ξ̂φ) = I + sin φ ξ̂ + (1 − cos φ) ξ̂² + (φ − sin φ)(ξ̂ + ξ̂³), since ξ̂⁴ = −ξ̂²; with w = 0 it is
        I + φ ξ̂, and the same sum. The last term is the slide along the axis.
        """
        phi = self._rate * (self._A @ theta)
        sine = np.sin(phi)
        factors = np.array([sine, 1.0 - np.cos(phi), phi - sine]).T
        steps = (factors[:, None] @ self._powers).reshape(-1, 4, 4) + np.eye(4)
        products = [steps[0]]
        for step in steps[1:]:
            products.append(products[-1] @ step)
        return products


def rpy(g: Array) -> list[float]:
    """`rotations.to_rpy` of one pose (4, 4) without its checks, which would be a tenth of a frame's time."""
    (r00, r01, r02, _), (r10, r11, r12, _), (r20, _, _, _), _ = g.tolist()
    radius = hypot(r00, r10)
    yaw = 0.0 if radius <= GIMBAL_LOCK_TOL else atan2(r10, r00)
    c, s = cos(yaw), sin(yaw)
    return [atan2(s * r02 - c * r12, c * r11 - s * r01), atan2(-r20, radius), yaw]
