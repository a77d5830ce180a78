"""The work allowed to one expansion, counted and not timed, so every machine gives the same answer."""

from __future__ import annotations

from dataclasses import dataclass

MAX_WORK = 3_000_000
"""Units of about a microsecond; a six-joint arm with its parameters in YAML takes 0.2 million."""

CHARACTERS_PER_UNIT = 16
"""Text is copied faster than objects are made."""


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
