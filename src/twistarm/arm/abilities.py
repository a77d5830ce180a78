"""Motions that an arm's tool has here, almost everywhere or nowhere, and words for those that it lacks.

Servo, inverse kinematics, the doctor and the page ask here, so all have one tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..support.checks import Array
from ..support.directions import axis_in_words, nearest_axes
from ..theory.manipulability import scaled_jacobian
from .arm import Arm
from .arm_data import kept

CANNOT_MOVE = "this arm cannot move that way"
CANNOT_TURN = "this arm cannot turn that way"

# A singular value [rad per rad] below this counts as zero. Descriptions write 1.57 for a right angle.
NO_MOTION = 1e-3
SAMPLES = 16  # Number of random configurations. Almost every configuration has the largest rank of the arm.
BESIDE = 0.05  # Distance [scaled rad] from a singular configuration at which its missing directions are found.
MOSTLY = 0.5  # An arm has a direction if it has at least this share of it.

Half = tuple[int, ...]

LINEAR: Half = (0, 1, 2)
ANGULAR: Half = (3, 4, 5)  # Components of a twist (v, w).


def lacks(arm: Arm, theta: Array, half: Half, direction: Array, frame: str, before: Sequence[int] = ()) -> bool:
    """Whether the tool can move along or turn about the unit vector (3,) neither at theta (n,) nor elsewhere.

    Only motions that leave the components `before` unchanged count: J_half N, with N the null space of J_before.
    Metres are measured in the reach, in axes of `frame`. An analytic Jacobian has its largest rank almost everywhere.
    If the rank here is less than at random configurations, this configuration lacks some directions.
    """
    here = span(arm, theta, half, before, frame)[0]
    if _holds(here, direction):
        return False
    less = largest_rank(arm, half, before, frame) - here.shape[1]
    if less <= 0:
        return True
    unit = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    way = (arm.random_theta(0) - theta) / unit  # in no particular direction
    U, size = span(arm, theta + BESIDE * unit * way / np.linalg.norm(way), half, before, frame)
    beside = U * size
    rest = np.linalg.svd(beside - here @ (here.T @ beside))[0]
    return not _holds(rest[:, :less], direction)


def cannot_move(axis: Array, frame: str, held: str = "") -> str:
    """The words for a unit vector (3,) along which no joint moves the tool with `held` fixed."""
    holding = f"with {held} held, " if held else ""
    return f"{CANNOT_MOVE}: {holding}no joint moves the tool along {axis_in_words(axis, frame)}"


def cannot_turn(axis: Array, frame: str, held: str = "") -> str:
    """The words for a unit vector (3,) about which no joint turns the tool with `held` fixed."""
    holding = f"with {held} held, " if held else ""
    return f"{CANNOT_TURN}: {holding}no joint turns the tool about {axis_in_words(axis, frame)}"


def must_turn(axis: Array, frame: str) -> str:
    """The words for a motion that must turn the tool about the unit vector (3,)."""
    return f"{CANNOT_MOVE} without turning the tool about {axis_in_words(axis, frame)}"


def singular(what: str, share: float, joint: str | None, axis: str = "") -> str:
    """The words for a configuration near a singularity, with `what` "move" or "turn" and the `share` that is done.

    `joint` is the joint that would have to move most, if known. `axis` is the lost direction.
    """
    if share >= 0.5:
        return f"near a singularity: this arm does not {what} quite that way from here"
    most = f"; {joint} would have to move most for it" if joint else ""
    way = f"{'about' if what == 'turn' else 'along'} {axis}" if axis else "that way"
    return f"near a singularity: this arm can hardly {what} {way} from here{most}"


def position_limit(side: str, joint: str) -> str:
    """The words for the "lower" or "upper" end of a joint or motor."""
    return f"the {side} position limit of {joint}"


def largest_rank(arm: Arm, half: Half, before: Sequence[int], frame: str) -> int:
    """The largest rank of `span` among random configurations."""
    return spans(arm, half, before, frame)[0].shape[1]


def spans(arm: Arm, half: Half, before: Sequence[int], frame: str) -> list[Array]:
    """The directions U of `span` at those random configurations that have the largest rank, kept with the arm."""

    def make() -> list[Array]:
        found = [span(arm, theta, half, before, frame)[0] for theta in arm.random_theta(0, SAMPLES)]
        rank = max(U.shape[1] for U in found)
        return [U for U in found if U.shape[1] == rank]

    return kept(arm, ("spans", half, tuple(before), frame), make)


def span(arm: Arm, theta: Array, half: Half, before: Sequence[int], frame: str) -> tuple[Array, Array]:
    """Orthonormal U (m, k) and σ (k,), descending: the directions of m components of a twist in which the tool moves.

    Only motions that leave the components `before` at rest count, as in `lacks`.
    """
    g, J = arm.fk_and_body_jacobian(theta)
    rotated = J if frame == "tool" else np.kron(np.eye(2), g[:3, :3]) @ J
    rows = scaled_jacobian(rotated, arm.prismatic, arm.reach)
    _, size, Vt = np.linalg.svd(rows[list(before)])
    free = Vt[int((size > NO_MOTION).sum()) :].T
    U, size, _ = np.linalg.svd(rows[list(half)] @ free)
    rank = int((size > NO_MOTION).sum())
    return U[:, :rank], size[:rank]


class Abilities(NamedTuple):
    """The number of directions that the tool moves in almost everywhere, and directions (k, 3), a unit vector a row.

    `position` is the rank of the linear half of the Jacobian, `turning` that of the rotations that hold the position.
    `immovable` and `unrotated` are directions in base axes that no motion goes along or about. `rotated_base` and
    `rotated_tool` are axes in the base or the tool that the tool can always turn about, with its position held.
    """

    position: int
    turning: int
    immovable: Array
    unrotated: Array
    rotated_base: Array
    rotated_tool: Array

    @property
    def rank(self) -> int:
        """Directions of motion, of six."""
        return self.position + self.turning


def abilities_of(arm: Arm) -> Abilities:
    """The ranks and common directions at random configurations.

    The ranks of an analytic Jacobian are the largest almost everywhere. A direction that is missing at many random
    configurations is missing at all.
    """

    def common(share: float, half: Half, before: Half, frame: str) -> Array:
        """The directions with this share, 0 or 1, in every span."""
        projectors = [U @ U.T for U in spans(arm, half, before, frame)]
        values, vectors = np.linalg.eigh(np.mean(projectors, axis=0))
        vectors = vectors[:, np.abs(values - share) <= NO_MOTION**2]
        return nearest_axes(vectors @ vectors.T, vectors.shape[1]).T

    position = largest_rank(arm, LINEAR, (), "base")
    return Abilities(
        position=position,
        # A direction near NO_MOTION counts for the position at one configuration, and is free for a turn at another.
        turning=min(largest_rank(arm, ANGULAR, LINEAR, "base"), arm.n - position),
        immovable=common(0.0, LINEAR, (), "base"),
        unrotated=common(0.0, ANGULAR, (), "base"),
        rotated_base=common(1.0, ANGULAR, LINEAR, "base"),
        rotated_tool=common(1.0, ANGULAR, LINEAR, "tool"),
    )


def _holds(span: Array, direction: Array) -> bool:
    return bool(np.linalg.norm(span.T @ direction) > MOSTLY)
