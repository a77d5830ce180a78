"""Inverse kinematics by the textbook: damped least squares inside the limits, start after start.

It works without a compiled core. It returns a configuration that reaches the target, or the best found. Only the core
is fast and finds the nearest configuration and the reason: docs/inverse_kinematics.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from .answer import STOPS, Record, StopReason, fill, record_type
from .ranges import JointRanges, joint_ranges
from .request import Deadline, Request
from .targets import AnyTarget
from .task_space import EXACT_TOL, Tolerances, excess_rows

# Weight of a squared radian relative to the squared reach in the error E, which is 0 at an answer.
ROTATION_WEIGHT = 0.2
# λ = DAMPING · E + LEAST_DAMPING: strong far from the target, vanishing with the error (Chan & Lawrence).
DAMPING, LEAST_DAMPING = 0.03, 1e-9
POLISHED_TOL = 1e-9  # Errors [m, rad] below which a search stops.

ITERATIONS = 30
# An iteration that leaves E above PROGRESS times the best is a stall. A search ends after STALLS of them.
PROGRESS, STALLS = 0.8, 4
# Up to here [reaches, rad] a target is near the pose of theta0, ...
NEAR_POSITION, NEAR_ORIENTATION = 0.02, math.radians(3.0)
OTHER_BRANCH = 0.2  # ... and an answer that moves a coordinate by more than this [rad, m] is on another branch.


class Search(NamedTuple):
    """The end of a search (n,), its errors [m, rad], its steps, and whether it is an answer."""

    theta: Array
    errors: tuple[float, float]
    iterations: int
    converged: bool


class Problem(NamedTuple):
    """An arm, its joint ranges, a target, and the tolerances."""

    arm: Arm
    ranges: JointRanges
    target: AnyTarget
    tolerances: Tolerances


def solve(arm: Arm, target: AnyTarget, request: Request) -> Record:
    """At most `request.restarts` searches, the first from theta0, the others from random configurations.

    The first search that reaches the target exactly answers. Otherwise the best of them answers: one within the
    tolerances first, then the position counts, then the rotation.
    """
    problem = Problem(arm, joint_ranges(arm), target, request.tolerances)
    deadline, rng = Deadline.after(request.max_time), np.random.default_rng(request.seed)
    start = problem.ranges.inside(request.theta0)
    found = best = search(problem, start, start)
    searches, steps = 1, found.iterations
    exact = problem.tolerances.at_most(EXACT_TOL)
    while not exact.converged(*found.errors) and searches < request.restarts and not deadline.passed:
        found = search(problem, arm.random_theta(rng), start)
        best = min(best, found, key=lambda end: _preference(problem, end))
        searches, steps = searches + 1, steps + found.iterations
    timed_out = deadline.passed and searches < request.restarts
    stop = StopReason.CONVERGED if best.converged else StopReason.TIMED_OUT if timed_out else StopReason.EXHAUSTED
    accepted = request.tolerances
    answer = np.zeros((), record_type(arm.n))
    answer["numbers"][: target.numbers.size] = target.numbers.ravel()
    fill(
        answer, theta=best.theta, position_error=best.errors[0], orientation_error=best.errors[1],
        stop=STOPS.index(stop), iterations=best.iterations if best.converged else steps, restarts=searches,
        other_branch=best.converged and _leaves_branch(problem, start, best.theta),
        start_moved=bool((request.theta0 != start).any()),
        theta0=request.theta0, kind=target.kind, position_tol=accepted.position, orientation_tol=accepted.orientation,
    )  # fmt: skip
    return answer


def search(problem: Problem, theta: Array, near: Array) -> Search:
    """Damped least squares from theta (n,) on. Whole turns of the end are taken back to be near `near` (n,).

    Each step d minimises ‖J d + e‖² + λ ‖d‖², so (JᵀJ + λ I) d = −Jᵀe. Joints at a bound that are pulled outward rest.
    theta + d is clipped to the bounds. In e and J rotations are weighed by √ROTATION_WEIGHT reaches.
    Source: S. K. Chan & P. D. Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    ranges, target = problem.ranges, problem.target
    # Joints that turn freely are wrapped at the end; clipped on the way they would stop at a bound that means nothing.
    lower, upper = np.where(ranges.turns, [[-np.inf], [np.inf]], [ranges.lower, ranges.upper])
    weight = math.sqrt(ROTATION_WEIGHT) * problem.arm.reach
    theta, best, stalls, iterations = np.clip(theta, lower, upper), math.inf, 0, 0
    polished = problem.tolerances.at_most(POLISHED_TOL)
    while True:
        g, J_b = problem.arm.fk_and_body_jacobian(theta)
        errors = target.position_error(g), target.orientation_error(g)
        e_p, J_p = excess_rows(target._position_rows(g, J_b), target._position_tolerance)
        e_r, J_r = excess_rows(target._rotation_rows(g, J_b), target._rotation_tolerance)
        error, J = np.append(e_p, weight * e_r), np.vstack([J_p, weight * J_r])
        E = float(error @ error)
        stalls += PROGRESS * best < E
        best = min(best, E)
        if polished.converged(*errors) or stalls == STALLS or iterations == ITERATIONS:
            break
        slope = J.T @ error
        free = ~((theta <= lower) & (slope > 0) | (theta >= upper) & (slope < 0))
        d = np.zeros_like(theta)
        damping = (DAMPING * E + LEAST_DAMPING * problem.arm.reach**2) * np.eye(int(free.sum()))
        d[free] = np.linalg.solve(J[:, free].T @ J[:, free] + damping, -slope[free])
        theta = np.clip(theta + d, lower, upper)
        iterations += 1
    theta = ranges.wrapped(theta, near)
    g = problem.arm.fk(theta)
    errors = target.position_error(g), target.orientation_error(g)
    return Search(theta, errors, iterations, problem.tolerances.converged(*errors))


def _preference(problem: Problem, end: Search) -> tuple[bool, bool, float, float]:
    """A key that sorts ends: reached exactly, reached within the tolerances, the position missed, the rotation."""
    position, orientation = end.errors
    missed = 0.0 if position <= problem.tolerances.position else position
    return not problem.tolerances.at_most(EXACT_TOL).converged(*end.errors), not end.converged, missed, orientation


def _leaves_branch(problem: Problem, start: Array, theta: Array) -> bool:
    """Whether the target is near the pose of `start` (n,), but theta is not near `start`."""
    g = problem.arm.fk(start)
    near = Tolerances(NEAR_POSITION * problem.arm.reach, NEAR_ORIENTATION)
    converged = near.converged(problem.target.position_error(g), problem.target.orientation_error(g))
    return converged and bool(np.abs(theta - start).max() > OTHER_BRANCH)
