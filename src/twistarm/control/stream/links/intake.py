"""Lines of arriving texts, read once a cycle: each sender's last messages, malformed ones included."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from dataclasses import replace
from math import inf
from typing import Any

from ....arm.arm import Arm, require_arm
from ....support.errors import InputError
from ....support.strict_json import LARGEST_MESSAGE
from ...servo import ServoState
from ..interlock import Interlock
from ..motors import MotorSide
from ..protocols import Measured, Reading
from .inbox import Inbox, StateInbox
from .messages import StateMessage, heard_word, parse_command


class MessageInput(ABC):
    """A line on which texts arrive for an inbox.

    Texts that waited for longer than a timeout are dropped, because their age is unknown. The last `each` texts of at
    most `senders` senders count. Together they are no longer than one message. The rest of a flood is not read. `note`:
    what a reason adds where no message counts.
    """

    note = ""
    senders, each = 3, 1
    """Two senders of commands are one too many already."""

    def __init__(self, arm: Arm, inbox: Inbox | StateInbox) -> None:
        self.interlock = Interlock()
        self._arm, self._inbox = arm, inbox
        self._looked = -inf

    @abstractmethod
    def arrivals(self) -> Iterable[tuple[Hashable, bytes]]:
        """(sender, text) of all that has arrived."""

    @abstractmethod
    def _parsed(self, text: bytes) -> tuple[Any, int | None]:
        """The value and its number in a text. Raises InputError otherwise."""

    def _heard(self, text: bytes, fresh: bool) -> bool:
        """Whether a text was an interlock message, which is then handled."""
        return False

    def sender_name(self, sender: Any) -> str:
        """The sender in words."""
        return str(sender)

    def _take(self, now: float) -> None:
        """Put all that has arrived by `now` [s] into the inbox."""
        last: dict[Hashable, deque[bytes]] = {}
        missed, self._looked = now - self._looked > self._inbox.timeout, now
        for sender, text in self.arrivals():
            if self._heard(text, not missed) or (sender not in last and len(last) >= self.senders):
                continue
            texts = last[sender] = last.pop(sender, deque(maxlen=self.each))  # the last sender is the last in the dict
            texts.append(text)
            while len(texts) > 1 and sum(map(len, texts)) > LARGEST_MESSAGE:
                texts.popleft()
        for sender, texts in last.items() if not missed else ():
            for text in texts:
                self._put(self.sender_name(sender), text, now)

    def _put(self, sender: str, text: bytes, now: float) -> None:
        try:
            value, number = self._parsed(text)
        except InputError as error:
            self._inbox.refuse(sender, str(error), now)
        else:
            self._inbox.put(sender, value, now, number)


class CommandInput(MessageInput):
    """A source of commands and interlock messages as JSON (`command_of`)."""

    def __init__(self, arm: Arm, timeout: float) -> None:
        self._commands = Inbox(timeout)
        super().__init__(require_arm(arm), self._commands)

    def _parsed(self, text: bytes) -> tuple[Any, int | None]:
        return parse_command(self._arm, text)

    def _heard(self, text: bytes, fresh: bool) -> bool:
        return heard_word(self, text, fresh)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all that has arrived.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        self._take(now)
        reading = self._commands.read(now)
        return reading if reading.command is not None else replace(reading, reason=reading.reason + self.note)


class StateInput(MessageInput):
    """A feedback of joint states, which `parse(arm, text, motors)` reads.

    If the robot may not move, neither may the stream.
    """

    senders, each = 16, 32
    """A robot may have a sender for each bus, and a message for each joint."""

    def __init__(
        self, arm: Arm, timeout: float, units: str, parse: Callable[[Arm, bytes, MotorSide | None], StateMessage]
    ) -> None:
        self._states = StateInbox(arm, timeout, units=units)
        self.motors = self._states.motors
        self._parse = parse
        super().__init__(arm, self._states)

    def _parsed(self, text: bytes) -> tuple[Any, int | None]:
        state = self._parse(self._arm, text, self.motors)
        self.interlock.follow(state.interlock, "the robot")
        return state.values, state.number

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all that has arrived."""
        self._take(now)
        measured = self._states.read(now)
        return measured if measured.theta is not None else replace(measured, reason=measured.reason + self.note)
