"""Where a redundant arm stands while it meets a target: as near to a preferred posture as its null space lets it."""

from __future__ import annotations

import numpy as np

from ..checks import Array
from .damped import Tolerances
from .deadline import Deadline
from .newton import Model, derivative, descend, positive, resting
from .problem import Problem
from .quadratic import least_quadratic, null_space

DIFFERENCE = 1e-5
"""Step [rad, m] of the differences that make the Hessian of the Lagrangian."""

HELD = 1e-10
"""How far [m, rad] a step back onto the target may leave it."""

RETURNS = 8
"""Gauss–Newton steps back onto the target."""


def toward_posture(problem: Problem, theta: Array, posture: Array, tolerances: Tolerances, deadline: Deadline) -> Array:
    """A minimum of ‖θ − posture‖² among the configurations inside the bounds that meet the target, downhill from theta.

    Newton's steps on ½ ‖θ − posture‖² + yᵀ e in the null space of the target's rows; theta must meet the target, and is
    the answer where nothing nearer does. Source: J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., ch. 18.
    """
    n = problem.arm.n
    start = _back(problem, problem.start(theta))
    if start is None:
        return theta

    def away(x: Array) -> Array:
        return np.concatenate([x[:n] - posture, np.zeros(len(x) - n)])

    def distance(x: Array) -> float:
        return 0.5 * float(away(x) @ away(x))

    def model(x: Array) -> Model:
        _, rows = _rows(problem, x)
        lower, upper = problem.lower - x, problem.upper - x
        downhill, multipliers = least_quadratic(np.eye(len(x)), away(x), rows, lower, upper)
        rests = resting(downhill, lower, upper)
        along = null_space(np.vstack([rows, np.eye(len(x))[rests]]))
        curved = derivative(lambda x: away(x) + _rows(problem, x)[1].T @ multipliers, x, DIFFERENCE)
        box = np.where(rests, 0.0, lower), np.where(rests, 0.0, upper)
        return Model(away(x), positive(curved, along), rows, *box, float(np.abs(downhill).max()))

    x, _ = descend(start, distance, model, lambda x, _: _back(problem, x), lambda: deadline.passed)
    g = problem.arm.fk(x[:n])
    met = tolerances.met(problem.target.position_error(g), problem.target.orientation_error(g))
    nearer = distance(x) < 0.5 * float((theta - posture) @ (theta - posture))
    return x[:n] if met and nearer else theta


def _rows(problem: Problem, x: Array) -> tuple[Array, Array]:
    """Errors of position and rotation less their slack, and their rows."""
    (e_p, J_p), (e_r, J_r) = problem.position(x), problem.rotation(x)
    return np.concatenate([e_p, e_r]), np.concatenate([J_p, J_r])


def _back(problem: Problem, x: Array) -> Array | None:
    """x moved onto the target inside the bounds; None where that does not succeed."""
    x = np.clip(x, problem.lower, problem.upper)
    for _ in range(RETURNS):
        error, rows = _rows(problem, x)
        if np.abs(error).max(initial=0.0) <= HELD:
            return x
        free = (problem.lower < x) & (x < problem.upper)
        step = np.zeros_like(x)
        step[free] = -np.linalg.pinv(rows[:, free]) @ error
        x = np.clip(x + step, problem.lower, problem.upper)
    return None
