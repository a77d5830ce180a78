"""Words for motions that an arm cannot make, shared by servo, inverse kinematics and the page."""

from __future__ import annotations

import weakref
from collections.abc import Sequence

import numpy as np

from ..support.checks import Array
from ..support.directions import axis_in_words
from ..theory.manipulability import scaled_jacobian
from .arm import Arm

CANNOT_MOVE = "this arm cannot move that way"
CANNOT_TURN = "this arm cannot turn that way"

NO_MOTION = 1e-3
"""A singular value [rad per rad] below this counts as zero. Descriptions write 1.57 for a right angle."""

SAMPLES = 16
"""Number of random configurations. Almost every configuration has the largest rank of the arm."""

BESIDE = 0.05
"""Distance [scaled rad] from a singular configuration at which its missing directions are found."""

MOSTLY = 0.5
"""An arm has a direction if it has at least this share of it."""

Half = tuple[int, ...]

LINEAR: Half = (0, 1, 2)
ANGULAR: Half = (3, 4, 5)
"""Components of a twist (v, w)."""


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
    U, size = span(arm, theta + _aside(arm, theta), half, before, frame)
    beside = U * size
    rest = np.linalg.svd(beside - here @ (here.T @ beside))[0]
    return not _holds(rest[:, :less], direction)


def cannot_move(axis: Array, frame: str, held: str = "") -> str:
    """The words for a unit vector (3,) along which no joint moves the tool with `held` fixed."""
    return f"{CANNOT_MOVE}: {_while(held)}no joint moves its tool along {axis_in_words(axis, frame)}"


def cannot_turn(axis: Array, frame: str, held: str = "") -> str:
    """The words for a unit vector (3,) about which no joint turns the tool with `held` fixed."""
    return f"{CANNOT_TURN}: {_while(held)}no joint turns its tool about {axis_in_words(axis, frame)}"


def must_turn(axis: Array, frame: str) -> str:
    """The words for a motion that must turn the tool about the unit vector (3,)."""
    return f"{CANNOT_MOVE} without turning its tool about {axis_in_words(axis, frame)}"


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


def _while(held: str) -> str:
    return f"with {held} held, " if held else ""


_RANKS: weakref.WeakKeyDictionary[Arm, dict[tuple[object, ...], int]] = weakref.WeakKeyDictionary()


def largest_rank(arm: Arm, half: Half, before: Sequence[int], frame: str) -> int:
    """The largest rank of `span` among random configurations, cached with the arm."""
    kept = _RANKS.setdefault(arm, {})
    key = (half, tuple(before), frame)
    if key not in kept:
        kept[key] = max(span(arm, theta, half, before, frame)[0].shape[1] for theta in arm.random_theta(0, SAMPLES))
    return kept[key]


def span(arm: Arm, theta: Array, half: Half, before: Sequence[int], frame: str) -> tuple[Array, Array]:
    """Orthonormal U (m, k) and σ (k,), descending: the directions of m components of a twist in which the tool moves.

    Only motions that leave the components `before` at rest count, as in `lacks`.
    """
    g, J = arm.fk_and_body_jacobian(theta)
    turned = J if frame == "tool" else np.kron(np.eye(2), g[:3, :3]) @ J
    rows = scaled_jacobian(turned, np.array(arm.units) == "m", arm.reach)
    _, size, Vt = np.linalg.svd(rows[list(before)])
    free = Vt[int((size > NO_MOTION).sum()) :].T
    U, size, _ = np.linalg.svd(rows[list(half)] @ free)
    rank = int((size > NO_MOTION).sum())
    return U[:, :rank], size[:rank]


def _holds(span: Array, direction: Array) -> bool:
    return bool(np.linalg.norm(span.T @ direction) > MOSTLY)


def _aside(arm: Arm, theta: Array) -> Array:
    """A short way (n,) [rad, m] in no particular direction."""
    unit = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    way = (arm.random_theta(0) - theta) / unit
    return BESIDE * unit * way / np.linalg.norm(way)
