"""Lines, screws and circular arcs of the tool's pose g(s), s in [0, 1], and targets along them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..ik.targets import AnyTarget, Approach, Pose, Position, TolerancedPose
from ..ik.task_space import USUAL, Tolerances
from ..support.checks import Array
from ..support.errors import InputError
from ..theory import rotations, screws

# Three points are collinear if their triangle is lower than this share of its longest side, or than so many metres.
# Rounding of a configuration would otherwise choose the plane of the circle.
FLAT, LOW = 1e-5, 2e-5
NO_MOTION = 1e-9  # A curve that goes no farther than this [m, rad] goes nowhere.
# Places along a curve at which several whole turns are not all back at their beginning.
SPREAD: Array = np.arange(1.0, 17.0) * 0.6180339887498949 % 1.0
SAME = 1e-8  # Numbers of targets that differ by less are the same.


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


@dataclass(frozen=True)
class MovingTarget:
    """A `curve` that the tool follows in the components that the target `like` constrains.

    `tolerances` are the distances at which the tool still meets it. `exactly`: configurations are sought exactly first.
    """

    curve: Curve
    like: AnyTarget
    tolerances: Tolerances = USUAL
    exactly: bool = True

    def at(self, s: float) -> AnyTarget:
        """The target at s."""
        return self.like.at(self.curve(np.array(s)))

    def same(self, other: MovingTarget) -> bool:
        """Tell whether both targets agree, up to rounding, at three places."""
        if self.like.kind != other.like.kind:
            return False
        s = np.array([0.0, 0.5, 1.0])
        both = zip(self.curve(s), other.curve(s), strict=True)
        return all(np.allclose(self.like.at(g).numbers, other.like.at(h).numbers, rtol=0.0, atol=SAME) for g, h in both)

    @property
    def is_still(self) -> bool:
        """Whether a tool at the curve's start is on it everywhere, in what is constrained."""
        g = np.broadcast_to(self.curve(np.array(0.0)), (len(SPREAD), 4, 4))
        return float(max(map(np.max, self.errors(SPREAD, g)))) <= NO_MOTION

    @property
    def angle(self) -> float:
        """The angle [rad] of the rotation to follow; 0 for a position."""
        return 0.0 if isinstance(self.like, Position) else self.curve.angle

    def errors(self, s: Array, g: Array) -> tuple[Array, Array]:
        """Distances of poses g (k, 4, 4) from the targets at s (k,): [m] and [rad]."""
        return errors_from(self.like, self.curve(s), g)


def errors_from(like: AnyTarget, ideal: Array, g: Array) -> tuple[Array, Array]:
    """Return the distances (k,) of poses g (k, 4, 4) from targets at `ideal`: [m] and [rad]."""
    if isinstance(like, TolerancedPose):
        both = [
            (t.position_error(pose), t.orientation_error(pose)) for t, pose in zip(map(like.at, ideal), g, strict=True)
        ]
        return np.array([p for p, _ in both]), np.array([r for _, r in both])
    position: Array = np.linalg.norm(g[:, :3, 3] - ideal[:, :3, 3], axis=-1)
    if isinstance(like, Pose):
        chord = np.linalg.norm(np.swapaxes(ideal[:, :3, :3], -1, -2) @ g[:, :3, :3] - np.eye(3), axis=(-2, -1))
        # ‖R − 1‖ is 2√2 sin(angle/2): accurate for small angles, where the trace of R is not.
        return position, 2.0 * np.arcsin(np.minimum(chord / np.sqrt(8.0), 1.0))
    if isinstance(like, Approach):
        axis, wanted = g[:, :3, :3] @ like.axis, ideal[:, :3, :3] @ like.axis
        sine = np.linalg.norm(np.cross(axis, wanted), axis=-1)
        return position, np.arctan2(sine, (axis * wanted).sum(axis=-1))
    return position, np.zeros(len(g))
