"""Spans of time: the shortest and the longest motion, and the callback for progress."""

from __future__ import annotations

from collections.abc import Callable

from ..support.errors import InputError

Progress = Callable[[float], object]
"""Called with the fraction done, in (0, 1]."""

MARGIN = 1e-10
"""Times exceed the limits' least times by this share, so that rounding falls on the safe side."""

SHORTEST, LONGEST = 1e-9, 1e9
"""Lengths [s] of motions whose coefficients keep clear of overflow."""


def require_span(duration: float) -> None:
    """Raise InputError where a motion of this duration [s] is too short or too long."""
    if not SHORTEST <= duration <= LONGEST:
        raise InputError(
            f"this path and these limits make a motion of {duration:.3g} s; {SHORTEST:g} s to {LONGEST:g} s can be "
            "planned: check the units of both"
        )
