"""Certainty: what the closed form says of a target that no search has met.

Searches may miss a configuration, and cannot prove that there is none. Where the arm's axes have an exact closed form,
in the compiled core, it does both, in some microseconds.
"""

from __future__ import annotations

import numpy as np

from ..model.arm import Arm
from ..support.checks import Array
from . import answer
from .all_solutions_row import INSIDE, LEFT, configurations_in
from .closed_form.methods import family_for
from .stop_reason import STOPS, StopReason
from .targets import AnyTarget

TIMED_OUT = STOPS.index(StopReason.TIMED_OUT)


def settled(arm: Arm, target: AnyTarget, row: Array) -> Array:
    """The row of an answer (ik/answer.py), with the nearest configuration where there is one after all.

    Else the same row, marked as certain where the closed form shows that no configuration inside the limits meets the
    target. A row that is met, was not finished in time, or is of one search alone comes back as it is: who asks for one
    search wants to know what it finds.
    """
    if row[answer.STOP] in (0, TIMED_OUT, answer.NOT_FINISHED) or row[answer.RESTARTS] <= 1:
        return row
    family = family_for(arm, target)
    if family is None:
        return row
    tolerances = float(row[answer.POSITION_TOL]), float(row[answer.ORIENTATION_TOL])
    found = family.solve(target.numbers, np.array(answer.theta0_in(row, arm.n)), None, *tolerances)
    if found is None or found[LEFT]:
        return row
    told = row.copy()
    flags = int(row[answer.FLAGS])
    if found[INSIDE]:
        theta = configurations_in(found, arm.n)[0][0, : arm.n]
        g = arm.fk(theta)
        told[[answer.POSITION_ERROR, answer.ORIENTATION_ERROR]] = target.position_error(g), target.orientation_error(g)
        told[answer.FIRST : answer.FIRST + arm.n] = theta
        told[answer.STOP] = STOPS.index(StopReason.CONVERGED)
        told[answer.FLAGS] = (flags & answer.START_MOVED) | answer.BY_CLOSED_FORM
    else:
        told[answer.FLAGS] = flags | answer.CERTAIN
    told.flags.writeable = False
    return told
