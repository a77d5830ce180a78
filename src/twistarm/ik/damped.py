"""One search for an exact answer: damped least squares in the target's own components, inside the joints' bounds.

This is the specification of numeric inverse kinematics; a faster solver has to come to the same verdicts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..arm import Arm
from ..checks import Array
from . import rotation_errors
from .task_space import Rows, Target, excess_rows

ROTATION_WEIGHT = 0.5
"""What a squared radian counts beside a squared metre while an exact answer, where both vanish, is sought."""

DAMPING, LEAST_DAMPING = 0.05, 1e-9
"""λ = DAMPING · E + LEAST_DAMPING: strong far from the target, vanishing with the error E (Chan & Lawrence)."""

MAX_ITERATIONS = 30
PROGRESS, MAX_STALLS = 0.9, 4
"""An iteration that leaves E above PROGRESS times the best so far is a stall; MAX_STALLS of them end a search."""


MARGIN = 0.9
"""A search goes this much below the tolerances, so that the rounding of wrapped angles cannot undo its verdict."""


@dataclass(frozen=True)
class Tolerances:
    """What counts as met: position [m] and orientation [rad]."""

    position: float
    orientation: float

    def met(self, position_error: float, orientation_error: float) -> bool:
        """Whether both errors are within the tolerances."""
        return position_error <= self.position and orientation_error <= self.orientation


@dataclass(frozen=True, eq=False)
class Search:
    """Where one search ended: theta (n,), the weighted squared error E there, the steps it took."""

    theta: Array
    error: float
    iterations: int
    converged: bool


def search(
    arm: Arm,
    target: Target,
    start: Array,
    bounds: tuple[Array, Array],
    tolerances: Tolerances,
    max_iterations: int = MAX_ITERATIONS,
    longest_step: float = math.inf,
) -> Search:
    """Damped least squares from `start` (n,), inside the bounds, which may be infinite; no coordinate steps further
    than `longest_step` [rad, m].

    Each step minimises ‖J d + e‖²_W + λ ‖d‖² over the steps d that stay inside: (Jᵀ W J + λ I) d = −Jᵀ W e on the
    joints that are free. e and J are the target's error and rows (chordal for rotations), W weighs rotations by
    `ROTATION_WEIGHT`, and λ = `DAMPING` · eᵀ W e + `LEAST_DAMPING`. Source: S. K. Chan & P. D. Lawrence, General
    inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    weights = np.repeat([1.0, ROTATION_WEIGHT], [len(target.position_tolerance), len(target.rotation_tolerance)])
    theta, best, stalls, iterations = start, math.inf, 0, 0
    while True:
        g, J_b = arm.fk_and_body_jacobian(theta)
        position, rotation = _excess(target, g, J_b)
        error, J = np.concatenate([position[0], rotation[0]]), np.concatenate([position[1], rotation[1]])
        weighted = weights * error
        E = float(error @ weighted)
        if _met(position[0], rotation[0], tolerances):
            return Search(theta, E, iterations, True)
        if best * PROGRESS < E:
            stalls += 1
        best = min(E, best)
        if stalls == MAX_STALLS or iterations == max_iterations:
            return Search(theta, E, iterations, False)
        H = (J.T * weights) @ J + (DAMPING * E + LEAST_DAMPING) * np.eye(len(theta))
        step = bounded_step(H, J.T @ weighted, theta, bounds) - theta
        share = min(1.0, longest_step / max(float(np.abs(step).max()), LEAST_DAMPING))
        theta = np.clip(theta + share * step, *bounds)
        iterations += 1


def bounded_step(H: Array, gradient: Array, theta: Array, bounds: tuple[Array, Array]) -> Array:
    """theta + d, with d the minimiser of ½ dᵀ H d + gradientᵀ d, kept inside the bounds joint by joint.

    A joint that stands at a bound and is pulled outward is frozen. Where the step of the others passes a bound, it is
    cut there, and the rest is solved again with that joint's motion taken into account: clamping the whole step instead
    would leave the other joints answering to a motion that never happens.
    """
    lower, upper = bounds
    reached: Array = theta.copy()
    free = ~((theta <= lower) & (gradient > 0) | (theta >= upper) & (gradient < 0))
    while free.any():
        held = ~free
        pull = gradient + H[:, held] @ (reached - theta)[held]
        reached[free] = theta[free] - np.linalg.solve(H[np.ix_(free, free)], pull[free])
        outside = free & ((reached < lower) | (reached > upper))
        if not outside.any():
            break
        reached[outside] = np.clip(reached, lower, upper)[outside]
        free &= ~outside
    return reached


def _excess(target: Target, g: Array, J_b: Array) -> tuple[Rows, Rows]:
    return (
        excess_rows(target.position_rows(g, J_b), target.position_tolerance),
        excess_rows(target.rotation_rows(g, J_b), target.rotation_tolerance),
    )


def _met(position: Array, rotation: Array, tolerances: Tolerances) -> bool:
    angle = rotation_errors.angle_of_chord(math.sqrt(rotation @ rotation))
    return tolerances.met(math.sqrt(position @ position) / MARGIN, angle / MARGIN)
