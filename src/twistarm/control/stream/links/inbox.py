"""Inboxes filled by threads, sockets and pages: the latest value of one sender, for a timeout."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, replace
from math import inf
from typing import Generic, TypeVar

from ....support.checks import as_number, as_positive, require
from ....support.errors import InputError, one_line, shown
from ...servo import AnyCommand, JogCommand, ServoState, TwistCommand
from ...servo.step import COMMANDS
from ..protocols import Reading

COMMAND_TIMEOUT = 0.2
"""Seconds that a command is valid: five messages at 25 Hz, which pages and game pads manage."""

FEEDBACK_TIMEOUT = 0.2
"""Seconds that a joint state is valid. Most drives report at 50 Hz or faster."""

LONGEST_SENDER = 100
"""Most characters of a sender's name in a message."""

T = TypeVar("T")


@dataclass(frozen=True)
class Look(Generic[T]):
    """The usable value and its age [s] (inf if none arrived), or None and the reason.

    `last` is the last value if only its age is against it. `quiet`: nothing was ever sent.
    """

    value: T | None
    age: float
    reason: str
    last: T | None = None
    quiet: bool = False


@dataclass(frozen=True)
class _Arrival(Generic[T]):
    sender: str
    time: float
    value: T | None
    number: int | None
    reason: str


class Latest(Generic[T]):
    """The latest value and its sender.

    Older ones are dropped, so a flood takes no memory. Thread-safe.

    A value counts for `timeout` [s], like a dead man's switch, and only from a single sender. A refused message
    replaces the value, so malformed input stops the arm. A message is dropped if its number does not exceed the
    sender's last one. Silence for a timeout resets this.

    Writers and readers may be threads. So a stamp may be before or after the last look. Only the readers' clock must
    run forward.
    """

    def __init__(self, timeout: float, what: str) -> None:
        self.timeout = as_positive(timeout, f"the timeout of a {what}")
        self._what = what
        self._lock = threading.Lock()
        self._latest: _Arrival[T] | None = None
        self._rival: _Arrival[T] | None = None
        self._clock = -inf
        self._ignored = ""

    def put(self, sender: str, value: T, now: float | None = None, number: int | None = None) -> None:
        """Store `value` from `sender` at `now` [s], with the sender's counter if it has one.

        Its age counts from `now` (default: `MonotonicClock`, the loop's), or from an earlier first look.
        """
        if number is not None and not isinstance(number, (int, float)):
            raise InputError(f"number must be a counter, a whole number; got {shown(number)}")
        self._arrive(_Arrival(_name(sender), moment(now), value, number, ""))

    def refuse(self, sender: str, reason: str, now: float | None = None) -> None:
        """Something from `sender` that cannot be used arrived at `now` [s].

        Args:
            sender: The sender's name.
            reason: The reason, in words.
            now: The time of arrival [s]; by default that of `MonotonicClock`.
        """
        self._arrive(_Arrival(_name(sender), moment(now), None, None, require(reason, str, "reason", "in words")))

    def heard(self, sender: str) -> bool:
        """Whether the last one who said anything, or the one before, is `sender`."""
        with self._lock:
            return self._last_from(_name(sender)) is not None

    def look(self, now: float, of: str = "") -> Look[T]:
        """What counts at `now` [s]. of: what the reason adds to the words for what is held here."""
        now = moment(now)
        with self._lock:
            self._follow(now)
            if self._latest is None:
                return Look(None, inf, self._ignored or f"no {self._what}{of} has arrived", quiet=not self._ignored)
            age = now - self._latest.time
            reason = self._why_not(self._latest, age, now, self._what + of)
            last = None if self._ignored else self._latest.value
            return Look(None if reason else self._latest.value, age, reason, last)

    def _why_not(self, latest: _Arrival[T], age: float, now: float, what: str) -> str:
        if not age <= self.timeout:
            return f"the last {what} is {age:.3g} s old (timeout {self.timeout:g} s){self._ignored}"
        if self._rival is not None and now - self._rival.time <= self.timeout:
            return f"two senders of a {what}, {self._rival.sender} and {latest.sender}: stop one of them"
        return f"{what} from {latest.sender} refused: {latest.reason}" if latest.value is None else ""

    def _arrive(self, new: _Arrival[T]) -> None:
        with self._lock:
            last = self._last_from(new.sender)
            if last is not None and new.time - last.time <= self.timeout and _is_outdated(last.number, new.number):
                self._ignored = f"; number {new.number} came after {last.number} and was left out"
                return
            if self._latest is not None and self._latest.sender != new.sender:
                self._rival = self._latest
            self._latest, self._ignored = new, ""

    def _last_from(self, sender: str) -> _Arrival[T] | None:
        return next((each for each in (self._latest, self._rival) if each and each.sender == sender), None)

    def _follow(self, now: float) -> None:
        """If the readers' clock ran backwards, drop the values from that future."""
        if now < self._clock:
            self._latest, self._rival = None, None
            self._ignored = f"time went back by {self._clock - now:.3g} s; no {self._what} has arrived since"
        self._clock = now
        self._latest, self._rival = (each and _arrival_time(each, now) for each in (self._latest, self._rival))


class Inbox(Latest[AnyCommand]):
    """A source that holds one command, put there by `put(sender, command)` from any thread. See `Latest`."""

    def __init__(self, timeout: float = COMMAND_TIMEOUT) -> None:
        super().__init__(timeout, "command")

    def put(self, sender: str, value: AnyCommand, now: float | None = None, number: int | None = None) -> None:
        """Put in a command, which holds for `timeout`: repeat it. InputError for what is no command.

        Args:
            sender: The sender's name: the commands of one alone count.
            value: `TwistCommand`, `JogCommand` or `PoseCommand`; six numbers are a twist in tool axes.
            now: The time of arrival [s]; by default that of `MonotonicClock`, the loop's own.
            number: The sender's own counter, where it counts.
        """
        if not isinstance(value, COMMANDS):
            try:
                value = TwistCommand(value)
            except InputError as error:
                raise InputError(
                    f"a command is a TwistCommand, JogCommand, PoseCommand or six numbers: {error}"
                ) from error
        super().put(sender, value, now, number)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command of the one commander at `now` [s], or None and the reason.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        look = self.look(now)
        silent = look.value is None and look.age > self.timeout
        stopped = isinstance(look.last, JogCommand) and not look.last.theta_dot.any()
        return Reading(look.value, look.age, look.reason, silent and (look.quiet or stopped))


def moment(now: float | None) -> float:
    """A time [s], by default that of the system's clock that is never set."""
    if now is None:
        return time.monotonic()
    return now if type(now) is float else as_number(now, "now [s]")


def _is_outdated(last: int | None, new: int | None) -> bool:
    return last is not None and new is not None and new <= last


def _name(sender: str) -> str:
    return one_line(require(sender, str, "sender", "the name of who says it"), LONGEST_SENDER)


def _arrival_time(arrival: _Arrival[T], now: float) -> _Arrival[T]:
    """The arrival time, at most `now`. A later one would count for longer than a timeout."""
    return arrival if arrival.time <= now else replace(arrival, time=now)
