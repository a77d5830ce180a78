"""Enable, stop and emergency stop: whether a stream may move its arm."""

from __future__ import annotations

import threading
from typing import Protocol, runtime_checkable

from ...support.checks import as_flag, require, require_choice
from ...support.errors import one_line

ENABLED, STOPPED, EMERGENCY_STOP = "enabled", "stopped", "emergency stop"

STATES = (ENABLED, STOPPED, EMERGENCY_STOP)
"""States of an interlock, and those that a robot may report."""

WORDS = ("enable", "stop", "emergency stop", "clear")
"""Words that messages may send to an interlock."""

LONGEST_REASON = 200
"""Most characters of a reason. It may come from outside and is in every message."""


class Interlock:
    """Whether an arm may move, set by operators, messages and programs. Thread-safe.

    It starts enabled unless `enabled` is False. If it forbids motion, `run` brings the arm to rest within its
    acceleration limits. The stream continues. An emergency stop is latched: `enable` has no effect before `clear`,
    which moves nothing (ISO 13850, 4.1.4). This is software and does not replace hardware.
    """

    def __init__(self, *, enabled: bool = True) -> None:
        self._lock = threading.Lock()
        self._now = (ENABLED, "") if as_flag(enabled, "enabled") else (STOPPED, "it waits to be enabled")

    def enable(self) -> bool:
        """Let the arm move. Returns whether it may now; an emergency stop must be cleared first."""
        return self._change(ENABLED, "", (STOPPED,)) == ENABLED

    def stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `enable`; an emergency stop stays one."""
        self._change(STOPPED, reason, (ENABLED, STOPPED))

    def emergency_stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `clear` and then `enable`. The first reason stays until then."""
        self._change(EMERGENCY_STOP, reason, (ENABLED, STOPPED))

    def clear(self) -> None:
        """End an emergency stop. The arm is then stopped and waits for `enable`."""
        self._change(STOPPED, "the emergency stop was cleared; it waits to be enabled", (EMERGENCY_STOP,))

    def _change(self, word: str, reason: str, only_from: tuple[str, ...]) -> str:
        new = word, one_line(require(reason, str, "reason", "in words"), LONGEST_REASON)
        with self._lock:
            if self._now[0] in only_from:
                self._now = new
            return self._now[0]

    def hear(self, word: str, reason: str, fresh: bool = True) -> None:
        """Obey a message. One that is not fresh may stop the arm, but not let it move again.

        Args:
            word: One of `WORDS`.
            reason: Why, for the report.
            fresh: Whether the message is new.
        """
        if require_choice(word, WORDS, "word") == "emergency stop":
            self.emergency_stop(reason)
        elif word == "stop":
            self.stop(reason)
        elif fresh:
            self.clear() if word == "clear" else self.enable()

    def follow(self, word: str | None, who: str) -> None:
        """Stop if a robot reports that it is stopped.

        Args:
            word: One of `STATES`. "enabled" and None change nothing.
            who: The robot's name in the reason.
        """
        if word is not None and require_choice(word, STATES, "word") == EMERGENCY_STOP:
            self.emergency_stop(f"{who} is in emergency stop")
        elif word == STOPPED:
            self.stop(f"{who} is stopped")

    @property
    def allows_motion(self) -> bool:
        """Whether the arm may move."""
        return self._now[0] == ENABLED

    @property
    def word(self) -> str:
        """One of "enabled", "stopped" and "emergency stop"."""
        return self._now[0]

    @property
    def reason(self) -> str:
        """Why it is stopped; "" without a reason or if enabled."""
        return self._now[1]

    @property
    def barrier(self) -> str:
        """Why the arm may not move, the word and its reason; "" where it may."""
        word, reason = self._now
        return "" if word == ENABLED else ": ".join(filter(None, (word, reason)))


@runtime_checkable
class Interlocked(Protocol):
    """A source or feedback with interlock messages. The stream sets its interlock here."""

    interlock: Interlock
