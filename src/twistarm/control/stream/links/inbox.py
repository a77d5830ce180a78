"""Inboxes filled by threads, sockets and pages: the latest command, and joint states merged by name."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from math import inf
from typing import Generic, TypeVar

from numpy.typing import ArrayLike

from ....arm.arm import Arm, require_arm
from ....support.checks import as_number, as_positive, as_theta, frozen, require, require_mapping
from ....support.errors import InputError, closest, listed, one_line, shown
from ...servo import AnyCommand, JogCommand, ServoState, TwistCommand
from ...servo.step import COMMANDS
from ..motors import motor_side
from ..protocols import Measured, Reading

COMMAND_TIMEOUT = 0.2
"""Seconds that a command is valid: five messages at 25 Hz, which pages and game pads manage."""

FEEDBACK_TIMEOUT = 0.2
"""Seconds that a joint state is valid. Most drives report at 50 Hz or faster."""

LONGEST_SENDER = 100
"""Most characters of a sender's name in a message."""

MAX_OTHER_NAMES = 20
"""Most unknown names to keep for messages."""

T = TypeVar("T")


@dataclass(frozen=True)
class Arrival(Generic[T]):
    """A value from a sender at a time [s], with the sender's counter if it has one; or None and why it is refused."""

    sender: str
    time: float
    value: T | None
    number: int | None = None
    reason: str = ""


class Latest(Generic[T]):
    """The latest arrival, and the one before from another sender.

    A value counts for `timeout` [s], like a dead man's switch, and only from a single sender. A refused message
    replaces the value, so malformed input stops the arm. A message is dropped if its number does not exceed the
    sender's last one. Silence for a timeout resets this. Writers and readers may be threads, so an arrival may be
    stamped a little after a look.
    """

    def __init__(self, timeout: float, what: str) -> None:
        self.timeout = as_positive(timeout, f"the timeout of a {what}")
        self.last: Arrival[T] | None = None
        self._rival: Arrival[T] | None = None
        self._what, self._dropped = what, ""

    def arrive(self, new: Arrival[T]) -> None:
        """Keep an arrival in place of the last one."""
        before = self.of(new.sender)
        if before is not None and abs(new.time - before.time) <= self.timeout and _outdated(new.number, before.number):
            self._dropped = f"; number {new.number} came after {before.number} and was left out"
            return
        if self.last is not None and self.last.sender != new.sender:
            self._rival = self.last
        self.last, self._dropped = new, ""

    def of(self, sender: str) -> Arrival[T] | None:
        """What came from `sender`, if that is the last arrival or the one before from another."""
        return next((each for each in (self.last, self._rival) if each and each.sender == sender), None)

    def age(self, now: float) -> float:
        """The age of the last arrival [s], inf before the first."""
        return inf if self.last is None else now - self.last.time

    def why_not(self, now: float) -> str:
        """Why no value counts at `now` [s]; "" if that of the last arrival does."""
        age = self.age(now)
        if self.last is None:
            return f"no {self._what} has arrived"
        if not age <= self.timeout:
            return f"the last {self._what} is {age:.3g} s old (timeout {self.timeout:g} s){self._dropped}"
        if age < -self.timeout:
            return f"the last {self._what} is {-age:.3g} s from the future: its clock is another, or went back"
        if self._rival is not None and abs(now - self._rival.time) <= self.timeout:
            return f"two senders of a {self._what}, {self._rival.sender} and {self.last.sender}: stop one of them"
        return f"{self._what} from {self.last.sender} refused: {self.last.reason}" if self.last.value is None else ""


