"""Environment variables that a description may read: only those that the caller names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ...support.caller_words import argument
from ..findings import Finding, Place, finding


class NotSetError(Exception):
    """A variable that the file needs has no value, or the caller does not name it."""


@dataclass
class Environment:
    """Replaces xacro's `$(env NAME)` and `$(optenv NAME default)`, also in `$(eval ...)`.

    A name outside `allowed` counts as not set. A file could otherwise put its value in the robot's name, and so on
    pages that users pass on.
    """

    file: Path
    allowed: tuple[str, ...] = ()
    _kept: dict[str, str] = field(default_factory=dict)

    def required(self, name: str) -> str:
        """The variable's value. NotSetError without one."""
        value = os.environ.get(name) if name in self.allowed else None
        if value is None:
            raise NotSetError(f"environment variable {name!r} is not set for it")
        return value

    def optional(self, name: str, default: str = "") -> str:
        """The variable's value, else the default."""
        if name in self.allowed:
            return os.environ.get(name, default)
        self._kept.setdefault(name, default)
        return default

    def findings(self) -> Iterator[Finding]:
        """One for each name that the file reads and the caller does not allow."""
        for name, default in self._kept.items():
            what = (
                f"it asks for the environment variable {name!r}, and was answered as if that were not set: {default!r}"
            )
            remedy = f"pass {argument('env_vars', [name])} if it may know it"
            yield finding("environment-kept", Place(self.file.name), what, remedy)
