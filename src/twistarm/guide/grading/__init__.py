"""The grader of the exercises."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...support.errors import TwistarmError


def check(function: Callable[..., Any]) -> Any:
    """Grade `function` as the exercise of its name."""
    raise TwistarmError(f"there is no exercise {function.__name__!r} yet")
