"""Following: the joint path through a ladder's configurations that keeps the tool on its curve."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...support.checks import Array
from ..joint_path import JointPath
from ..piecewise import bernstein, extremes
from ..spline import cubic_not_forced
from ..within import POSITION_TOL as ROUNDING
from .curves import MovingTarget
from .ladder import Blocked, Node
from .projection import solve_near

Flags = NDArray[np.bool_]

POSITION_TOL, ANGLE_TOL = 1e-4, np.radians(0.05)
"""Greatest distance of the tool from the curve [m, rad]. Wider tolerances replace it."""

RESERVE = 0.95
"""Share of `POSITION_TOL` and `ANGLE_TOL` that check points may use. The rest is for what lies between them."""

FEWEST_CHECKS, CHECKS, MOST_CHECKS = 4, 16, 40_000
"""Intervals of check points in each piece of a path, and the most on a whole path of many pieces."""

SHARE = 0.95
"""A path that uses less than this share of a wide tolerance is sampled more densely and keeps its targets."""

MOST_SAMPLES = 4096

ROUNDS = 12
"""Halvings of intervals in which the tool is too far from the curve."""


def follow(arm: Arm, samples: Sequence[Node]) -> JointPath | Blocked:
    """Return the joint path through samples of one curve, or the place where it leaps.

    A C² cubic spline goes through the samples. Intervals where the tool is too far from the curve are halved. Too far
    means beyond `POSITION_TOL`, `ANGLE_TOL` or wider tolerances, at check points that lie densely in each interval.
    """
    moving = samples[0].moving
    s, theta = np.array([node.s for node in samples]), np.array([node.theta for node in samples])
    for _ in range(ROUNDS):
        path = JointPath(s, cubic_not_forced(theta, s, "not-a-knot"))
        outside = _outside(arm, path)
        off = _too_far(arm, moving, path) | outside
        if not off.any():
            return path
        if len(s) > MOST_SAMPLES:
            break
        between = 0.5 * (s[:-1] + s[1:])[off]
        found = path(between)
        good = _uses_tolerance_well(arm, moving, between, found) & ~outside[off]
        found[~good], good[~good] = solve_near(arm, moving, moving.curve(between[~good]), found[~good])
        if not good.all():
            return _blocked(samples[0], s, theta, float(between[int(np.argmin(good))]), leap=False)
        s, theta = np.concatenate([s, between]), np.concatenate([theta, found])
        order = np.argsort(s, kind="stable")
        s, theta = s[order], theta[order]
    return _blocked(samples[0], s, theta, float(s[int(np.argmax(off)) + 1]), leap=True)


def _uses_tolerance_well(arm: Arm, moving: MovingTarget, s: Array, theta: Array) -> Flags:
    """Tell which configurations (k, n) at s (k,) are well within wide tolerances."""
    if moving.leeway is None:
        return np.zeros(len(s), dtype=bool)
    position, angle = moving.errors(s, arm.fk(theta))
    return (position <= SHARE * moving.tolerances.position) & (angle <= SHARE * moving.tolerances.orientation)


def _blocked(root: Node, s: Array, theta: Array, ahead: float, *, leap: bool) -> Blocked:
    last = int(np.searchsorted(s, ahead, side="left")) - 1
    return Blocked(Node(root.moving, float(s[last]), theta[last], root.cost, root), ahead, leap)


def _too_far(arm: Arm, moving: MovingTarget, path: JointPath) -> Flags:
    """Tell in which pieces (m,) the tool is too far from the curve at a check point."""
    starts, h = path.breakpoints[:-1], np.diff(path.breakpoints)
    count = int(np.clip(MOST_CHECKS // len(h), FEWEST_CHECKS, CHECKS))
    inside = np.arange(1, count) / count  # at the ends of pieces are samples, which meet their targets
    s = (starts[:, None] + h[:, None] * inside).ravel()
    allowed = np.maximum(
        [RESERVE * POSITION_TOL, RESERVE * ANGLE_TOL], [moving.tolerances.position, moving.tolerances.orientation]
    )
    far = np.stack(moving.errors(s, arm.fk(path(s))), axis=1) > allowed
    far_in: Flags = np.logical_or.reduce(far.reshape(len(h), -1), axis=1)
    return far_in


def _outside(arm: Arm, path: JointPath) -> Flags:
    """Tell in which pieces (m,) a joint passes its limit by more than rounding."""
    h = np.diff(path.breakpoints)
    outside: Flags = _beyond(arm, bernstein(path.coefficients, h)) > ROUNDING
    if outside.any():  # the Bernstein coefficients may lie beyond where the spline does not
        outside[outside] = _beyond(arm, extremes(path.coefficients[:, outside], h[outside])[1]) > ROUNDING
    return outside


def _beyond(arm: Arm, values: Array) -> Array:
    return np.maximum(arm.limits.lower - values, values - arm.limits.upper).max(axis=(0, 2))
