"""An answer by name: `IKResult` reads one, `IKBatch` has a record for each target.

An answer holds copies of the arguments. Later changes of your arrays do not change it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.abilities import CANNOT_TURN
from ..support.checks import Array
from .targets import numbers_of_kind

DAMPED, NEAREST, CLOSED_FORM = "damped least squares", "nearest configuration", "closed form"


class StopReason(Enum):
    """Why a solver stopped.

    A missed position decides alone. So the reason is the same for every kind of target. It is BLOCKED_BY_LIMITS if the
    arm reaches it without position limits, else OUT_OF_REACH. A missed rotation is BLOCKED_BY_LIMITS if the whole
    target can be met without limits. Otherwise the largest part of the missing rotation decides. IMPOSSIBLE_DIRECTION
    is a turn that this configuration and those beside it lack. BLOCKED_BY_LIMITS is what the nearest configuration
    without limits does not miss. OUT_OF_REACH is the rest.

    IN_COLLISION needs a scene: configurations meet the target, and all that were found collide.
    """

    CONVERGED = "the target is met"
    OUT_OF_REACH = "out of reach"
    IMPOSSIBLE_DIRECTION = CANNOT_TURN
    BLOCKED_BY_LIMITS = "blocked by joint limits"
    EXHAUSTED = "no answer found, and none excluded"
    TIMED_OUT = "the time was up"
    IN_COLLISION = "every configuration found that meets the target collides"


STOPS = tuple(StopReason)
"""The reasons by their numbers in an answer."""

NOT_FINISHED = -1
"""In place of a reason: the time was up before the target was finished."""

Records = NDArray[np.void]
"""Answers (N,) of a batch: each has the fields of `Answer` by name."""


@dataclass(frozen=True, eq=False)
class Answer:
    """An answer theta (n,), the searches behind it, and what was asked. The core's own `Answer` has the same fields.

    `stop`: number of the reason in STOPS. `unlimited` (n,): where limits block, an answer without them, if
    `has_unlimited`. `nearest`: theta is the nearest configuration, because no search met the target. `other_branch`:
    theta is not near theta0. Either the target is near theta0's pose, or it cannot be met. `start_moved`: theta0 lay
    outside the limits. `by_closed_form`: theta comes from the closed form, because no search met the target. `certain`:
    the closed form shows that no configuration meets the target.
    """

    theta: Array
    unlimited: Array
    theta0: Array
    numbers: Array
    kind: int
    position_tol: float
    orientation_tol: float
    stop: int
    position_error: float = np.inf
    orientation_error: float = np.inf
    iterations: int = 0
    restarts: int = 0
    has_unlimited: bool = False
    nearest: bool = False
    other_branch: bool = False
    start_moved: bool = False
    by_closed_form: bool = False
    certain: bool = False

    def __post_init__(self) -> None:
        for array in (self.theta, self.unlimited, self.theta0, self.numbers):
            array.flags.writeable = False


FIELDS = tuple(field.name for field in fields(Answer))


def answer_from(value: Callable[[str], Any]) -> Answer:
    """The answer with the fields that `value` gives by name."""
    return Answer(*map(value, FIELDS))


def answer_in(records: Records, i: int) -> Answer:
    """One answer of a batch."""
    record = records[i]
    numbers = record["numbers"][: numbers_of_kind(int(record["kind"]))]
    return answer_from(lambda name: numbers if name == "numbers" else record[name])


def write_answer(records: Records, i: int, answer: Answer) -> None:
    """Replace an answer by another one to the same target."""
    for name in FIELDS:
        if name != "numbers":
            records[name][i] = getattr(answer, name)
