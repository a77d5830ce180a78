"""Pause, resume and stop: what an operator says to a followed motion."""

from __future__ import annotations

import threading

from ....support.checks import require
from ....support.errors import one_line
from ..interlock import LONGEST_REASON

PAUSED = "paused"


class FollowControl:
    """Whether a followed motion goes on, as programs and operators have last said. Thread-safe.

    Paused, the arm comes to rest along its path and waits there for `resume`. Stopped, it does so and the motion ends,
    which nothing takes back.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pause = ""
        self._stopped = False

    def pause(self, reason: str = PAUSED) -> None:
        """Come to rest along the path, and wait there; the first reason counts until `resume`."""
        with self._lock:
            self._pause = self._pause or one_line(require(reason, str, "reason", "in words"), LONGEST_REASON) or PAUSED

    def resume(self) -> None:
        """Go on along the path."""
        with self._lock:
            self._pause = ""

    def toggle(self) -> None:
        """Pause a motion that goes on, resume one that is paused."""
        with self._lock:
            self._pause = "" if self._pause else PAUSED

    def stop(self) -> None:
        """Come to rest along the path, and end there."""
        self._stopped = True

    @property
    def pause_reason(self) -> str:
        """Why the motion is paused, "" where it goes on."""
        return self._pause

    @property
    def paused(self) -> bool:
        """Whether the motion is paused."""
        return bool(self._pause)

    @property
    def stopped(self) -> bool:
        """Whether the motion was told to end."""
        return self._stopped
