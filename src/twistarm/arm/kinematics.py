"""Kinematics of a chain without the compiled core: by Pinocchio, or by exponentials if there is no Pinocchio model.

Both have the methods of `_core.Chain`, for configurations (N, n).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from ..description.coupling import Affine
from ..description.tree import Description
from ..support.checks import Array
from ..theory import poe
from ..theory.screws import adjoint, inverse
from .pinocchio_model import PinocchioModel


@dataclass(frozen=True, eq=False)
class ByExponentials:
    """g_st(theta) = Π exp(ξ_i (Aθ)_i) · home and its Jacobians, from screws (6, m), home (4, 4) and A (m, n)."""

    screws: Array
    home: Array
    A: Array

    def fk(self, theta: Array) -> Array:
        """g_st (..., 4, 4). MLS §3.2.2, eq. 3.3."""
        return poe.fk(self.screws, self.home, theta @ self.A.T)

    def spatial_jacobian(self, theta: Array) -> Array:
        """J^s (..., 6, n), linear part first. MLS §3.4.1."""
        return poe.spatial_jacobian(self.screws, theta @ self.A.T) @ self.A

    def body_jacobian(self, theta: Array) -> Array:
        """J^b (..., 6, n), linear part first. MLS §3.4.1."""
        return poe.body_jacobian(self.screws, self.home, theta @ self.A.T) @ self.A

    def fk_and_body_jacobian(self, theta: Array) -> tuple[Array, Array]:
        """Both."""
        return self.fk(theta), self.body_jacobian(theta)


class ByPinocchio:
    """Kinematics by Pinocchio, one configuration at a time. `tool` (4, 4) is the tip seen from its link."""

    def __init__(self, model: PinocchioModel, base: str, link: str, tool: Array) -> None:
        self._model, self._links = model, (base, link)
        self._tool, self._action = tool, adjoint(inverse(tool))

    def fk(self, theta: Array) -> Array:
        """g_st (N, 4, 4)."""
        return np.array([self.fk_and_body_jacobian(row)[0] for row in theta]).reshape(-1, 4, 4)

    def spatial_jacobian(self, theta: Array) -> Array:
        """J^s (N, 6, n), linear part first."""
        each = [self._model.spatial_jacobian(row, *self._links) for row in theta]
        return np.array(each).reshape(-1, 6, theta.shape[1])

    def body_jacobian(self, theta: Array) -> Array:
        """J^b (N, 6, n), linear part first."""
        return np.array([self.fk_and_body_jacobian(row)[1] for row in theta]).reshape(-1, 6, theta.shape[1])

    def fk_and_body_jacobian(self, theta: Array) -> tuple[Array, Array]:
        """g_st (4, 4) and J^b (6, n) of one configuration (n,)."""
        g, J = self._model.pose_and_body_jacobian(theta, *self._links)
        return g @ self._tool, self._action @ J


class Tree(Protocol):
    """What the walk along a tree of joints needs of an arm."""

    @property
    def base(self) -> str:
        """The base link."""

    @property
    def description(self) -> Description | None:
        """The links and joints."""

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The coordinates, base to tip."""

    @property
    def couplings(self) -> Mapping[str, Affine]:
        """Each moving joint by its master."""


def walked_poses(arm: Tree, theta: Array, others: Mapping[str, float] = MappingProxyType({})) -> dict[str, Array]:
    """Every link's pose (N, 4, 4) in the base frame by the joints' exponentials along the tree, theta (N, n)."""
    assert arm.description is not None
    poses = arm.description.link_poses(joint_values(arm, theta, others))
    back = inverse(poses[arm.base])
    return {link: np.array(np.broadcast_to(back @ g, (len(theta), 4, 4))) for link, g in poses.items()}


def joint_values(arm: Tree, theta: Array, others: Mapping[str, float] = MappingProxyType({})) -> dict[str, Array]:
    """The value (N,) of every moving joint of the description; joints outside the chain are at `others`, or 0."""
    columns = {name: theta[:, i] for i, name in enumerate(arm.joint_names)}
    columns |= {name: np.full(len(theta), value) for name, value in others.items()}
    zero = np.zeros(len(theta))
    return {
        name: affine.multiplier * columns.get(affine.master or "", zero) + affine.offset
        for name, affine in arm.couplings.items()
    }
