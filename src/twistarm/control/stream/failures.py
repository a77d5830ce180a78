"""Failures of devices or of the servo that end a stream, and their texts."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from ...support.errors import TwistarmError
from .report import Ending

P = ParamSpec("P")
T = TypeVar("T")


class StreamError(Exception):
    """The stream ends with `ending`, because of what the text says."""

    def __init__(self, ending: Ending, reason: str) -> None:
        super().__init__(reason)
        self.ending = ending


def call_device(ending: Ending, call: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """What a device answers; `StreamError` where it says that it cannot."""
    try:
        return call(*args, **kwargs)
    except (OSError, TwistarmError) as error:
        raise StreamError(ending, worded(error)) from error


def worded(error: Exception) -> str:
    """An error as a reason. Errors of other programs are named with their type."""
    if isinstance(error, (TwistarmError, StreamError)):
        return str(error)
    return f"{type(error).__name__}: {error}"
