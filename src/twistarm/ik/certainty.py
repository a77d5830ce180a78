"""Certainty: what the closed form says of a target that no search has met.

Searches may miss a configuration, and cannot prove that there is none. Where the arm has a closed form in the compiled
core, it answers in some microseconds. Where the axes are exact and no joint is held at samples, it also proves.
"""

from __future__ import annotations

import numpy as np

from ..model.arm import Arm
from ..support.checks import Array
from . import answer
from .all_solutions_row import INSIDE, LEFT, configurations_in
from .closed_form.methods import Method, family_for
from .ranges import joint_ranges
from .stop_reason import STOPS, StopReason
from .targets import AnyTarget
from .task_space import Tolerances

TIMED_OUT = STOPS.index(StopReason.TIMED_OUT)

SAMPLES = 5
"""Values at which a joint beyond those that the target determines is held, its bounds among them."""

EXACTLY = 1e-5
"""Wider tolerances [m, rad] ask for more than the closed form knows: it looks for configurations that meet a target
exactly."""

FAR = 10.0
"""How many tolerances the nearest configuration misses at least, where it is certain that none meets the target."""

HARDLY_OUTSIDE = 1e-4
"""A configuration that lies outside the limits by less [rad, m] makes nothing certain."""


def is_exact(tolerances: Tolerances) -> bool:
    """Whether the closed form knows all that meets a target within these."""
    return max(tolerances.position, tolerances.orientation) <= EXACTLY


def settled(arm: Arm, target: AnyTarget, row: Array) -> Array:
    """The row of an answer (ik/answer.py), with what the closed form knows better.

    That is a configuration after all, or one outside the limits, which are to blame then. The row is marked as certain
    where the closed form shows that no configuration inside the limits meets the target within the tolerances. A row
    that is met, was not finished in time, or is of one search alone comes back as it is: who asks for one search wants
    to know what it finds.
    """
    if row[answer.STOP] in (0, TIMED_OUT, answer.NOT_FINISHED) or row[answer.RESTARTS] <= 1:
        return row
    method = family_for(arm, target)
    if method is None or method.compiled is None:
        return row
    tolerances = float(row[answer.POSITION_TOL]), float(row[answer.ORIENTATION_TOL])
    start = np.array(answer.theta0_in(row, arm.n))
    found = method.compiled.solve(target.numbers, start, _held_values(arm, method, start), *tolerances)
    if found is None:
        return row
    inside, outside = (each[:, : arm.n] for each in configurations_in(found, arm.n))
    told = row.copy()
    if found[INSIDE]:
        _meet(arm, target, told, inside[0])
    else:
        outside = joint_ranges(arm).toward_middle(outside)
        beyond = np.abs(outside - np.clip(outside, arm.limits.lower, arm.limits.upper))
        if len(outside):
            _blame_limits(arm, target, told, outside[np.argmin(np.square(beyond).sum(axis=1))])
        exact = method.exact and not method.swept and not found[LEFT]
        if (
            exact
            and beyond.max(axis=1, initial=0.0).min(initial=np.inf) > HARDLY_OUTSIDE
            and _misses_by_far(arm, target, row)
        ):
            told[answer.FLAGS] = int(told[answer.FLAGS]) | answer.CERTAIN
    told.flags.writeable = False
    return told


def _held_values(arm: Arm, method: Method, start: Array) -> Array | None:
    """Values (k, h) of the joints that the closed form holds; None where those of the start will do."""
    if not method.swept:
        return None
    values = np.tile(np.clip(start, arm.limits.lower, arm.limits.upper), (SAMPLES, 1))
    lower, upper = arm.sampling_bounds
    for i in method.swept:
        values[:, i] = np.linspace(lower[i], upper[i], SAMPLES)
    return np.ascontiguousarray(values[:, list(method.held)])


def _meet(arm: Arm, target: AnyTarget, row: Array, theta: Array) -> None:
    """Writes an answer into the row."""
    g = arm.fk(theta)
    row[[answer.POSITION_ERROR, answer.ORIENTATION_ERROR]] = target.position_error(g), target.orientation_error(g)
    row[answer.FIRST : answer.FIRST + arm.n] = theta
    row[answer.STOP] = STOPS.index(StopReason.CONVERGED)
    row[answer.FLAGS] = (int(row[answer.FLAGS]) & answer.START_MOVED) | answer.BY_CLOSED_FORM


def _blame_limits(arm: Arm, target: AnyTarget, row: Array, theta: Array) -> None:
    """Writes a configuration outside the limits into the row, unless one that meets the whole target is known."""
    tolerances = row[[answer.POSITION_TOL, answer.ORIENTATION_TOL]]
    known = arm.fk(answer.unlimited_in(row, arm.n))
    missed = np.array([target.position_error(known), target.orientation_error(known)])
    if int(row[answer.FLAGS]) & answer.HAS_UNLIMITED and (missed <= tolerances).all():
        return
    row[answer.FIRST + arm.n : answer.FIRST + 2 * arm.n] = theta
    row[answer.STOP] = STOPS.index(StopReason.BLOCKED_BY_LIMITS)
    row[answer.FLAGS] = int(row[answer.FLAGS]) | answer.HAS_UNLIMITED


def _misses_by_far(arm: Arm, target: AnyTarget, row: Array) -> bool:
    """Whether the tolerances are tight, as those of rounded axes never are, and the nearest misses by many of them."""
    position, orientation = np.maximum(row[[answer.POSITION_TOL, answer.ORIENTATION_TOL]], arm.rounding)
    free = not len(target._rotation_tolerance)
    tight = is_exact(Tolerances(position, 0.0 if free else orientation))
    far = row[answer.POSITION_ERROR] > FAR * position or row[answer.ORIENTATION_ERROR] > FAR * orientation
    return bool(tight and far)
