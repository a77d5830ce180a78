"""The deadline of a solver."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Deadline:
    """A moment on the monotonic clock [s] after which no new work begins; infinity for none."""

    moment: float = math.inf

    @classmethod
    def after(cls, seconds: float) -> Deadline:
        """`seconds` from now; never for infinity."""
        return cls(time.monotonic() + seconds)

    @property
    def passed(self) -> bool:
        """Whether the moment has come."""
        return time.monotonic() >= self.moment

    @property
    def left(self) -> float:
        """Seconds until then, none if it has come."""
        return max(0.0, self.moment - time.monotonic())
