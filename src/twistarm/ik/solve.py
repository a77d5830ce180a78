"""`solve_ik`: an exact answer where there is one; where there is none, the nearest and the reason."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm
from ..checks import Array, as_floats, as_theta
from ..errors import InputError
from .damped import Tolerances
from .deadline import Deadline
from .nearest import nearest
from .problem import problem_of
from .race import Race, race
from .ranges import JointRanges, joint_ranges
from .reasons import reason, without_limits
from .solution import IKSolution, StopReason
from .starts import as_seed, random_start
from .targets import as_target
from .task_space import Target

LEAST_TOLERANCE = 1e-12
"""Below this a tolerance asks for more digits than forward kinematics has."""

NEAREST_STARTS = 100
"""Random configurations from which the nearest is looked for, and at most as many ends of searches."""

DAMPED, NEAREST = "damped least squares", "nearest configuration"


@dataclass(frozen=True, eq=False)
class Request:
    """One call of `solve_ik`, checked."""

    arm: Arm
    target: Target
    theta0: Array
    ranges: JointRanges
    tolerances: Tolerances
    restarts: int
    seed: int
    deadline: Deadline
    notes: tuple[str, ...]


def solve_ik(
    arm: Arm,
    target: Any,
    theta0: ArrayLike | None = None,
    *,
    position_tol: float = 1e-6,
    orientation_tol: float = 1e-6,
    restarts: int = 100,
    max_time: float | None = None,
    rng: int | np.random.Generator = 0,
) -> IKSolution:
    """Inverse kinematics: joint coordinates inside the limits that bring the tool to `target`.

    `target`: Pose, Position, Approach or Task; a bare (4, 4) means Pose. `theta0` (n,), by default `arm.ready`, is
    where the search begins; it is brought inside the limits first. Joints that may turn for ever come back as near to
    it as the limits allow. Tolerances in m and rad. At most `restarts` searches, the first from theta0, the others
    from random starts that depend on the seed `rng` and their number alone: the same call gives the same bits, unless
    `max_time` [s] cuts it short.

    A target that cannot be met is no error: the solution is then the nearest configuration (the least position error
    inside the limits, then the least rotation error with the position held), `stop` says why, `explain()` says it
    in words. Raises InputError for what cannot be a target, a start or a tolerance.
    """
    request = _checked(arm, target, theta0, position_tol, orientation_tol, restarts, max_time, rng)
    outcome = race(
        arm,
        request.target,
        request.theta0,
        request.ranges,
        request.tolerances,
        restarts=request.restarts,
        seed=request.seed,
        deadline=request.deadline,
    )
    if outcome.winner is not None:
        return _solution(request, outcome, outcome.winner.theta, DAMPED, StopReason.EXHAUSTED)
    if request.deadline.passed:
        best = min((search.theta for search in outcome.searches), key=partial(_distance, request))
        return _solution(request, outcome, best, DAMPED, StopReason.TIMED_OUT)
    return _nearest(request, outcome)


def _nearest(request: Request, outcome: Race) -> IKSolution:
    """The nearest configuration, looked for from the ends of the searches that failed and from random starts."""
    ranges = request.ranges
    starts = [search.theta for search in outcome.searches[:NEAREST_STARTS]]
    starts += [random_start(ranges, request.seed, k) for k in range(NEAREST_STARTS)]
    problem = problem_of(request.arm, request.target, ranges.search_lower, ranges.search_upper)
    found = nearest(problem, starts, request.tolerances, request.deadline)
    theta = found.theta
    if request.deadline.passed:
        # Cut short, it may be further away than where a search of the race has been.
        theta = min((theta, *(search.theta for search in outcome.searches)), key=partial(_distance, request))
    solution = _solution(request, outcome, theta, NEAREST, StopReason.EXHAUSTED)
    if solution.converged:
        return solution
    unlimited = without_limits(
        request.arm, request.target, solution.theta, request.tolerances, request.seed, request.deadline
    )
    if unlimited is not None and not request.deadline.passed:
        return replace(solution, stop=StopReason.BLOCKED_BY_LIMITS, unlimited=unlimited)
    if request.deadline.passed:
        return replace(solution, stop=StopReason.TIMED_OUT)
    errors = solution.position_error, solution.orientation_error
    # How far a position is out of reach does not hang on the rotation there.
    decided = found.rotation_stationary or errors[0] > request.tolerances.position
    if not (found.position_stationary and decided):
        return solution
    return replace(solution, stop=reason(request.arm, request.target, request.tolerances, *errors))


def _distance(request: Request, theta: Array) -> tuple[float, float]:
    """How far theta is from the target: the position first, where it is not met, then the rotation."""
    g = request.arm.fk(theta)
    position = request.target.position_error(g)
    return 0.0 if position <= request.tolerances.position else position, request.target.orientation_error(g)


def _solution(request: Request, outcome: Race, theta: Array, method: str, stop: StopReason) -> IKSolution:
    """The solution at theta, judged anew by the arm's forward kinematics; `stop` where it does not meet the target."""
    theta = request.ranges.wrapped(theta, request.theta0)
    g = request.arm.fk(theta)
    errors = request.target.position_error(g), request.target.orientation_error(g)
    met = request.tolerances.met(*errors)
    searches = outcome.searches if outcome.winner is None else (outcome.winner,)
    return IKSolution(
        theta=theta,
        position_error=errors[0],
        orientation_error=errors[1],
        within_limits=bool(request.arm.limits.contains(theta)),
        iterations=sum(search.iterations for search in searches),
        restarts=len(outcome.searches),
        method=method,
        notes=request.notes,
        stop=StopReason.CONVERGED if met else stop,
        arm=request.arm,
        target=request.target,
        tolerances=request.tolerances,
    )


