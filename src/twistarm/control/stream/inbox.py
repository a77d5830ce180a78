"""Inboxes filled by threads, sockets and pages: the latest command, and joint states merged by name."""

from __future__ import annotations

import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from math import inf
from typing import Any

from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...support.checks import as_number, as_positive, as_theta, frozen, require, require_choice, require_mapping
from ...support.errors import InputError, closest, listed, one_line, quote
from ...support.strict_json import LARGEST_MESSAGE
from ..servo import AnyCommand, JogCommand, ServoState, TwistCommand
from ..servo.step import COMMANDS
from .messages import MotorSide, StateMessage, motor_side, obey_interlock_message, parse_command
from .protocols import MESSAGE_TIMEOUT, Interlock, Measured, Reading

LONGEST_SENDER = 100  # Most characters of a sender's name in a message.
MAX_OTHER_NAMES = 20  # Most unknown names to keep for messages.
MOST_TEXTS = 128  # Texts that count in a cycle: four for each of 32 joints. All are read in some two milliseconds.


@dataclass(frozen=True)
class Arrival:
    """A value from a sender at a time [s], with the sender's counter, if any. Or None and why it is refused."""

    sender: str
    time: float
    value: Any = None
    number: int | None = None
    reason: str = ""


class Latest:
    """The latest arrival, and the one before from another sender.

    A value counts for a timeout [s], like a dead man's switch, and only from a single sender. A refused message
    replaces the value, so malformed input stops the arm. A message is dropped if its number does not exceed the
    sender's last one. Silence for a timeout resets this. Writers and readers may be threads, so an arrival may be
    stamped a little after a look.
    """

    def __init__(self) -> None:
        self.last: Arrival | None = None
        self._rival: Arrival | None = None

    def arrive(self, new: Arrival, timeout: float) -> None:
        """Keep an arrival in place of the last one."""
        before = self.of(new.sender)
        number = None if before is None or abs(new.time - before.time) > timeout else before.number
        if number is not None and new.number is not None and new.number <= number:
            return
        if self.last is not None and self.last.sender != new.sender:
            self._rival = self.last
        self.last = new

    def of(self, sender: str) -> Arrival | None:
        """What came from `sender`, if that is the last arrival or the one before from another."""
        return next((arrival for arrival in (self.last, self._rival) if arrival and arrival.sender == sender), None)

    def fault(self, now: float, timeout: float, what: str, unread: float) -> str:
        """Why no value counts at `now` [s]; "" if that of the last arrival does. unread: as in `Arrivals`."""
        if unread > (-inf if self.last is None else self.last.time):
            return f"a {what} arrived before it was looked for, so its age is unknown, and none has come since"
        if self.last is None:
            return f"no {what} has arrived"
        age = now - self.last.time
        if not abs(age) <= timeout:  # so written, a time that is NaN is too old as well
            return f"the last {what} is {age:.3g} s old (timeout {timeout:g} s)"
        if self._rival is not None and abs(now - self._rival.time) <= timeout:
            return f"two senders of a {what}, {self._rival.sender} and {self.last.sender}: stop one of them"
        return f"{what} from {self.last.sender} refused: {self.last.reason}" if self.last.value is None else ""


