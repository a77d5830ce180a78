"""Answers as NumPy records: `IKResult` shows one, `IKBatch` an array of them."""

from __future__ import annotations

from enum import Enum
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.abilities import CANNOT_TURN
from ..support.checks import Array
from .targets import MOST_NUMBERS

DAMPED, NEAREST, CLOSED_FORM = "damped least squares", "nearest configuration", "closed form"


class StopReason(Enum):
    """Why a solver stopped.

    A missed position decides alone. So the reason is the same for every kind of target. It is BLOCKED_BY_LIMITS if the
    arm reaches it without position limits, else OUT_OF_REACH. A missed rotation is BLOCKED_BY_LIMITS if the whole
    target can be reached without limits. Otherwise the largest part of the missing rotation decides.
    IMPOSSIBLE_DIRECTION is a turn that this configuration and those beside it lack. BLOCKED_BY_LIMITS is what the
    nearest configuration without limits does not miss. OUT_OF_REACH is the rest.

    IN_COLLISION needs a scene: configurations reach the target, and all that were found collide.
    """

    CONVERGED = "the target is reached"
    OUT_OF_REACH = "out of reach"
    IMPOSSIBLE_DIRECTION = CANNOT_TURN
    BLOCKED_BY_LIMITS = "blocked by joint limits"
    EXHAUSTED = "no answer found, and none excluded"
    TIMED_OUT = "the time was up"
    IN_COLLISION = "every configuration found that reaches the target collides"


STOPS = tuple(StopReason)  # The reasons by their numbers in an answer.
CONVERGED = 0  # The number of StopReason.CONVERGED.
NOT_FINISHED = -1  # In place of a reason: the time was up before the target was finished.
Record = NDArray[np.void]  # An answer (), or the answers (N,) of a batch, with the fields of `record_type`.


@cache
def record_type(n: int) -> np.dtype[np.void]:
    """NumPy's type of an answer of an arm with n coordinates. The core's `Record` has the same fields in this order.

    Errors and tolerances are in m and rad. stop: the number of the reason in STOPS. kind: the kind of the target.
    nearest: theta is the nearest configuration, because no search reached the target. has_unlimited: limits block, and
    `unlimited` is an answer without them. other_branch: theta is not near theta0. Either the target is near theta0's
    pose, or it cannot be reached. start_moved: theta0 lay outside the limits. by_closed_form: theta comes from the
    closed form, because no search reached the target. certain: the closed form shows that no configuration reaches the
    target. theta0 and numbers are copies of what was asked. `numbers` are the target's, followed by 0.
    """
    reals = ["position_error", "orientation_error", "position_tol", "orientation_tol"]
    wholes = ["iterations", "restarts", "stop", "kind"]
    flags = ["nearest", "has_unlimited", "other_branch", "start_moved", "by_closed_form", "certain"]
    rows = [("theta", n), ("unlimited", n), ("theta0", n), ("numbers", MOST_NUMBERS)]
    fields = [(name, "f8") for name in reals] + [(name, "i8") for name in wholes] + [(name, "?") for name in flags]
    return np.dtype([*fields, *((name, "f8", (count,)) for name, count in rows)], align=True)


def fill(answer: Record, **values: Any) -> None:
    """Write these fields of an answer."""
    for name, value in values.items():
        answer[name] = value


class Configurations(NamedTuple):
    """The configurations of one target by a closed form of the core: `rows` (k, 2, n), the `inside` ones first.

    The nearest come first. A row holds theta (n,) and, as 0 and 1, which coordinates may move while the target stays
    reached. hits: how many of the values tried for held joints have any. families: how many belong to continuous
    families; left: those outside.
    """

    rows: Array
    inside: int
    hits: int
    left: int
    families: int

    @property
    def theta(self) -> Array:
        """(k, n)."""
        return self.rows[:, 0]

    @property
    def moves(self) -> NDArray[np.bool_]:
        """(k, n)."""
        return self.rows[:, 1] > 0.5


class ConfigurationsBatch(NamedTuple):
    """The same of N targets, all rows (r, 2, n) in one array: counts, inside and families are (N,)."""

    rows: Array
    counts: NDArray[np.int64]
    inside: NDArray[np.int64]
    families: NDArray[np.int64]

    @property
    def first(self) -> NDArray[np.int64]:
        """(N,): where each target's rows begin."""
        return np.cumsum(self.counts) - self.counts
