"""The work allowed to one expansion: counted, not timed, so that a file gets the same answer everywhere."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

MAX_WORK = 3_000_000
"""Units of one microsecond at most; a six-joint arm with its parameters in YAML takes 0.2 million."""

MAX_BITS = 10_000
"""No whole number of a robot is longer; arithmetic on such numbers is still instant."""

LONG_INTEGER_COST = 500
"""Whole numbers beyond 61 bits may share their hash: a set of many is searched from end to end for each."""

CHARACTERS_PER_UNIT = 16
"""Text is copied faster than objects are made."""

SCOPES_PER_UNIT = 4
"""A name is sought in the scope of each macro around, from the innermost outward."""


class Refused(Exception):  # noqa: N818 - it is no error yet: its place is not known here
    """What a description may not do, without its place; `errors.explain` adds that."""

    def __init__(self, code: str, what: str, remedy: str = "") -> None:
        super().__init__(what)
        self.code = code
        self.what = what
        self.remedy = remedy
        self.expression = ""


@dataclass
class Work:
    """What is left to one expansion."""

    left: int = MAX_WORK

    def charge(self, units: int) -> None:
        """Take `units`; Refused when there are not as many left."""
        self.left -= units
        if self.left < 0:
            what = "expanding it takes more work than any robot's description needs"
            raise Refused("xacro-too-large", what, "look for a macro, a list or a text that multiplies itself")

    def charge_text(self, characters: int) -> None:
        """Take the units of that many characters."""
        self.charge(characters // CHARACTERS_PER_UNIT)

    def weigh(self, value: Any) -> Any:
        """Charge a value's size, everything that hangs on it counted as often as it would be written; return it.

        Shared parts count each time: ten lists that each hold the one before ten times weigh 10¹⁰.
        """
        if type(value) in (float, bool, type(None)):
            return value
        size, stack = 0, [value]
        while stack and size <= self.left:
            part = stack.pop()
            size += 1 + _own_size(part)
            stack.extend(_parts(part))
        self.charge(size)
        return value


def _own_size(value: Any) -> int:
    if isinstance(value, int):
        if value.bit_length() > MAX_BITS:
            raise Refused("xacro-too-large", f"a whole number of more than {MAX_BITS} bits", "use a float")
        return LONG_INTEGER_COST if value.bit_length() > sys.hash_info.width - 3 else 0
    if isinstance(value, str):
        return len(value) // CHARACTERS_PER_UNIT
    if isinstance(value, range):
        return max(0, (value.stop - value.start) // value.step) * (1 + _own_size(value.stop) + _own_size(value.start))
    if isinstance(value, (complex, bytes)):
        what = f"a value of type {type(value).__name__} is not allowed"
        raise Refused("xacro-expression-refused", what, "use real numbers and texts")
    return 0


def _parts(value: Any) -> list[Any]:
    """The members of a container; the names of a namespace, and those of the one around it."""
    if isinstance(value, dict):
        around = vars(value).get("parent") if hasattr(value, "__dict__") else None
        members = [*dict.keys(value), *dict.values(value)]
        return members if around is None else [*members, around]
    if isinstance(value, list):
        return list(list.__iter__(value))
    if isinstance(value, (tuple, set)):
        return list(value)
    return []
