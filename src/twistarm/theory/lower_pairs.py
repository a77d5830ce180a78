"""The lower pairs in a chain: which of its joints make up one of MLS's six types.

The inverse of `joints`: from twists back to revolute, prismatic, helical, cylindrical, spherical and planar joints.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ..support.checks import Array
from .screws import Screw, to_screw

Kind = Literal["revolute", "prismatic", "helical", "cylindrical", "spherical", "planar"]

SAME_TOL = 1e-13
"""Axes and points this close, relative to 1 m, are the same but for rounding; angles typed to seven digits are not."""


class LowerPair(NamedTuple):
    """One lower pair of a chain, made of `span` consecutive moving joints.

    `axis` (3,) is its axis or normal at rest in base axes, of a ball the first. The pair's coordinates are those of
    the moving joints `rows`, in the order of `joints`: rz, z (cylindrical); rz, ry, rx (spherical); x, y, rz (planar).
    A helical pair has one coordinate, the turn [rad], and the `pitch` [m/rad].
    """

    kind: Kind
    rows: tuple[int, ...]
    span: int
    axis: Array
    pitch: float = 0.0


def lower_pairs(screws: Array, A: Array) -> tuple[LowerPair, ...]:
    """The lower pairs of a chain, base to tip: space twists `screws` (6, m) at rest, coupling A (m, n).

    These consecutive joints make a group:

    - planar: two slides at right angles and a turn about their right-handed normal;
    - spherical: three turns about the z, y and x of a right-handed frame at rest, through one point;
    - cylindrical or helical: a turn and a slide along one line, either first. They move by themselves, or in a fixed
      ratio.

    Every other joint is a pair by itself. Joints of a planar, spherical or cylindrical pair move independently: none is
    locked or follows another.
    """
    screw = to_screw(screws.T)
    pairs: list[LowerPair] = []
    i = 0
    while i < screws.shape[1]:
        pairs.append(_planar(screw, A, i) or _spherical(screw, A, i) or _on_one_line(screw, A, i) or _alone(screw, i))
        i += pairs[-1].span
    return tuple(pairs)


def _planar(screw: Screw, A: Array, i: int) -> LowerPair | None:
    rows = (i, i + 1, i + 2)
    if not (_independent(A, rows) and _slides(screw, i) and _slides(screw, i + 1) and _turns(screw, i + 2)):
        return None
    return LowerPair("planar", rows, 3, screw.axis[i + 2]) if _is_rotation(screw.axis[list(rows)].T) else None


def _spherical(screw: Screw, A: Array, i: int) -> LowerPair | None:
    rows = (i, i + 1, i + 2)
    if not (_independent(A, rows) and all(_turns(screw, row) for row in rows)):
        return None
    axes, lines = screw.axis[list(rows)], screw.point[list(rows)]  # axes z, y, x from base to tip
    # The lines' points nearest to the origin are q − w wᵀq, and three orthonormal w make Σ w wᵀ = I: they sum to 2q.
    centre = lines.sum(axis=0) / 2
    meet = np.abs(np.cross(axes, centre - lines)).max() <= SAME_TOL * (1 + np.abs(centre).max())
    return LowerPair("spherical", rows, 3, axes[0]) if _is_rotation(axes[::-1].T) and meet else None


def _on_one_line(screw: Screw, A: Array, i: int) -> LowerPair | None:
    """A cylindrical or helical pair. A slide parallel to the turn's axis lies on it."""
    if i + 1 >= len(A):
        return None
    turn, slide = (i, i + 1) if _turns(screw, i) else (i + 1, i)
    axis, sine = screw.axis[turn], np.linalg.norm(np.cross(screw.axis[turn], screw.axis[slide]))
    if not (_turns(screw, turn) and _slides(screw, slide)) or sine > SAME_TOL:
        return None
    if _independent(A, (turn, slide)):
        return LowerPair("cylindrical", (turn, slide), 2, axis)
    advance = np.sign(axis @ screw.axis[slide]) * screw.magnitude[slide] / screw.magnitude[turn]
    ratio = _ratio(A[slide], A[turn])
    return None if ratio == 0 else LowerPair("helical", (turn,), 2, axis, float(ratio * advance))


def _alone(screw: Screw, i: int) -> LowerPair:
    kind: Kind = "prismatic" if _slides(screw, i) else "revolute" if _turns(screw, i) else "helical"
    return LowerPair(kind, (i,), 1, screw.axis[i], float(screw.pitch[i]) if kind == "helical" else 0.0)


def _turns(screw: Screw, i: int) -> bool:
    """A pure turn: its pitch is the rounding of 0."""
    return bool(abs(screw.pitch[i]) <= SAME_TOL * (1 + np.abs(screw.point[i]).max()))


def _slides(screw: Screw, i: int) -> bool:
    return bool(np.isinf(screw.pitch[i]))


def _independent(A: Array, rows: tuple[int, ...]) -> bool:
    """Whether all these joints are there and move without the others."""
    return max(rows) < len(A) and int(np.linalg.matrix_rank(A[list(rows)])) == len(rows)


def _ratio(follower: Array, leader: Array) -> float:
    """follower / leader where one row is a multiple of the other, else 0."""
    if not leader.any():
        return 0.0
    ratio = float(follower @ leader / (leader @ leader))
    return ratio if np.abs(follower - ratio * leader).max() <= SAME_TOL * abs(ratio) else 0.0


def _is_rotation(R: Array) -> bool:
    return bool(np.abs(R.T @ R - np.eye(3)).max() <= SAME_TOL and np.linalg.det(R) > 0)
