"""The intake of texts, read once a cycle: the last messages of each sender, malformed ones included."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

from ....arm.arm import Arm, require_arm
from ....support.errors import InputError
from ....support.strict_json import LARGEST_MESSAGE
from ...servo import ServoState
from ..interlock import Interlock
from ..motors import MotorSide, motor_side
from ..protocols import Measured, Reading
from .inbox import Inbox
from .messages import StateMessage, heard_word, parse_command
from .state_inbox import StateInbox

MOST_SENDERS = 3
"""Senders of commands told apart in one cycle: two are one too many already."""

STATE_SENDERS, STATES_EACH = 16, 32
"""Of joint states: a robot may have a sender for each bus, and a message for each joint."""


class Intake:
    """Fill `inbox` with `parse(text)`: (value, number), or an InputError.

    Texts that waited for longer than a timeout are dropped, because their age is unknown. `heard(text, fresh)` first
    sees each text and says whether it was an interlock message. The last `each` texts of at most `senders` senders
    count, together no longer than one message may be. The rest of a flood is not read.
    """

    def __init__(
        self,
        inbox: Inbox | StateInbox,
        parse: Callable[[bytes], tuple[Any, int | None]],
        heard: Callable[[bytes, bool], bool] = lambda text, fresh: False,
        *,
        senders: int = MOST_SENDERS,
        each: int = 1,
    ) -> None:
        self._senders, self._each = senders, each
        self._inbox, self._parse, self._heard = inbox, parse, heard
        self._looked = -inf

    def take(self, arrivals: Iterable[tuple[Hashable, bytes]], now: float, name: Callable[[Any], str]) -> None:
        """Read all that has arrived, (sender, text), at `now` [s]."""
        last: dict[Hashable, deque[bytes]] = {}
        missed, self._looked = now - self._looked > self._inbox.timeout, now
        for sender, text in arrivals:
            if self._heard(text, not missed):
                continue
            texts = last.pop(sender, None)
            if texts is not None or len(last) < self._senders:
                last[sender] = texts or deque(maxlen=self._each)
                last[sender].append(text)
                _keep_short(last[sender])
        for sender, texts in last.items() if not missed else ():
            for text in texts:
                self._put(name(sender), text, now)

    def _put(self, sender: str, text: bytes, now: float) -> None:
        try:
            value, number = self._parse(text)
        except InputError as error:
            self._inbox.refuse(sender, str(error), now)
        else:
            self._inbox.put(sender, value, now, number)


class Link(ABC):
    """A line on which texts arrive. `note`: what a reason adds where there is no message that counts."""

    note = ""

    @abstractmethod
    def arrivals(self) -> Iterable[tuple[Hashable, bytes]]:
        """(sender, text) of all that has arrived."""

    def sender_name(self, sender: Any) -> str:
        """The sender in words."""
        return str(sender)


class CommandLink(Link):
    """A source of commands and interlock messages as JSON (`command_of`)."""

    def __init__(self, arm: Arm, timeout: float) -> None:
        self.interlock = Interlock()
        self._inbox = Inbox(timeout)
        self._intake = Intake(self._inbox, partial(parse_command, require_arm(arm)), partial(heard_word, self))

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all that has arrived.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        self._intake.take(self.arrivals(), now, self.sender_name)
        reading = self._inbox.read(now)
        return reading if reading.command is not None else replace(reading, reason=reading.reason + self.note)


class StateLink(Link):
    """A feedback of joint states.

    If the robot may not move, neither may the stream.

    `parse(arm, text, motors)` reads them.
    """

    def __init__(
        self, arm: Arm, timeout: float, units: str, parse: Callable[[Arm, bytes, MotorSide | None], StateMessage]
    ) -> None:
        self.motors = motor_side(require_arm(arm), units)
        self.interlock = Interlock()
        self._states = StateInbox(arm, timeout, units=units)

        def followed(text: bytes) -> tuple[dict[str, float], int | None]:
            state = parse(arm, text, self.motors)
            self.interlock.follow(state.interlock, "the robot")
            return state.values, state.number

        self._intake = Intake(self._states, followed, senders=STATE_SENDERS, each=STATES_EACH)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all that has arrived."""
        self._intake.take(self.arrivals(), now, self.sender_name)
        measured = self._states.read(now)
        return measured if measured.theta is not None else replace(measured, reason=measured.reason + self.note)


def _keep_short(texts: deque[bytes]) -> None:
    """Drop the oldest texts, except the last, until all together are as short as one message may be."""
    size = sum(map(len, texts))
    while len(texts) > 1 and size > LARGEST_MESSAGE:
        size -= len(texts.popleft())
