"""Certainty: what the closed form says about a target that no search has met.

Searches may miss a configuration, and cannot prove that no configuration exists. An arm's closed form in the core
answers in some microseconds. It also proves, where the axes are exact and no joint is sampled.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from .answer import NOT_FINISHED, STOPS, Answer, StopReason, answer_from
from .closed_form.methods import Method, family_for
from .ranges import joint_ranges
from .targets import AnyTarget
from .task_space import Tolerances

TIMED_OUT = STOPS.index(StopReason.TIMED_OUT)

SAMPLES = 5
"""Values tried for a joint that the target does not determine, its bounds included."""

EXACT_TOLERANCE = 1e-5
"""Greatest tolerances [m, rad] for which the closed form decides. It finds only exact configurations."""

FAR_MISS = 10.0
"""Tolerances by which the nearest configuration must miss for certainty that no configuration meets the target."""

BARELY_OUTSIDE = 1e-4
"""A configuration outside the limits by less than this [rad, m] proves nothing."""


def is_exact(tolerances: Tolerances) -> bool:
    """Whether the closed form knows everything that meets a target within these."""
    return max(tolerances.position, tolerances.orientation) <= EXACT_TOLERANCE


def settled(arm: Arm, target: AnyTarget, answer: Answer) -> Answer:
    """The answer, corrected by the closed form.

    It may give a configuration after all. If that lies outside the limits, these are the reason. The answer is
    `certain` if the closed form proves that nothing inside the limits meets the target. An answer that is met, or was
    not finished in time, comes back unchanged. So does that of one search: a caller of one search wants its result.
    """
    if answer.stop in (0, TIMED_OUT, NOT_FINISHED) or answer.restarts <= 1:
        return answer
    method = family_for(arm, target)
    if method is None or method.compiled is None:
        return answer
    tolerances = float(answer.position_tol), float(answer.orientation_tol)
    start = np.array(answer.theta0)
    found = method.compiled.solve(target.numbers, start, _held_values(arm, method, start), *tolerances)
    if found is None:
        return answer
    revised = answer_from(partial(getattr, answer))
    if found.inside:
        revised = _met_answer(arm, target, revised, found.theta[0])
    else:
        outside = joint_ranges(arm).toward_middle(found.theta)
        beyond = np.abs(outside - np.clip(outside, arm.limits.lower, arm.limits.upper))
        if len(outside):
            revised = _with_limits_blamed(arm, target, revised, outside[np.argmin(np.square(beyond).sum(axis=1))])
        exact = method.exact and not method.swept and not found.left
        if (
            exact
            and beyond.max(axis=1, initial=0.0).min(initial=np.inf) > BARELY_OUTSIDE
            and _is_far_miss(arm, target, revised)
        ):
            revised = replace(revised, certain=True)
    return revised


def _held_values(arm: Arm, method: Method, start: Array) -> Array | None:
    """Values (k, h) of the joints that the closed form holds. None to hold them at the start."""
    if not method.swept:
        return None
    values = np.tile(np.clip(start, arm.limits.lower, arm.limits.upper), (SAMPLES, 1))
    lower, upper = arm.sampling_bounds
    for i in method.swept:
        values[:, i] = np.linspace(lower[i], upper[i], SAMPLES)
    return np.ascontiguousarray(values[:, list(method.held)])


def _met_answer(arm: Arm, target: AnyTarget, answer: Answer, theta: Array) -> Answer:
    """The answer with a configuration that meets the target."""
    g = arm.fk(theta)
    return replace(
        answer, theta=theta, position_error=target.position_error(g), orientation_error=target.orientation_error(g),
        stop=STOPS.index(StopReason.CONVERGED), by_closed_form=True,
        has_unlimited=False, nearest=False, other_branch=False,
    )  # fmt: skip


def _with_limits_blamed(arm: Arm, target: AnyTarget, answer: Answer, theta: Array) -> Answer:
    """The answer with a configuration outside the limits, unless one meets the whole target already."""
    tolerances = Tolerances(float(answer.position_tol), float(answer.orientation_tol))
    known = arm.fk(answer.unlimited)
    if answer.has_unlimited and tolerances.met(target.position_error(known), target.orientation_error(known)):
        return answer
    return replace(answer, unlimited=theta, stop=STOPS.index(StopReason.BLOCKED_BY_LIMITS), has_unlimited=True)


def _is_far_miss(arm: Arm, target: AnyTarget, answer: Answer) -> bool:
    """Whether the nearest misses by many tolerances, which are tight. Rounded axes never have tight ones."""
    position, orientation = np.maximum((answer.position_tol, answer.orientation_tol), arm.rounding)
    free = not len(target._rotation_tolerance)
    tight = is_exact(Tolerances(position, 0.0 if free else orientation))
    far = answer.position_error > FAR_MISS * position or answer.orientation_error > FAR_MISS * orientation
    return bool(tight and far)
