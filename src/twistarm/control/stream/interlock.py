"""Enable, stop and emergency stop: whether a stream may move its arm."""

from __future__ import annotations

import threading
from typing import NamedTuple, Protocol, runtime_checkable

from ...support.checks import as_flag, require, require_choice
from ...support.errors import one_line

ENABLED, STOPPED, EMERGENCY_STOP = "enabled", "stopped", "emergency stop"

WORDS = ("enable", "stop", "emergency stop", "clear")
"""Words that messages may send to an interlock."""

STATES = (ENABLED, STOPPED, EMERGENCY_STOP)
"""States of an interlock, and those that a robot may report."""

LONGEST_REASON = 200
"""Most characters of a reason. It may come from outside and is in every message."""


class Permission(NamedTuple):
    """Whether the arm may move.

    `word` is "enabled", "stopped" or "emergency stop"; `reason` says why it is not enabled.
    """

    word: str
    reason: str

    @property
    def barrier(self) -> str:
        """Why the arm may not move, "" where it may."""
        return "" if self.word == ENABLED else ": ".join(filter(None, self))


class Interlock:
    """Whether an arm may move, set by operators, messages and programs.

    Thread-safe.

    It starts enabled unless `enabled` is False. If it forbids motion, `run` brings the arm to rest within its
    acceleration limits. The stream continues. An emergency stop is latched: `enable` has no effect before `clear`,
    which moves nothing (ISO 13850, 4.1.4). This is software and does not replace hardware.
    """

    def __init__(self, *, enabled: bool = True) -> None:
        self._lock = threading.Lock()
        self._now = (
            Permission(ENABLED, "") if as_flag(enabled, "enabled") else Permission(STOPPED, "it waits to be enabled")
        )

    def enable(self) -> bool:
        """Let the arm move. Returns whether it may now; an emergency stop must be cleared first."""
        with self._lock:
            if self._now.word == STOPPED:
                self._now = Permission(ENABLED, "")
            return self._now.word == ENABLED

    def stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `enable`; an emergency stop stays one."""
        self._bar(STOPPED, reason)

    def emergency_stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `clear` and then `enable`. The first reason stays until then."""
        self._bar(EMERGENCY_STOP, reason)

    def _bar(self, word: str, reason: str) -> None:
        with self._lock:
            if self._now.word != EMERGENCY_STOP:
                self._now = Permission(word, one_line(require(reason, str, "reason", "in words"), LONGEST_REASON))

    def clear(self) -> None:
        """End an emergency stop. The arm is then stopped and waits for `enable`."""
        with self._lock:
            if self._now.word == EMERGENCY_STOP:
                self._now = Permission(STOPPED, "the emergency stop was cleared; it waits to be enabled")

    def hear(self, word: str, reason: str, fresh: bool = True) -> None:
        """Obey a message. One that is not fresh may stop the arm, but not let it move again.

        Args:
            word: One of `WORDS`.
            reason: The reason for a stop, in words.
            fresh: Whether the message is recent.
        """
        if require_choice(word, WORDS, "word") == "emergency stop":
            self.emergency_stop(reason)
        elif word == "stop":
            self.stop(reason)
        elif fresh:
            self.clear() if word == "clear" else self.enable()

    def follow(self, word: str | None, who: str) -> None:
        """Stop if a robot reports that it is stopped.

        A robot that reports itself enabled changes nothing.

        Args:
            word: The robot's own state, or None where it reports none.
            who: The robot's name, for the reason.
        """
        if word is not None and require_choice(word, STATES, "word") == EMERGENCY_STOP:
            self.emergency_stop(f"{who} is in emergency stop")
        elif word == STOPPED:
            self.stop(f"{who} is stopped")

    def look(self) -> Permission:
        """The word and its reason, of one moment."""
        return self._now

    @property
    def allows_motion(self) -> bool:
        """Whether the arm may move."""
        return self._now.word == ENABLED

    @property
    def word(self) -> str:
        """One of "enabled", "stopped" and "emergency stop"."""
        return self._now.word

    @property
    def reason(self) -> str:
        """Why it is stopped; "" without a reason or if enabled."""
        return self._now.reason


@runtime_checkable
class Interlocked(Protocol):
    """A source or feedback with interlock messages. The stream sets its interlock here."""

    interlock: Interlock
