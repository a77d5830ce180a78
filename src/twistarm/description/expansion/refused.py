"""What a description may not do, and what an error wraps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ...support.errors import DescriptionError


class Refused(Exception):  # noqa: N818 - it is no error yet: its place is not known here
    """What a description may not do. `errors.explain` adds the place."""

    def __init__(self, code: str, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.code = code
        self.what = what
        self.remedy = remedy
        self.expression = ""


def causes(error: BaseException) -> Iterator[Any]:
    """The error and all that it wraps: xacro keeps the original in `.exc`, Python in `__cause__`/`__context__`."""
    seen: set[int] = set()
    stack: list[BaseException | None] = [error]
    while stack:
        current = stack.pop()
        if isinstance(current, BaseException) and id(current) not in seen:
            seen.add(id(current))
            yield current
            stack += [getattr(current, "exc", None), current.__cause__, current.__context__]


def is_final(error: BaseException) -> bool:
    """Whether leaving something out cannot help: a refusal, no memory, endless recursion or a file that is missing."""
    final = Refused, DescriptionError, OSError, RecursionError, MemoryError
    return any(isinstance(cause, final) for cause in causes(error))
