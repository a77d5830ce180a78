"""Curves of the tool's pose g(s), s in [0, 1]: line, screw motion, circular arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...support.checks import Array
from ...support.errors import InputError
from ...theory import rotations, screws

FLAT, LOW = 1e-5, 2e-5
"""Three points are collinear if their triangle is lower than this share of its longest side, or than so many metres.
Rounding of a configuration would otherwise choose the plane of the circle.
"""


@dataclass(frozen=True)
class Curve:
    """p(s) = exp(s ξ̂) p0 with the twist ξ (6,) in base axes (MLS §2.3.3), and R(s) = exp(s φ̂) R0 with φ (3,)."""

    g0: Array
    twist: Array
    turn: Array

    @property
    def length(self) -> float:
        """‖p'(s)‖ [m], the same everywhere: the length of the position's path."""
        v, w = self.twist[:3], self.twist[3:]
        return float(np.linalg.norm(v + np.cross(w, self.g0[:3, 3])))

    @property
    def angle(self) -> float:
        """The angle of the rotation [rad]."""
        return float(np.linalg.norm(self.turn))

    def __call__(self, s: Array) -> Array:
        """g(s) (..., 4, 4) at s (...) in [0, 1]."""
        g: Array = screws.exp(self.twist, s) @ self.g0
        g[..., :3, :3] = rotations.exp(s[..., None] * self.turn) @ self.g0[:3, :3]
        return g


def line(g0: Array, g1: Array) -> Curve:
    """Straight from p0 to p1, and a slerp from R0 to R1."""
    return Curve(g0, np.concatenate([g1[:3, 3] - g0[:3, 3], np.zeros(3)]), _slerp(g0, g1[:3, :3]))


def screw(g0: Array, twist: Array) -> Curve:
    """g(s) = exp(s ξ̂) g0 (MLS §2.3.3)."""
    return Curve(g0, twist, twist[3:])


def arc(g0: Array, via: Array, g1: Array) -> Curve:
    """Circular arc from p0 through `via` (3,) to p1, with a slerp from R0 to R1.

    The centre lies on both perpendicular bisectors in the plane of the three points. Raises InputError where they lie
    on a line or coincide, within 20 µm and 1e-5 rad.
    """
    p0, p1 = g0[:3, 3], g1[:3, 3]
    a, b = via - p0, p1 - p0
    normal = np.cross(a, b)
    longest = float(max(np.linalg.norm(a), np.linalg.norm(b), np.linalg.norm(p1 - via)))
    if np.linalg.norm(normal) <= longest * max(FLAT * longest, LOW):
        raise InputError(
            "start, via and end of an arc must be three points that do not lie on a line: use a LineMove, or "
            "ArcMove.about(axis, centre, angle) for a full circle"
        )
    n2 = normal @ normal
    centre = p0 + np.cross(normal, a) * (b @ b) / (2.0 * n2) + np.cross(b, normal) * (a @ a) / (2.0 * n2)
    axis = normal / np.sqrt(n2)
    r0, r1 = p0 - centre, p1 - centre
    angle = np.arctan2(axis @ np.cross(r0, r1), r0 @ r1) % (2.0 * np.pi)
    return Curve(g0, angle * np.concatenate([np.cross(centre, axis), axis]), _slerp(g0, g1[:3, :3]))


def _slerp(g0: Array, R1: Array) -> Array:
    """log(R1 R0ᵀ), (3,)."""
    return rotations.log(R1 @ g0[:3, :3].T)
