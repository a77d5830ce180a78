"""Following: the joint path through a ladder's configurations that keeps the tool on its curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import extremes, spread
from ..spline import unforced
from ..tolerances import leeway
from ..within import POSITION_TOL as ROUNDING
from .meeting import met_near
from .moving_target import MovingTarget
from .nodes import EXACT, LONGEST_JUMP, Blocked, Node
from .projection import projected
from .tool_derivatives import deviation_bend

Flags = NDArray[np.bool_]

POSITION_TOL, ANGLE_TOL = 1e-4, np.radians(0.05)
"""Greatest distance of the tool from the curve [m, rad], also between samples. Wider tolerances replace it."""

SHARE = 0.95
"""A path that uses less than this share of a wide tolerance is sampled more densely and keeps its targets."""

MOST_SAMPLES = 4096

MOST_CHECKS = 20_000

ROUNDS = 12
"""Halvings of intervals in which the tool is too far from the curve."""

SMOOTHINGS = 20
"""How often the samples of a redundant arm are smoothed toward the line between their neighbours."""


@dataclass(frozen=True, eq=False)
class Followed:
    """A joint path on s in [0, 1], with bounds of the tool's error [m, rad]."""

    path: JointPath
    position_error: float
    angle_error: float


def follow(arm: Arm, samples: Sequence[Node], *, even: bool = False) -> Followed | Blocked:
    """Return the joint path through samples of one curve, or the place where it leaps.

    A C² cubic spline goes through the samples. Intervals where the tool may be too far from the curve are halved. Too
    far means beyond `POSITION_TOL`, `ANGLE_TOL` or wider tolerances. The deviation is measured at check points. The
    curvature of the tool's path bounds it between them. `even` first evens out the samples of a redundant arm.
    """
    moving = samples[0].moving
    s, theta = np.array([node.s for node in samples]), np.array([node.theta for node in samples])
    if even:
        theta = _evened(arm, moving, s, theta)
    for _ in range(ROUNDS):
        path = JointPath(s, unforced(theta, s, "not-a-knot"))
        off, position, angle = _deviation(arm, moving, path)
        outside = _outside(arm, path)
        off |= outside
        if not off.any():
            return Followed(path, position, angle)
        if len(s) > MOST_SAMPLES:
            break
        between = 0.5 * (s[:-1] + s[1:])[off]
        found = path(between)
        met = _uses_tolerance_well(arm, moving, between, found) & ~outside[off]
        found[~met], met[~met] = met_near(arm, moving, moving.curve(between[~met]), found[~met])
        if not met.all():
            unmet = int(np.flatnonzero(~met)[0])
            return _blocked(samples[0], s, theta, float(between[unmet]), leap=False)
        s, theta = np.concatenate([s, between]), np.concatenate([theta, found])
        order = np.argsort(s, kind="stable")
        s, theta = s[order], theta[order]
    worst = int(np.flatnonzero(off)[0])
    return _blocked(samples[0], s, theta, float(s[worst + 1]), leap=True)


def _uses_tolerance_well(arm: Arm, moving: MovingTarget, s: Array, theta: Array) -> Flags:
    """Tell which configurations (k, n) at s (k,) are well within wide tolerances."""
    if leeway(moving.tolerances) is None:
        return np.zeros(len(s), dtype=bool)
    position, angle = moving.errors(s, arm.fk(theta))
    return (position <= SHARE * moving.tolerances.position) & (angle <= SHARE * moving.tolerances.orientation)


def _evened(arm: Arm, moving: MovingTarget, s: Array, theta: Array) -> Array:
    """Pull the samples (k, n) toward the line between their neighbours. The targets stay met."""
    ideal = moving.curve(s[1:-1])
    share = ((s[1:-1] - s[:-2]) / (s[2:] - s[:-2]))[:, None]
    theta = theta.copy()
    for _ in range(SMOOTHINGS):
        between = theta[:-2] + share * (theta[2:] - theta[:-2])
        found, met = projected(arm, moving.like, ideal, between, EXACT, leeway(moving.tolerances))
        met &= np.abs(found - theta[1:-1]).max(axis=1) <= LONGEST_JUMP
        theta[1:-1][met] = found[met]
    return theta


def _blocked(root: Node, s: Array, theta: Array, ahead: float, *, leap: bool) -> Blocked:
    last = int(np.searchsorted(s, ahead, side="left")) - 1
    return Blocked(Node(root.moving, float(s[last]), theta[last], root.cost, root), ahead, leap)


def _deviation(arm: Arm, moving: MovingTarget, path: JointPath) -> tuple[Flags, float, float]:
    """Pieces (m,) in which the tool may be too far away, and its greatest distance [m, rad].

    Between check points a distance d apart, the deviation e exceeds the larger end by at most d² ‖e''‖ / 8.
    """
    h = np.diff(path.breakpoints)
    bend = deviation_bend(arm, moving, path)
    tolerance = np.maximum([POSITION_TOL, ANGLE_TOL], [moving.tolerances.position, moving.tolerances.orientation])
    part = min(float((4.0 * tolerance / np.maximum(bend.max(axis=0), 1e-12)).min()) ** 0.5, 1.0)
    each = np.clip(np.ceil(h / part), 2, max(2, MOST_CHECKS // len(h))).astype(np.int64)
    piece, within = spread(each)
    s = np.append(path.breakpoints[piece] + h[piece] * within / each[piece], path.length)
    position, angle = moving.errors(s, arm.fk(path(s)))
    slack = (h / each) ** 2 / 8.0
    greatest = [
        np.maximum.reduceat(np.maximum(error[:-1], error[1:]), np.cumsum(each) - each) + slack * bend[:, i]
        for i, error in enumerate((position, angle))
    ]
    off = (greatest[0] > tolerance[0]) | (greatest[1] > tolerance[1])
    return off, float(greatest[0].max()), float(greatest[1].max())


def _outside(arm: Arm, path: JointPath) -> Flags:
    """Tell in which pieces (m,) a joint passes its limit by more than rounding."""
    h = np.diff(path.breakpoints)
    outside: Flags = _beyond(arm, bernstein(path.coefficients, h)) > ROUNDING
    if outside.any():  # the Bernstein coefficients may lie beyond where the spline does not
        outside[outside] = _beyond(arm, extremes(path.coefficients[:, outside], h[outside])[1]) > ROUNDING
    return outside


def _beyond(arm: Arm, values: Array) -> Array:
    return np.maximum(arm.limits.lower - values, values - arm.limits.upper).max(axis=(0, 2))
