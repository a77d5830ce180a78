"""Reason for which a solver stopped, and the method that found its answer."""

from __future__ import annotations

from enum import Enum

from ..arm.inability import CANNOT_TURN

DAMPED, NEAREST, CLOSED_FORM = "damped least squares", "nearest configuration", "closed form"


class StopReason(Enum):
    """Why a solver stopped.

    Where the position is missed, the position alone decides, so that the reason does not hang on the kind of target:
    BLOCKED_BY_LIMITS if the arm reaches it without its position limits, else OUT_OF_REACH. Where the position is met
    and the rotation is missed: BLOCKED_BY_LIMITS if the whole target is met without limits. Otherwise the largest part
    of what is missing decides: IMPOSSIBLE_DIRECTION for a turn that this posture and those beside it lack,
    BLOCKED_BY_LIMITS for what the nearest configuration without limits does not miss, OUT_OF_REACH for the rest.
    """

    CONVERGED = "the target is met"
    OUT_OF_REACH = "out of reach"
    IMPOSSIBLE_DIRECTION = CANNOT_TURN
    BLOCKED_BY_LIMITS = "blocked by joint limits"
    EXHAUSTED = "no answer found, and none excluded"
    TIMED_OUT = "the time was up"


STOPS = tuple(StopReason)
"""The reasons by their numbers in an answer's row."""