class Arrivals:
    """What arrives from any thread, by name, each with the rules of `Latest`. Only the latest are kept.

    what: the noun for messages. `note`: what a reason adds where nothing counts. `unread` [s]: when values were last
    dropped because they had waited for too long.
    """

    def __init__(self, timeout: float, what: str, names: Iterable[str]) -> None:
        self.note, self.unread = "", -inf
        self._what, self._lock = what, threading.Lock()
        self._parts = {name: Latest() for name in names}
        self.timeout = timeout

    @property
    def timeout(self) -> float:
        """Seconds that a value is valid."""
        return self._timeout

    @timeout.setter
    def timeout(self, seconds: float) -> None:
        self._timeout = as_positive(seconds, f"the timeout of a {self._what}")

    def refuse(self, sender: str, reason: str, now: float | None = None) -> None:
        """Note that an unusable message has arrived. It counts against what its sender has sent, else against all.

        Args:
            sender: The sender's name.
            reason: The reason, in words.
            now: The time of arrival [s]; by default that of `MonotonicClock`.
        """
        arrival = Arrival(_name(sender), moment(now), reason=require(reason, str, "reason", "in words"))
        with self._lock:
            its_own = [part for part in self._parts.values() if part.of(arrival.sender)]
            for part in its_own or self._parts.values():
                part.arrive(arrival, self._timeout)

    def _arrive(self, sender: str, now: float | None, number: int | None, values: Mapping[str, Any]) -> None:
        if number is not None and not isinstance(number, (int, float)):
            raise InputError(f"number must be a counter, a whole number; got {quote(number)}")
        name, at = _name(sender), moment(now)
        with self._lock:
            for part, value in values.items():
                self._parts[part].arrive(Arrival(name, at, value, number), self._timeout)

    def _look(self, now: float) -> tuple[dict[str, Arrival | None], dict[str, list[str]]]:
        """The last arrivals, and the names without a value that counts at `now` [s] by the reason."""
        faults: dict[str, list[str]] = {}
        with self._lock:
            for name, part in self._parts.items():
                if fault := part.fault(now, self._timeout, self._what, self.unread):
                    faults.setdefault(fault, []).append(name)
            return {name: part.last for name, part in self._parts.items()}, faults


def moment(now: float | None) -> float:
    """A time [s], by default that of the system's clock that is never set."""
    if now is None:
        return time.monotonic()
    return now if type(now) is float else as_number(now, "now [s]")


def _name(sender: str) -> str:
    return one_line(require(sender, str, "sender", "the name of who says it"), LONGEST_SENDER)


class Inbox(Arrivals):
    """A source that holds one command, put there by `put(sender, command)` from any thread.

    A command counts for `timeout` [s]: repeat it. Two senders within a timeout cancel each other. A refused message
    stops the arm. A message is dropped if its number does not exceed the sender's last one within a timeout. Only the
    latest messages are kept, so a flood takes no memory.
    """

    def __init__(self, timeout: float = MESSAGE_TIMEOUT) -> None:
        super().__init__(timeout, "command", [""])

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
                kinds = "a TwistCommand, JogCommand, PoseCommand or six numbers"
                raise InputError(f"a command is {kinds}: {error}") from error
        self._arrive(sender, now, number, {"": value})

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command of the one commander at `now` [s], or None and the reason.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.
        """
        now = moment(now)
        arrivals, faults = self._look(now)
        last, fault = arrivals[""], next(iter(faults), "")
        if last is None:
            return Reading(None, inf, fault + self.note, idle=True)
        age = now - last.time
        if not fault:
            return Reading(last.value, age)
        stopped = isinstance(last.value, JogCommand) and not last.value.theta_dot.any()
        return Reading(None, age, fault + self.note, idle=stopped and age > self.timeout)


class StateInbox(Arrivals):
    """A feedback of joint states put there by `put(sender, {joint: value})` or `put(sender, theta)` from any thread.

    The messages of several senders are merged. The joint state needs a value for every joint and is as old as the
    oldest. Each joint follows the rules of `Inbox`: one sender, increasing numbers. Other names are ignored, and named
    if theta is unknown. A refused message counts against all joints of its sender, or without one against every joint.

    units: "joint", or "motor" or "counts" for motors (`MotorSide`). They merge before theta is computed. So each motor
    of a differential may have its message.

    Raises InputError for a timeout that is not positive, and for units unknown to the arm.
    """

    def __init__(self, arm: Arm, timeout: float = MESSAGE_TIMEOUT, *, units: str = "joint") -> None:
        self.motors = motor_side(require_arm(arm), units)
        self.names = arm.joint_names if self.motors is None else self.motors.names
        super().__init__(timeout, "joint state" if self.motors is None else "motors' state", self.names)
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
        at = moment(now)
        try:
            values = self._values(state)
        except InputError as error:
            self.refuse(sender, str(error), at)
        else:
            self._arrive(sender, at, number, values)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s], or None and which joint it lacks, and why."""
        arrivals, faults = self._look(moment(now))
        time = min(-inf if arrival is None else arrival.time for arrival in arrivals.values())
        if not faults:
            values = [arrival.value for arrival in arrivals.values() if arrival is not None]
            return Measured(frozen(values) if self.motors is None else self.motors.theta(values), time)
        reason = "; ".join(
            fault if len(names) == len(self.names) else f"{fault} ({', '.join(names)})"
            for fault, names in faults.items()
        )
        if time == -inf and self._others:  # another name in the messages may be that of a joint with a slip
            missing = next(name for name, arrival in arrivals.items() if arrival is None)
            reason += f"; a message named {listed(self._others, 5)}" + closest(missing, self._others)
        return Measured(None, time, reason + self.note)

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


