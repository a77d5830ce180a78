"""The deadline of a solver."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Deadline:
    """A moment on the monotonic clock [s] after which no new work begins."""

    moment: float = math.inf

    @classmethod
    def after(cls, seconds: float | None) -> Deadline:
        """`seconds` from now; never for infinity and None."""
        return cls(math.inf if seconds is None else time.monotonic() + seconds)

    @property
    def passed(self) -> bool:
        """Whether the moment has come."""
        return time.monotonic() >= self.moment

    @property
    def left(self) -> float | None:
        """Seconds left, as a solver's `max_time`: at least a microsecond, None for infinity."""
        return None if math.isinf(self.moment) else max(1e-6, self.moment - time.monotonic())

    def until(self, items: Iterable[T]) -> Iterator[T]:
        """The items, until the moment has come."""
        for item in items:
            if self.passed:
                return
            yield item
