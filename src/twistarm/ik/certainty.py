"""Certainty: what the closed form says about a target that no search has reached.

Searches may miss a configuration, and cannot prove that no configuration exists. An arm's closed form in the core
answers in some microseconds. It also proves, where the axes are exact and no joint is sampled.
"""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..arm.engine import answered
from ..support.checks import Array
from .answer import CONVERGED, NOT_FINISHED, STOPS, Configurations, Record, StopReason, fill, record_type
from .closed_form.methods import Method, family_for
from .ranges import joint_ranges
from .targets import AnyTarget
from .task_space import EXACT_TOL, Tolerances

TIMED_OUT, BLOCKED = STOPS.index(StopReason.TIMED_OUT), STOPS.index(StopReason.BLOCKED_BY_LIMITS)

OTHER_SEED = 0x5EED  # Of the searches after which limits are the reason.
SAMPLES = 5  # Values tried for a joint that the target does not determine, its bounds included.
# Error [m, rad] of the nearest configuration for certainty that no configuration reaches the target exactly.
FAR = 1e-5
BARELY_OUTSIDE = 1e-4  # A configuration outside the limits by less than this [rad, m] proves nothing.


def decided(arm: Arm, target: AnyTarget, missed: Record, has_time: bool) -> Record:
    """An answer that the closed form has corrected, or `missed` itself.

    It may give a configuration after all. If that lies outside the limits, these are the reason. The answer is
    `certain` if the closed form proves that nothing inside the limits reaches the target exactly. An answer that
    converged, or was not finished in time, does not change. Nor does that of one search: its caller wants its result.
    Without a closed form, other searches must find nothing before limits are the reason. `has_time`: there is time for
    them.
    """
    if missed["stop"] in (CONVERGED, TIMED_OUT, NOT_FINISHED) or missed["restarts"] <= 1:
        return missed
    method, start = family_for(arm, target), np.array(missed["theta0"])
    exact = Tolerances(float(missed["position_tol"]), float(missed["orientation_tol"])).at_most(EXACT_TOL)
    if method is None or method.core is None:
        return _searched_again(arm, target, missed) if has_time and missed["stop"] == BLOCKED else missed
    held = _held_values(arm, method, start)
    found = Configurations(*answered(method.core.solve(target.numbers, start, held, exact.position, exact.orientation)))
    answer = missed.copy()
    if found.inside:
        g = arm.fk(found.theta[0])
        fill(
            answer, theta=found.theta[0], position_error=target.position_error(g),
            orientation_error=target.orientation_error(g), stop=STOPS.index(StopReason.CONVERGED),
            by_closed_form=True, has_unlimited=False, nearest=False, other_branch=False,
        )  # fmt: skip
    else:
        outside = joint_ranges(arm).toward_middle(found.theta)
        beyond = np.abs(outside - np.clip(outside, arm.limits.lower, arm.limits.upper))
        if len(outside):
            _blame_limits(arm, target, answer, outside[np.argmin(np.square(beyond).sum(axis=1))])
        proves = method.exact and not method.sampled and not found.left
        nearly = beyond.max(axis=1, initial=0.0).min(initial=np.inf) <= BARELY_OUTSIDE
        if proves and not nearly and max(answer["position_error"], answer["orientation_error"]) > FAR:
            answer["certain"] = True
    return answer


def _searched_again(arm: Arm, target: AnyTarget, missed: Record) -> Record:
    """An answer that reaches the target after all, or `missed`. A root at a corner of the limits has a small basin."""
    assert arm.compiled is not None, "the core has answered"
    # Another seed: the same one would repeat the searches that found nothing.
    how = float(missed["position_tol"]), float(missed["orientation_tol"]), int(missed["restarts"]), OTHER_SEED
    again = arm.compiled.solve(target.kind, target.numbers, np.array(missed["theta0"]), *how, None, None)
    return np.ndarray((), record_type(arm.n), again[1]) if again is not None and again[0] == CONVERGED else missed


def _held_values(arm: Arm, method: Method, start: Array) -> Array | None:
    """Values (k, h) of the joints that the closed form holds. None to hold them at the start."""
    if not method.sampled:
        return None
    values = np.tile(np.clip(start, arm.limits.lower, arm.limits.upper), (SAMPLES, 1))
    lower, upper = arm.sampling_bounds
    for i in method.sampled:
        values[:, i] = np.linspace(lower[i], upper[i], SAMPLES)
    return np.ascontiguousarray(values[:, list(method.held)])


def _blame_limits(arm: Arm, target: AnyTarget, answer: Record, theta: Array) -> None:
    """Name the limits with a configuration outside them, unless the answer has one that reaches the whole target."""
    tolerances = Tolerances(float(answer["position_tol"]), float(answer["orientation_tol"]))
    known = arm.fk(answer["unlimited"])
    if answer["has_unlimited"] and tolerances.converged(target.position_error(known), target.orientation_error(known)):
        return
    fill(answer, unlimited=theta, stop=BLOCKED, has_unlimited=True)
