"""Motions that an arm's tool has almost everywhere, and those it never has: ranks and common null spaces.

Statements about "every configuration" come from random ones. The ranks of an analytic Jacobian are the largest almost
everywhere. A direction that is missing at many random configurations is missing at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arm.arm import Arm
from ...limits.joint_limits import slides
from ...support.checks import Array
from ...support.directions import nearest_axes
from ...theory.manipulability import scaled_jacobian

SAMPLES = 32
"""Random configurations; the largest rank among them is the arm's."""

TOL = 1e-3
"""Motions below this share of the largest [rad/rad] are none: rpy="1.5708" tilts an axis by 4e-6."""


@dataclass(frozen=True, eq=False)
class Abilities:
    """The number of directions that the tool moves in, and the missing ones. Axes are unit vectors, one a row.

    `position` and `rotation` are the ranks of the two halves of the Jacobian. `turning` is the rank of the rotations
    that hold the position; position + turning is the rank of the whole. `immovable` and `unturned` are directions in
    base axes that no motion goes along or about. `turned_base` and `turned_tool` are axes in the base or the tool that
    the tool can always turn about, with its position held. `free` (k, 3, turning) spans all of them, in base axes.
    `R` (k, 3, 3) and `body` (k, 6, n) are the rotations and scaled body Jacobians of the k random configurations.
    """

    position: int
    rotation: int
    turning: int
    immovable: Array
    unturned: Array
    turned_base: Array
    turned_tool: Array
    free: Array
    R: Array
    body: Array

    @property
    def rank(self) -> int:
        """Directions of motion, of six."""
        return self.position + self.turning


def abilities_of(arm: Arm) -> Abilities:
    """Ranks and common directions at seeded random configurations inside the limits."""
    prismatic = np.array([slides(kind) for kind in arm.joint_types])
    pairs = [arm.fk_and_body_jacobian(theta) for theta in arm.random_theta(0, SAMPLES)]
    R = np.stack([g[:3, :3] for g, _ in pairs])
    body = np.stack([scaled_jacobian(J, prismatic, arm.reach) for _, J in pairs])
    linear, angular = R @ body[:, :3], R @ body[:, 3:]
    position, rotation = _rank(linear), _rank(angular)
    holding = np.swapaxes(np.linalg.svd(linear)[2][:, position:], 1, 2)
    turns = angular @ holding
    turning = _rank(turns)
    free = np.linalg.svd(turns)[0][:, :, :turning]
    return Abilities(
        position=position,
        rotation=rotation,
        turning=turning,
        immovable=_common_null(linear),
        unturned=_common_null(angular),
        turned_base=_common(free),
        turned_tool=_common(np.swapaxes(R, 1, 2) @ free),
        free=free,
        R=R,
        body=body,
    )


def _rank(rows: Array) -> int:
    """The largest rank among the matrices (k, 3, n)."""
    if not rows.shape[2]:
        return 0
    return int((np.linalg.svd(rows, compute_uv=False) > TOL).sum(axis=1).max())


def _common_null(rows: Array) -> Array:
    """Directions (j, 3) across every column of every matrix (k, 3, n)."""
    return _smallest(np.einsum("kin,kjn->ij", rows, rows) / len(rows))


def _common(spans: Array) -> Array:
    """Directions (j, 3) inside every one of the spans (k, 3, d), orthonormal columns."""
    missing = np.eye(3) - spans @ np.swapaxes(spans, 1, 2)
    return _smallest(missing.mean(axis=0))


def _smallest(gram: Array) -> Array:
    """Eigenvectors (j, 3) of a Gram matrix to zero eigenvalues, nearest to the axes."""
    values, vectors = np.linalg.eigh(gram)
    zero = vectors[:, values <= TOL**2]
    return nearest_axes(zero @ zero.T, zero.shape[1]).T
