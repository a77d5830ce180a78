"""The root cause of an error of xacro, which wraps its errors in one another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...support.errors import DescriptionError
from .work import Refused


def causes(error: BaseException) -> Iterator[Any]:
    """The error and its causes: xacro keeps the original in `.exc`, Python in `__cause__`/`__context__`."""
    seen: set[int] = set()
    stack: list[BaseException | None] = [error]
    while stack:
        current = stack.pop()
        if isinstance(current, BaseException) and id(current) not in seen:
            seen.add(id(current))
            yield current
            stack += [getattr(current, "exc", None), current.__cause__, current.__context__]


def is_final(error: BaseException) -> bool:
    """Whether leaving parts out cannot help: a refusal, endless work, or an unreadable file."""
    return any(isinstance(cause, (Refused, DescriptionError, OSError, RecursionError)) for cause in causes(error))
