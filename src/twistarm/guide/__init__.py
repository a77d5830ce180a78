"""The guide: a course in the kinematics of robot arms whose exercises grade themselves."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def check(function: Callable[..., Any]) -> Any:
    """Grade a function that answers an exercise, found by its name; prints the verdict and returns the report."""
    from .grading import check as graded

    return graded(function)
