"""Moving target: a curve of the tool, and the part of its pose to follow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ik.targets import AnyTarget, Approach, Pose, Position, TolerancedPose
from ...ik.task_space import USUAL, Tolerances
from ...support.checks import Array
from .curves import Curve

NO_MOTION = 1e-9
"""A curve that goes no farther than this [m, rad] goes nowhere."""

SPREAD: Array = np.arange(1.0, 17.0) * 0.6180339887498949 % 1.0
"""Places along a curve at which several whole turns are not all back at their beginning."""

SAME = 1e-8
"""Numbers of targets that differ by less are the same."""


@dataclass(frozen=True)
class MovingTarget:
    """A `curve` that the tool follows in the components that the target `like` constrains.

    `tolerances` are the distances at which the tool still meets it. With `leeway` they are used from the first.
    Otherwise configurations are sought exactly first.
    """

    curve: Curve
    like: AnyTarget
    tolerances: Tolerances = USUAL
    leeway: Tolerances | None = None

    def at(self, s: float) -> AnyTarget:
        """The target at s."""
        return self.like.at(self.curve(np.array(s)))

    def freedom(self, n: int) -> int:
        """Return how many of n joints the targets leave free. Tolerances of a `TolerancedPose` count as free."""
        tolerances = np.concatenate([self.like._position_tolerance, self.like._rotation_tolerance])
        return max(n - int(np.count_nonzero(tolerances == 0.0)), 0)

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
            (t.position_error(one), t.orientation_error(one)) for t, one in zip(map(like.at, ideal), g, strict=True)
        ]
        return np.array([p for p, _ in both]), np.array([r for _, r in both])
    position: Array = np.linalg.norm(g[:, :3, 3] - ideal[:, :3, 3], axis=-1)
    if isinstance(like, Pose):
        return position, _angles(np.swapaxes(ideal[:, :3, :3], -1, -2) @ g[:, :3, :3])
    if isinstance(like, Approach):
        axis, wanted = g[:, :3, :3] @ like.axis, ideal[:, :3, :3] @ like.axis
        sine = np.linalg.norm(np.cross(axis, wanted), axis=-1)
        return position, np.arctan2(sine, (axis * wanted).sum(axis=-1))
    return position, np.zeros(len(g))


def _angles(R: Array) -> Array:
    """Return the angles of rotations (k, 3, 3) [rad], accurate for small ones: ‖R − 1‖ is 2√2 sin(angle/2)."""
    chord = np.linalg.norm(R - np.eye(3), axis=(-2, -1))
    return 2.0 * np.arcsin(np.minimum(chord / np.sqrt(8.0), 1.0))
