"""Following: the joint path that keeps the tool on a curve, from one configuration on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...ik.solution import IKSolution
from ...ik.solve import solve_ik
from ...ik.targets import Pose
from ...model.arm import Arm
from ...support.checks import Array
from ..bernstein import bernstein
from ..joint_path import JointPath
from ..piecewise import extremes
from ..within import POSITION_TOL as ROUNDING
from .curvature import deviation_bend
from .moving_target import MovingTarget

Flags = NDArray[np.bool_]

POSITION_TOL, ANGLE_TOL = 1e-4, np.radians(0.05)
"""How far the tool may be from the curve [m, rad], between samples too."""

FIRST_STEP, FIRST_TURN = 0.01, np.radians(1.0)
"""The first samples [m, rad]: from one to the next solve_ik stays on its branch where it can."""

LONGEST_JUMP = 0.5
"""A joint that moves farther [rad, m] between two samples calls for samples in between."""

UNMET = 8
"""Where a sample has no answer, others are tried back to so small a part of the step."""

FINEST = 2**-12
"""Samples are no nearer together than this in s; a path that needs them nearer does not continue."""

EXACT = 1e-9
"""Samples meet the curve to this [m, rad], so that the spline through them is smooth."""

MOST_SAMPLES = 4096

MOST_CHECKS = 20_000

ROUNDS = 12
"""Halvings of intervals in which the tool is too far from the curve."""

PULLS = (0.0, 0.05, 0.3)
"""How an arm that is left free is drawn to the middle of its joints, one try after the other."""


@dataclass(frozen=True, eq=False)
class Followed:
    """`path`: the joint path, s from 0 to 1 as the curve's; `position_error` [m] and `angle_error` [rad] bound how far
    the tool is from the curve anywhere.
    """

    path: JointPath
    position_error: float
    angle_error: float


@dataclass(frozen=True, eq=False)
class Blocked:
    """The curve was followed to `share` of it, s in [0, 1), with the arm at `theta` (n,); `beyond` is the answer of
    inverse kinematics a little farther on, from there. `jump`: it is met, but only by a leap of the joints.
    """

    share: float
    theta: Array
    beyond: IKSolution
    jump: bool


def follow(arm: Arm, moving: MovingTarget, start: Array) -> Followed | Blocked:
    """The joint path from start (n,), whose tool is at the beginning of the curve, or how far it gets.

    Samples of the curve are solved one after the other, each from the one before; where a joint would move far, or
    there is no answer, halfway first. A cubic spline, C², goes through them, and intervals are halved in which the tool
    may be farther from the curve than `POSITION_TOL` and `ANGLE_TOL`: at check points that is measured, and between
    them it is bounded by the curvature of the tool's path. An arm that is left free moves as little as it can from
    sample to sample, or else, where that is blocked, by so much of the way to the middle of its joints (`PULLS`).
    """
    free = arm.n > 6 or not isinstance(moving.like, Pose)
    farthest: Blocked | None = None
    for pull in PULLS if free else PULLS[:1]:
        result = _pulled(arm, moving, start, pull)
        if isinstance(result, Followed):
            return result
        if farthest is None or result.share > farthest.share:
            farthest = result
    assert farthest is not None
    return farthest


def _pulled(arm: Arm, moving: MovingTarget, start: Array, pull: float) -> Followed | Blocked:
    marched = _marched(arm, moving, start, pull)
    if isinstance(marched, Blocked):
        return marched
    s, theta = marched
    for _ in range(ROUNDS):
        path = spline(s, theta)
        off, position, angle = _deviation(arm, moving, path)
        off |= _outside(arm, path)
        if not off.any():
            return Followed(path, position, angle)
        if len(s) > MOST_SAMPLES:
            break
        between = 0.5 * (s[:-1] + s[1:])[off]
        added = []
        for at in between:
            solution = _solved(arm, moving, float(at), path(at), 0.0)
            if not solution.converged:
                return _blocked(s, theta, float(at), solution, jump=False)
            added.append(solution.theta)
        order = np.argsort(np.concatenate([s, between]), kind="stable")
        s, theta = np.concatenate([s, between])[order], np.concatenate([theta, added])[order]
    worst = int(np.flatnonzero(off)[0])
    ahead = float(s[worst + 1])
    return _blocked(s, theta, ahead, _solved(arm, moving, ahead, theta[worst], 0.0), jump=True)


def spline(s: Array, theta: Array) -> JointPath:
    """The C² cubic spline through theta (k, n) at s (k,), with the third derivative continuous next to the ends."""
    from scipy.interpolate import CubicSpline

    return JointPath(s, np.asarray(CubicSpline(s, theta - theta[0], bc_type="not-a-knot").c) + _constant(theta[0]))


def _constant(theta: Array) -> Array:
    return np.stack([np.zeros_like(theta)] * 3 + [theta])[:, None]


def _marched(arm: Arm, moving: MovingTarget, start: Array, pull: float) -> tuple[Array, Array] | Blocked:
    """Samples (k,) of s and their configurations (k, n), near enough together for no joint to leap."""
    steps = max(4, int(np.ceil(max(moving.curve.length / FIRST_STEP, moving.angle / FIRST_TURN))))
    step = 1.0 / min(steps, MOST_SAMPLES)
    s, thetas, at = [0.0], [start], 0.0
    stride = step
    while at < 1.0:
        ahead = min(at + stride, 1.0)
        if 1.0 - ahead < 0.5 * stride:
            ahead = 1.0
        predicted = thetas[-1]
        if len(s) > 1:
            predicted = predicted + (predicted - thetas[-2]) * ((ahead - at) / (at - s[-2]))
        solution = _solved(arm, moving, ahead, np.clip(predicted, arm.limits.lower, arm.limits.upper), pull)
        leap = float(np.abs(solution.theta - thetas[-1]).max())
        if solution.converged and leap <= LONGEST_JUMP:
            at = ahead
            s.append(at)
            thetas.append(solution.theta)
            stride = min(2.0 * stride, step)
        elif stride > (FINEST if solution.converged else step / UNMET) and len(s) < MOST_SAMPLES:
            stride *= 0.5
        else:
            return _blocked(np.array(s), np.array(thetas), ahead, solution, jump=solution.converged)
    return np.array(s), np.array(thetas)


def _solved(arm: Arm, moving: MovingTarget, s: float, near: Array, pull: float) -> IKSolution:
    posture = near + pull * (arm.limits.middle() - near) if pull else None
    return solve_ik(arm, moving.at(s), near, position_tol=EXACT, orientation_tol=EXACT, restarts=1, posture=posture)


def _blocked(s: Array, theta: Array, ahead: float, solution: IKSolution, *, jump: bool) -> Blocked:
    last = int(np.searchsorted(s, ahead, side="left")) - 1
    return Blocked(float(s[last]), theta[last], solution, jump)


def _deviation(arm: Arm, moving: MovingTarget, path: JointPath) -> tuple[Flags, float, float]:
    """In which pieces (m,) the tool may be too far from the curve, and how far at most anywhere [m, rad].

    Between check points a distance d apart the deviation e, with e'' bounded, is at most the greater of both plus
    d² ‖e''‖ / 8.
    """
    h = np.diff(path.breakpoints)
    bend = deviation_bend(arm, moving, path)
    tolerance = np.array([POSITION_TOL, ANGLE_TOL])
    part = min(float((4.0 * tolerance / np.maximum(bend.max(axis=0), 1e-12)).min()) ** 0.5, 1.0)
    each = np.clip(np.ceil(h / part), 2, max(2, MOST_CHECKS // len(h))).astype(np.int64)
    piece = np.repeat(np.arange(len(h)), each)
    within = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    s = np.append(path.breakpoints[piece] + h[piece] * within / each[piece], path.length)
    position, angle = moving.errors(s, arm.fk(path(s)))
    slack = (h / each) ** 2 / 8.0
    greatest = [
        np.maximum.reduceat(np.maximum(error[:-1], error[1:]), np.cumsum(each) - each) + slack * bend[:, i]
        for i, error in enumerate((position, angle))
    ]
    off = (greatest[0] > POSITION_TOL) | (greatest[1] > ANGLE_TOL)
    return off, float(greatest[0].max()), float(greatest[1].max())


def _outside(arm: Arm, path: JointPath) -> Flags:
    """In which pieces (m,) a joint passes its limit by more than rounding."""
    h = np.diff(path.breakpoints)
    outside: Flags = _beyond(arm, bernstein(path.coefficients, h)) > ROUNDING
    if outside.any():  # the Bernstein coefficients may lie beyond where the spline does not
        outside[outside] = _beyond(arm, extremes(path.coefficients[:, outside], h[outside])[1]) > ROUNDING
    return outside


def _beyond(arm: Arm, values: Array) -> Array:
    beyond: Array = np.maximum(arm.limits.lower - values, values - arm.limits.upper).max(axis=(0, 2))
    return beyond