class Inbox:
    """A source that holds one command, put there by `put(sender, command)` from any thread.

    A command counts for `timeout` [s]: repeat it. Two senders within a timeout cancel each other. A refused message
    stops the arm. A message is dropped if its number does not exceed the sender's last one within a timeout. Only the
    latest messages are kept, so a flood takes no memory.
    """

    def __init__(self, timeout: float = COMMAND_TIMEOUT) -> None:
        self._latest: Latest[AnyCommand] = Latest(timeout, "command")
        self._lock = threading.Lock()

    @property
    def timeout(self) -> float:
        """Seconds that a command is valid."""
        return self._latest.timeout

    @timeout.setter
    def timeout(self, seconds: float) -> None:
        self._latest.timeout = as_positive(seconds, "the timeout of a command")

    def put(self, sender: str, value: AnyCommand, now: float | None = None, number: int | None = None) -> None:
        """Put in a command. InputError for what is no command.

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
        self._arrive(Arrival(_name(sender), moment(now), value, _counter(number)))

    def refuse(self, sender: str, reason: str, now: float | None = None) -> None:
        """Something from `sender` that cannot be used arrived at `now` [s].

        Args:
            sender: The sender's name.
            reason: The reason, in words.
            now: The time of arrival [s]; by default that of `MonotonicClock`.
        """
        self._arrive(_refused(sender, reason, now))

    def _arrive(self, arrival: Arrival[AnyCommand]) -> None:
        with self._lock:
            self._latest.arrive(arrival)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command of the one commander at `now` [s], or None and the reason.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        now = moment(now)
        with self._lock:
            reason, last, age = self._latest.why_not(now), self._latest.last, self._latest.age(now)
        if last is None:
            return Reading(None, age, reason, idle=True)
        if not reason:
            return Reading(last.value, age)
        stopped = isinstance(last.value, JogCommand) and not last.value.theta_dot.any()
        return Reading(None, age, reason, idle=stopped and age > self.timeout)


class StateInbox:
    """A feedback that stores joint states from `put(sender, state)`, whole or in parts, from any thread.

    A joint's value is valid for `timeout` [s]. theta needs a value for every joint and is as old as the oldest. Each
    joint follows the rules of `Inbox`: one sender, increasing numbers. Other names are ignored, and named if theta is
    unknown. A refused message counts against all joints of its sender, or without one against every joint.

    units: "joint", or "motor" or "counts" for motors (`MotorSide`). They merge before theta is computed. So each motor
    of a differential may have its message.

    Raises InputError for a timeout that is not positive, and for units unknown to the arm.
    """

    def __init__(self, arm: Arm, timeout: float = FEEDBACK_TIMEOUT, *, units: str = "joint") -> None:
        self.motors = motor_side(require_arm(arm), units)
        self.names = arm.joint_names if self.motors is None else self.motors.names
        what = "joint state" if self.motors is None else "motors' state"
        self._parts: dict[str, Latest[float]] = {name: Latest(timeout, what) for name in self.names}
        self.timeout = timeout
        self._lock = threading.Lock()
        self._others: tuple[str, ...] = ()

    def put(
        self, sender: str, state: Mapping[str, float] | ArrayLike, now: float | None = None, number: int | None = None
    ) -> None:
        """Put in a message with the state of some joints or of all.

        A state that is not finite, or has another shape, is refused.

        Args:
            sender: The sender's name.
            state: {joint: value}, or values (n,), base to tip [rad, m].
            now: The time of arrival [s]; by default that of `MonotonicClock`, the loop's own.
            number: The sender's own counter, where it counts.
        """
        name, now, number = _name(sender), moment(now), _counter(number)
        try:
            values = self._values(state)
        except InputError as error:
            self.refuse(sender, str(error), now)
            return
        with self._lock:
            for joint, value in values.items():
                self._parts[joint].arrive(Arrival(name, now, value, number))

    def refuse(self, sender: str, reason: str, now: float | None = None) -> None:
        """Note that an unusable message has arrived.

        Args:
            sender: The sender's name.
            reason: The reason, in words.
            now: The time of arrival [s]; by default that of `MonotonicClock`.
        """
        arrival: Arrival[float] = _refused(sender, reason, now)
        with self._lock:
            its_own = [part for part in self._parts.values() if part.of(arrival.sender)]
            for part in its_own or self._parts.values():
                part.arrive(arrival)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s], or None and which joint it lacks, and why."""
        now, groups = moment(now), dict[str, list[str]]()
        with self._lock:
            for name, part in self._parts.items():
                if why := part.why_not(now):
                    groups.setdefault(why, []).append(name)
            heard = now - max(part.age(now) for part in self._parts.values())
            last = [part.last.value for part in self._parts.values() if part.last is not None]
        if groups:
            whys = [
                why if len(names) == len(self.names) else f"{why} ({', '.join(names)})" for why, names in groups.items()
            ]
            return Measured(None, heard, "; ".join(whys) + (self._hint() if heard == -inf else ""))
        values = [value for value in last if value is not None]
        return Measured(frozen(values) if self.motors is None else self.motors.theta(values), heard)

    def _hint(self) -> str:
        """Other names in the messages. They may be a name of a joint with a slip."""
        if not self._others:
            return ""
        never_heard = next(name for name, part in self._parts.items() if part.last is None)
        return f"; a message named {listed(self._others, 5)}" + closest(never_heard, self._others)

    def _values(self, state: Mapping[str, float] | ArrayLike) -> dict[str, float]:
        """The values that count, by name; InputError for what is not finite."""
        if not isinstance(state, Mapping):
            whole = as_theta(state, len(self.names), "the joint state", self.names)
            if whole.ndim != 1:
                raise InputError(f"the joint state is one configuration ({len(self.names)},); got {whole.shape}")
            return dict(zip(self.names, whole.tolist(), strict=True))
        require_mapping(state, "the joint state", "{joint: value}")
        ours = tuple(name for name in self.names if name in state)
        if len(ours) < len(state):
            self._others = tuple(islice((name for name in state if name not in self._parts), MAX_OTHER_NAMES))
        if not ours:
            return {}
        values = as_theta([state[name] for name in ours], len(ours), f"the joint state of {', '.join(ours)}", ours)
        return dict(zip(ours, values.tolist(), strict=True))


def moment(now: float | None) -> float:
    """A time [s], by default that of the system's clock that is never set."""
    if now is None:
        return time.monotonic()
    return now if type(now) is float else as_number(now, "now [s]")


def _name(sender: str) -> str:
    return one_line(require(sender, str, "sender", "the name of who says it"), LONGEST_SENDER)


def _counter(number: int | None) -> int | None:
    if number is not None and not isinstance(number, (int, float)):
        raise InputError(f"number must be a counter, a whole number; got {shown(number)}")
    return number


def _outdated(number: int | None, last: int | None) -> bool:
    return number is not None and last is not None and number <= last


def _refused(sender: str, reason: str, now: float | None) -> Arrival[T]:
    return Arrival(_name(sender), moment(now), None, None, require(reason, str, "reason", "in words"))
