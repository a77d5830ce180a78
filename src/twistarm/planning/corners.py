"""Corners between two joint paths, rounded inside a ball about the tool's position there."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from .hermite import through
from .joint_path import JointPath
from .piecewise import shifted, side_by_side
from .within import POSITION_TOL, overshoot

SAMPLES = 256
"""Where along a path the tool is looked at for where it leaves the ball; the crossing is then bisected."""

BISECTIONS = 40

ROUNDING = 1e-12
"""A piece shorter than this part of its path is rounding."""

SHRINKS = 20
SMALLER = 0.8
"""A corner that leaves the ball or the position limits begins at so much of its radius, up to so many times."""


def leaves_ball(arm: Arm, path: JointPath, radius: float, *, at_end: bool) -> float | None:
    """Where on `path` the tool first comes out of the ball about one of its ends, seen from that end; None: nowhere."""
    corner = path.end if at_end else path.start
    centre = arm.fk(corner)[:3, 3]
    s = np.linspace(0.0, path.length, SAMPLES)
    if at_end:
        s = s[::-1]
    outside = _distance(arm, path, s, centre) > radius
    if not outside.any():
        return None
    first = int(outside.argmax())
    inner, outer = float(s[first - 1]), float(s[first])
    for _ in range(BISECTIONS):
        middle = 0.5 * (inner + outer)
        if _distance(arm, path, np.array([middle]), centre)[0] > radius:
            outer = middle
        else:
            inner = middle
    return inner


def rounded(
    arm: Arm, before: JointPath, after: JointPath, radius: float, limits: JointLimits
) -> tuple[float, JointPath, float] | None:
    """Where `before` is left, the rounding, and where `after` is met; None where the tool does not leave the ball.

    The rounding is the quintic that has position, first and second derivative of both paths where it leaves and meets
    them (Lynch & Park §9.2.2.1), so that the whole is C². It stays inside the ball and the position limits: where the
    first would not, it begins nearer to the corner.
    """
    centre = arm.fk(before.end)[:3, 3]
    for shrink in range(SHRINKS):
        begins = leaves_ball(arm, before, radius * SMALLER**shrink, at_end=True)
        ends = leaves_ball(arm, after, radius * SMALLER**shrink, at_end=False)
        if begins is None or ends is None:
            return None
        bend = _quintic(before, begins, after, ends)
        inside = overshoot(bend.coefficients, np.diff(bend.breakpoints), limits) <= POSITION_TOL
        if inside and _distance(arm, bend, np.linspace(0.0, bend.length, SAMPLES), centre).max() <= radius:
            return begins, bend, ends
    return None


def part(path: JointPath, begins: float, ends: float) -> JointPath:
    """The path between two values of its parameter, its own parameter from 0."""
    rounding = ROUNDING * path.length
    inner = path.breakpoints[(path.breakpoints > begins + rounding) & (path.breakpoints < ends - rounding)]
    breakpoints = np.concatenate([[begins], inner, [ends]])
    piece = path.piece_at(0.5 * (breakpoints[1:] + breakpoints[:-1]))
    moved = shifted(path.coefficients[:, piece], breakpoints[:-1] - path.breakpoints[piece])
    return JointPath(breakpoints - begins, moved)


def joined(paths: list[JointPath]) -> JointPath:
    """Paths one after the other as one, of the highest degree among them."""
    steps = np.concatenate([np.diff(path.breakpoints) for path in paths])
    return JointPath(np.concatenate([[0.0], np.cumsum(steps)]), side_by_side([path.coefficients for path in paths]))


def _quintic(before: JointPath, begins: float, after: JointPath, ends: float) -> JointPath:
    h = before.length - begins + ends
    q0, v0, a0 = (before(np.array(begins), order) for order in range(3))
    q1, v1, a1 = (after(np.array(ends), order) for order in range(3))
    t = np.array([0.0, h])
    return JointPath(t, through(t, *(np.stack(both) for both in ((q0, q1), (v0, v1), (a0, a1)))))


def _distance(arm: Arm, path: JointPath, s: Array, centre: Array) -> Array:
    distance: Array = np.linalg.norm(arm.fk(path(s))[..., :3, 3] - centre, axis=-1)
    return distance
