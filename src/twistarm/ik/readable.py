"""The readable solver, start to end: the specification of inverse kinematics, and its engine without a core."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from ..arm import Arm
from ..checks import Array
from .answer import PlainAnswer
from .damped import Search, Tolerances
from .deadline import Deadline
from .nearest import Nearest, nearest
from .posture import toward_posture
from .problem import problem_of
from .race import Race, race
from .ranges import JointRanges, joint_ranges
from .reasons import reason, without_limits
from .request import Request
from .solution import STOPS, StopReason
from .starts import random_start
from .targets import AnyTarget
from .warm import branch_kept, moves_far, near_pose

NEAREST_STARTS = 100
"""Random configurations from which the nearest is looked for, and at most as many ends of searches."""


@dataclass(frozen=True, eq=False)
class Call:
    """One target of one arm, and how it is to be solved; `start` is theta0 inside the limits."""

    arm: Arm
    target: AnyTarget
    start: Array
    ranges: JointRanges
    request: Request
    deadline: Deadline

    @property
    def tolerances(self) -> Tolerances:
        """What counts as met."""
        return self.request.tolerances


@dataclass(frozen=True, eq=False)
class End:
    """Where a solver came to rest, and why."""

    theta: Array
    stop: StopReason
    iterations: int
    nearest: bool = False
    unlimited: Array | None = None
    other_branch: bool = False


def solve(arm: Arm, target: AnyTarget, request: Request) -> PlainAnswer:
    """The answer to one target: an exact one where there is one; else the nearest, and the reason."""
    ranges = joint_ranges(arm)
    start = ranges.inside(request.theta0)
    call = Call(arm, target, start, ranges, request, Deadline.after(request.max_time))
    outcome = race(
        arm,
        target,
        start,
        ranges,
        request.tolerances,
        restarts=request.restarts,
        seed=request.seed,
        deadline=call.deadline,
    )
    end = _failed(call, outcome) if outcome.winner is None else _met(call, outcome.winner)
    return _answer(call, end, len(outcome.searches))


def _met(call: Call, winner: Search) -> End:
    """The winner, brought back to theta0's branch where it left it, and toward the posture where one is preferred."""
    theta, iterations, other_branch = call.ranges.wrapped(winner.theta, call.start), winner.iterations, False
    if moves_far(theta, call.start) and near_pose(call.arm, call.target, call.start):
        kept = branch_kept(call.arm, call.target, call.start, call.ranges, call.tolerances)
        if kept is not None:
            theta, iterations = kept.theta, kept.iterations
        other_branch = moves_far(theta, call.start)
    if call.request.posture is not None:
        problem = problem_of(call.arm, call.target, call.ranges.lower, call.ranges.upper)
        theta = call.ranges.wrapped(theta, call.request.posture)
        theta = toward_posture(problem, theta, call.request.posture, call.tolerances, call.deadline)
    return End(theta, StopReason.CONVERGED, iterations, other_branch=other_branch)


def _failed(call: Call, outcome: Race) -> End:
    steps = sum(search.iterations for search in outcome.searches)
    ends = [call.ranges.wrapped(search.theta, call.start) for search in outcome.searches]
    if call.deadline.passed:
        best = min(ends, key=partial(_distance, call))
        return End(best, StopReason.TIMED_OUT, steps)
    found = _nearest(call, outcome)
    theta, errors = found.theta, _errors(call, found.theta)
    if call.deadline.passed:
        # Cut short, it may be further away than where a search of the race has been.
        theta = min((theta, *ends), key=partial(_distance, call))
        return End(theta, StopReason.TIMED_OUT, steps, nearest=True)
    if call.tolerances.met(*errors):
        return End(theta, StopReason.CONVERGED, steps, nearest=True)
    unlimited = without_limits(call.arm, call.target, theta, call.tolerances, call.request.seed, call.deadline)
    if call.deadline.passed:
        return End(theta, StopReason.TIMED_OUT, steps, nearest=True)
    if unlimited is not None:
        return End(theta, StopReason.BLOCKED_BY_LIMITS, steps, nearest=True, unlimited=unlimited)
    # How far a position is out of reach does not hang on the rotation there.
    decided = found.rotation_stationary or errors[0] > call.tolerances.position
    if not (found.position_stationary and decided):
        return End(theta, StopReason.EXHAUSTED, steps, nearest=True)
    return End(theta, reason(call.arm, call.target, call.tolerances, *errors), steps, nearest=True)


def _nearest(call: Call, outcome: Race) -> Nearest:
    """The nearest configuration, looked for from the ends of the searches that failed and from random starts."""
    ranges = call.ranges
    starts = [search.theta for search in outcome.searches[:NEAREST_STARTS]]
    starts += [random_start(ranges, call.request.seed, k) for k in range(NEAREST_STARTS)]
    problem = problem_of(call.arm, call.target, ranges.search_lower, ranges.search_upper)
    found = nearest(problem, starts, call.tolerances, call.deadline)
    return found._replace(theta=ranges.wrapped(found.theta, call.start))


def _errors(call: Call, theta: Array) -> tuple[float, float]:
    g = call.arm.fk(theta)
    return call.target.position_error(g), call.target.orientation_error(g)


def _distance(call: Call, theta: Array) -> tuple[float, float]:
    """How far theta is from the target: the position first, where it is not met, then the rotation."""
    position, orientation = _errors(call, theta)
    return 0.0 if position <= call.tolerances.position else position, orientation


def _answer(call: Call, end: End, searches: int) -> PlainAnswer:
    """The end as an answer, judged anew by the arm's forward kinematics."""
    errors = _errors(call, end.theta)
    stop = StopReason.EXHAUSTED if end.stop is StopReason.CONVERGED else end.stop
    given = call.request.theta0
    return PlainAnswer(
        kind=call.target.kind,
        numbers=call.target.numbers.tobytes(),
        theta0=given.tobytes(),
        position_tol=call.tolerances.position,
        orientation_tol=call.tolerances.orientation,
        theta=end.theta.tobytes(),
        unlimited=None if end.unlimited is None else end.unlimited.tobytes(),
        position_error=errors[0],
        orientation_error=errors[1],
        iterations=end.iterations,
        restarts=searches,
        stop=STOPS.index(StopReason.CONVERGED if call.tolerances.met(*errors) else stop),
        nearest=end.nearest,
        other_branch=end.other_branch,
        start_moved=bool((given != call.start).any()),
    )