class MessageInput(ABC):
    """Texts that arrive on a line, read once a cycle into `inbox`, malformed ones included.

    Texts that waited for longer than a timeout are dropped, because their age is unknown. Of a flood the last
    `MOST_TEXTS` count, together no longer than one message. The rest is not read.
    """

    def __init__(self, inbox: Inbox | StateInbox, parse: Callable[[bytes], tuple[Any, int | None]]) -> None:
        self.interlock = Interlock()
        self._inbox, self._parse = inbox, parse
        self._looked = -inf

    @abstractmethod
    def arrivals(self) -> Iterable[tuple[str, bytes]]:
        """(sender, text) of all that has arrived."""

    def _take(self, now: float) -> None:
        """Put all that has arrived by `now` [s] into the inbox."""
        missed, self._looked = now - self._looked > self._inbox.timeout, now
        arrived = deque((pair for pair in self.arrivals() if not self._obey(pair[1], not missed)), MOST_TEXTS)
        while len(arrived) > 1 and sum(len(text) for _, text in arrived) > LARGEST_MESSAGE:
            arrived.popleft()
        if missed:
            self._inbox.unread = now if arrived else self._inbox.unread
            return
        for sender, text in arrived:
            self._put(sender, text, now)

    def _put(self, sender: str, text: bytes, now: float) -> None:
        try:
            value, number = self._parse(text)
        except InputError as error:
            self._inbox.refuse(sender, str(error), now)
        else:
            self._inbox.put(sender, value, now, number)

    def _obey(self, text: bytes, fresh: bool) -> bool:
        """Whether a text was an interlock message, which is then obeyed."""
        return False


class CommandInput(MessageInput):
    """A source of commands and interlock messages as JSON (`command_of`)."""

    def _begin(self, arm: Arm, timeout: float, units: str) -> None:
        require_arm(arm)
        require_choice(units, ("joint",), "units of commands")
        self._commands = Inbox(timeout)
        super().__init__(self._commands, lambda text: parse_command(arm, text))

    def _obey(self, text: bytes, fresh: bool) -> bool:
        return obey_interlock_message(self.interlock, text, fresh)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all that has arrived, or None and the reason."""
        self._take(now)
        return self._commands.read(now)


class StateInput(MessageInput):
    """A feedback of joint states. If the robot may not move, neither may the stream."""

    _state_of: Callable[[Arm, bytes, MotorSide | None], StateMessage]

    def _begin(self, arm: Arm, timeout: float, units: str) -> None:
        self._states = StateInbox(arm, timeout, units=units)
        self.motors = self._states.motors

        def parsed(text: bytes) -> tuple[Any, int | None]:
            state = self._state_of(arm, text, self.motors)
            self.interlock.mirror(state.interlock, "the robot")
            return state.values, state.number

        super().__init__(self._states, parsed)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all that has arrived, or None and the reason."""
        self._take(now)
        return self._states.read(now)
