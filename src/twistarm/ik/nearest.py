"""The nearest a target can be met: the least position error, and with the position held, the least rotation error.

Both are minimised inside the bounds by Newton's method on the joints that are free. The position is held not by a
weight but by moving along the configurations that have it, so metres are never traded for radians.
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

import numpy as np

from ..checks import Array
from .damped import Tolerances, search
from .deadline import Deadline
from .newton import STATIONARY, Model, derivative, descend, positive, resting
from .problem import PositionAlone, Problem
from .quadratic import least_quadratic, null_space
from .ranges import Mask

EXACT = 1e-11
"""A position error [m] below this, or a rotation error [rad], is zero to the rounding of forward kinematics."""

PINNED = 1e-6
"""A joint at a bound pins the position if leaving it would change the distance by more than this per rad or m."""

FLAT, SOFT = 1e-9, 1e-6
"""Curvatures of ½ distance² below FLAT, relative to the largest or to 1 m², are flat, to the rounding of differences.
Between the two the position is held by its fourth derivative, as by a wrist stretched in two ways at once: multipliers
mean nothing there, and the direction itself is known to some 1e-4."""

STIFF = 0.01
"""Curvatures above this share of the largest are the walls of a valley; a step along its floor is led down them."""

SOFT_STATIONARY = 1e-5
"""Slope up to which a point is stationary where such a direction is mixed into the others."""

DIFFERENCE = 1e-5
"""Step [rad, m] of the differences of exact gradients that make a Hessian, right to some 1e-10."""

CURVATURE_DIFFERENCE = 1e-4
"""The same where the gradient is itself a difference, and its rounding larger."""

SAME_POSITION = 1e-8
"""Two minima whose distances [m] differ by less are equally near: the rotation decides."""

POLISHED, REFINED = 32, 32
"""How many configurations, the most promising first, have their distance minimised, and how many their rotation."""


class Nearest(NamedTuple):
    """The nearest configuration (n,), and whether each of its errors is stationary there."""

    theta: Array
    position_stationary: bool
    rotation_stationary: bool


def nearest(problem: Problem, starts: list[Array], tolerances: Tolerances, deadline: Deadline) -> Nearest:
    """The best minimum that the starts (n,) lead to: the least distance, and among equals the least rotation error."""
    placed: list[tuple[float, float, Array, bool]] = []
    for theta in promising(problem, starts, tolerances, deadline):
        x, stationary = least_position(problem, problem.start(theta), deadline)
        placed.append((problem.distance(x), problem.turn(x), x, stationary))
        if deadline.passed:
            break
    least = min(distance for distance, *_ in placed)
    equals = sorted((p for p in placed if p[0] <= least + SAME_POSITION), key=lambda p: p[1])
    turned: list[tuple[float, Nearest]] = []
    for _, _, x, position_stationary in equals[:REFINED]:
        x, rotation_stationary = least_rotation(problem, x, deadline)
        theta = x[: problem.arm.n]
        turned.append((problem.turn(x), Nearest(theta, position_stationary, rotation_stationary)))
        if turned[-1][0] <= EXACT or deadline.passed:
            break
    return min(turned, key=lambda t: t[0])[1]


def promising(problem: Problem, starts: list[Array], tolerances: Tolerances, deadline: Deadline) -> list[Array]:
    """The `POLISHED` best configurations after a damped search for the position alone from every start.

    Where the position is met from somewhere, these are configurations that meet it, with the least rotation errors
    first; else those that come nearest to it.
    """
    alone = PositionAlone(problem.target)
    bounds = problem.lower[: problem.arm.n], problem.upper[: problem.arm.n]
    ranked: list[tuple[bool, float, Array]] = []
    for start in starts:
        ended = search(problem.arm, alone, start, bounds, tolerances)
        x = problem.start(ended.theta)
        ranked.append((not ended.converged, problem.turn(x) if ended.converged else ended.error, ended.theta))
        if deadline.passed:
            break
    ranked.sort(key=lambda entry: entry[:2])
    return [theta for _, _, theta in ranked[:POLISHED]]


def least_position(problem: Problem, x: Array, deadline: Deadline) -> tuple[Array, bool]:
    """The minimum of the distance [m] inside the bounds that x leads to, and whether it is stationary.

    Minimises f = ½ ‖e‖², ∇f = Jᵀ e, with the whole Hessian: where the target is out of reach, Jᵀ J alone is singular,
    and the curvature of the arm's reach decides.
    """

    def retract(x: Array, m: Model) -> Array:
        across = np.linalg.pinv(m.hessian, rcond=STIFF, hermitian=True)
        down = np.clip(x - across @ problem.position_slope(x), problem.lower, problem.upper)
        return min((x, down), key=problem.distance)

    return descend(x, problem.distance, lambda x: _position_model(problem, x), retract, lambda: deadline.passed)


def _position_model(problem: Problem, x: Array) -> Model:
    slope, distance = problem.position_slope(x), problem.distance(x)
    box = problem.lower - x, problem.upper - x
    nothing = np.zeros((0, len(x)))
    if distance <= EXACT:
        return Model(slope, np.eye(len(x)), nothing, *box, 0.0)
    downhill = least_quadratic(np.eye(len(x)), slope / distance, nothing, *box).d
    rests = resting(downhill, *box)
    hessian = positive(derivative(problem.position_slope, x, DIFFERENCE), np.eye(len(x))[:, ~rests])
    return Model(slope, hessian, nothing, *_held(rests, *box), _largest(downhill))


def least_rotation(problem: Problem, x: Array, deadline: Deadline) -> tuple[Array, bool]:
    """The minimum of the rotation error that x leads to, among the configurations as far from the position as x is.

    x must be a minimum of the distance. Those configurations satisfy ∇f = 0, f = ½ distance², so they lie along the
    flat directions of f's Hessian: the null space of J where the position is met, and less than that where it is not,
    for a stretched elbow may not bend.
    """
    distance = problem.distance(x)

    def retract(x: Array, _: Model) -> Array | None:
        for within in (problem.holding_bounds(x), problem):
            back, _stationary = least_position(within, np.clip(x, within.lower, within.upper), deadline)
            if problem.distance(back) <= distance + EXACT:
                return back
        return None

    if not len(problem.target.rotation_tolerance):
        return x, True
    model = partial(_rotation_model, problem, distance)
    return descend(x, problem.turn, model, retract, lambda: deadline.passed)


def _rotation_model(problem: Problem, distance: float, x: Array) -> Model:
    """Newton's model along ∇f = 0: its Hessian is that of the Lagrangian, rotation + zᵀ ∇f, with the multipliers z."""
    lower, upper = problem.lower - x, problem.upper - x
    pinned = _pinned(problem.position_slope(x), distance, lower, upper)
    lower, upper = _held(pinned, lower, upper)
    curvature, directions = _curved(derivative(problem.position_slope, x, DIFFERENCE), ~pinned)
    slope, turn = problem.rotation_slope(x), problem.turn(x)
    if turn <= EXACT:
        return Model(slope, np.eye(len(x)), directions, lower, upper, 0.0)
    downhill, multipliers = least_quadratic(np.eye(len(x)), slope / turn, directions, lower, upper)
    z = directions.T @ np.where(np.abs(curvature) > SOFT, turn * multipliers / curvature, 0.0)
    t = CURVATURE_DIFFERENCE / max(1.0, _norm(z))

    def lagrangian(x: Array) -> Array:
        bent = (problem.position_slope(x + t * z) - problem.position_slope(x - t * z)) / (2.0 * t)
        return problem.rotation_slope(x) + bent

    rests = pinned | resting(downhill, lower, upper)
    along = null_space(np.vstack([directions, np.eye(len(x))[rests]]))
    hessian = positive(derivative(lagrangian, x, CURVATURE_DIFFERENCE), along)
    enough = SOFT_STATIONARY if (np.abs(curvature) <= SOFT).any() else STATIONARY
    return Model(slope, hessian, directions, *_held(rests, lower, upper), _largest(downhill), enough)


def _pinned(slope: Array, distance: float, lower: Array, upper: Array) -> Mask:
    """Joints at a bound that hold the position away from the target."""
    if distance <= EXACT:
        return np.zeros(len(slope), dtype=np.bool_)
    pull = slope / distance
    pinned: Mask = (lower >= 0) & (pull > PINNED) | (upper <= 0) & (pull < -PINNED)
    return pinned


def _curved(H: Array, free: Mask) -> tuple[Array, Array]:
    """Curvatures (k,) of H on the free joints that are not flat, and their directions (k, n), of length 1."""
    curvature, vectors = np.linalg.eigh(H[np.ix_(free, free)])
    kept = np.abs(curvature) > FLAT * float(np.abs(curvature).max(initial=1.0))
    directions = np.zeros((int(kept.sum()), len(free)))
    directions[:, free] = vectors[:, kept].T
    return curvature[kept], directions


def _held(joints: Mask, lower: Array, upper: Array) -> tuple[Array, Array]:
    """The box of steps in which some joints stay where they are."""
    return np.where(joints, 0.0, lower), np.where(joints, 0.0, upper)


def _largest(step: Array) -> float:
    return float(np.abs(step).max())


def _norm(error: Array) -> float:
    return math.sqrt(error @ error)