def _checked(
    arm: Arm,
    target: Any,
    theta0: ArrayLike | None,
    position_tol: float,
    orientation_tol: float,
    restarts: int,
    max_time: float | None,
    rng: int | np.random.Generator,
) -> Request:
    if not isinstance(arm, Arm):
        raise InputError(f"arm must be an Arm, as load_arm returns it; got {type(arm).__name__}")
    ranges = joint_ranges(arm)
    start, notes = _start(arm, ranges, theta0)
    if isinstance(restarts, bool) or not isinstance(restarts, (int, np.integer)) or restarts < 1:
        raise InputError(f"restarts must be a whole number, at least 1 (the search from theta0); got {restarts!r}")
    return Request(
        arm=arm,
        target=as_target(target),
        theta0=start,
        ranges=ranges,
        tolerances=Tolerances(
            _tolerance(position_tol, "position_tol [m]"), _tolerance(orientation_tol, "orientation_tol [rad]")
        ),
        restarts=int(restarts),
        seed=as_seed(rng),
        deadline=Deadline.after(_seconds(max_time)),
        notes=notes,
    )


def _start(arm: Arm, ranges: JointRanges, theta0: ArrayLike | None) -> tuple[Array, tuple[str, ...]]:
    """theta0 inside the limits, and a note for every joint that had to move."""
    if theta0 is None:
        return arm.ready, ()
    given = as_theta(theta0, arm.n, "theta0", arm.joint_names)
    if given.ndim != 1:
        raise InputError(f"theta0 must be one configuration of shape ({arm.n},); got {given.shape}")
    start = ranges.inside(given)
    moved = [
        f"theta0 lay outside the limits: {name} {was:.4g} {unit} was brought inside, to {now:.4g} {unit}"
        for name, was, now, unit in zip(arm.joint_names, given, start, arm.units, strict=True)
        if was != now
    ]
    return start, tuple(moved)


def _tolerance(value: float, name: str) -> float:
    number = as_floats(value, name)
    if number.ndim or not number >= LEAST_TOLERANCE:
        raise InputError(f"{name} must be one number, at least {LEAST_TOLERANCE:g}; got {value!r}")
    return float(number)


def _seconds(value: float | None) -> float | None:
    if value is None:
        return None
    number = as_floats(value, "max_time [s]")
    if number.ndim or not number > 0:
        raise InputError(f"max_time must be a positive number of seconds, or None for no limit; got {value!r}")
    return float(number)
