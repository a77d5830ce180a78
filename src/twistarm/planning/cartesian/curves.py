"""Curves of the tool's pose, g(s) for s in [0, 1]: straight line, screw motion, circular arc."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...support.checks import Array
from ...support.errors import InputError
from ...theory import rotations, screws

FLAT, LOW = 1e-5, 2e-5
"""Three points lie on a line if their triangle is lower than this part of its longest side, or than so many metres:
where it is, the rounding of a configuration would choose the plane of a circle through them.
"""


@dataclass(frozen=True)
class Line:
    """p(s) = p0 + s (p1 − p0) and R(s) = exp(s log(R1 R0ᵀ)) R0: a straight line and a slerp."""

    g0: Array
    g1: Array

    @cached_property
    def turn(self) -> Array:
        """log(R1 R0ᵀ), (3,)."""
        return rotations.log(self.g1[:3, :3] @ self.g0[:3, :3].T)

    @property
    def length(self) -> float:
        """[m]."""
        return float(np.linalg.norm(self.g1[:3, 3] - self.g0[:3, 3]))

    @property
    def angle(self) -> float:
        """[rad]."""
        return float(np.linalg.norm(self.turn))

    @property
    def bend(self) -> tuple[float, float]:
        """0, 0: velocity and angular velocity are constant."""
        return 0.0, 0.0

    def __call__(self, s: Array) -> Array:
        """g(s) (..., 4, 4) at s (...) in [0, 1]."""
        g = np.zeros((*s.shape, 4, 4))
        g[..., :3, :3] = rotations.exp(s[..., None] * self.turn) @ self.g0[:3, :3]
        g[..., :3, 3] = self.g0[:3, 3] + s[..., None] * (self.g1[:3, 3] - self.g0[:3, 3])
        g[..., 3, 3] = 1.0
        return g


@dataclass(frozen=True)
class Screw:
    """g(s) = exp(s ξ̂) g0 with the twist ξ (6,) in base axes (MLS §2.3.3)."""

    g0: Array
    twist: Array

    @property
    def angle(self) -> float:
        """[rad]."""
        return float(np.linalg.norm(self.twist[3:]))

    @property
    def speed(self) -> float:
        """‖p'(s)‖ [m], the same everywhere."""
        v, w = self.twist[:3], self.twist[3:]
        return float(np.linalg.norm(v + np.cross(w, self.g0[:3, 3])))

    @property
    def length(self) -> float:
        """[m]."""
        return self.speed

    @property
    def bend(self) -> tuple[float, float]:
        """‖ω × p'‖ and 0."""
        return self.angle * self.speed, 0.0

    def __call__(self, s: Array) -> Array:
        """g(s) (..., 4, 4) at s (...) in [0, 1]."""
        g: Array = screws.exp(self.twist, s) @ self.g0
        return g


@dataclass(frozen=True)
class Arc:
    """p(s) turned about an axis, p(s) = exp(s ξ̂) p0, and R(s) by slerp to R1: the twist ξ (6,) has no pitch."""

    g0: Array
    twist: Array
    R1: Array

    @cached_property
    def way(self) -> Screw:
        """That of the position."""
        return Screw(self.g0, self.twist)

    @cached_property
    def turn(self) -> Array:
        """log(R1 R0ᵀ), (3,)."""
        return rotations.log(self.R1 @ self.g0[:3, :3].T)

    @property
    def length(self) -> float:
        """[m]."""
        return self.way.length

    @property
    def angle(self) -> float:
        """[rad], of the rotation."""
        return float(np.linalg.norm(self.turn))

    @property
    def bend(self) -> tuple[float, float]:
        """‖ω × p'‖ and 0."""
        return self.way.bend

    def __call__(self, s: Array) -> Array:
        """g(s) (..., 4, 4) at s (...) in [0, 1]."""
        g = self.way(s)
        g[..., :3, :3] = rotations.exp(s[..., None] * self.turn) @ self.g0[:3, :3]
        return g

    @classmethod
    def through(cls, g0: Array, via: Array, g1: Array) -> Arc:
        """The arc from g0 through the point via (3,) to g1.

        The centre lies on both perpendicular bisectors in the plane of the three points. Raises InputError where they
        lie on a line, or two of them are one point, within 20 µm and 1e-5 rad.
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
        return cls(g0, angle * np.concatenate([np.cross(centre, axis), axis]), g1[:3, :3])


Curve = Line | Screw | Arc
"""`length` [m] and `angle` [rad] are how far a curve goes; `bend` bounds ‖p''(s)‖ [m] and ‖ω'(s)‖ [rad]."""
