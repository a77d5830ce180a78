"""The work allowed to one expansion, and why one ends. Work is counted, so each machine gives the same answer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ...support.errors import DescriptionError

MAX_WORK = 3_000_000
"""Units of about a microsecond. A six-joint arm with its parameters in YAML takes 0.2 million."""

CHARACTERS_PER_UNIT = 16
"""Text is copied faster than objects are made."""


class Refused(Exception):  # noqa: N818 - it is no error yet: its place is not known here
    """What a description may not do. `errors.explain` adds the place."""

    def __init__(self, code: str, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.code = code
        self.what = what
        self.remedy = remedy
        self.expression = ""


@dataclass
class Work:
    """The work left to one expansion."""

    left: int = MAX_WORK

    def charge(self, units: int) -> None:
        """Take `units`. Refused when fewer are left."""
        self.left -= units
        if self.left < 0:
            what = "expanding it takes more work than any robot's description needs"
            raise Refused("xacro-failed", what, "look for a macro, a list or a text that multiplies itself")

    def charge_text(self, characters: int) -> None:
        """Take the units of so many characters."""
        self.charge(characters // CHARACTERS_PER_UNIT)


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
    """Whether leaving something out cannot help: a refusal, endless recursion or a file that cannot be opened."""
    return any(isinstance(cause, (Refused, DescriptionError, OSError, RecursionError)) for cause in causes(error))
