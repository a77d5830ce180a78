"""UDP: commands and joint states in, setpoints out, one JSON message to a datagram; see docs/streaming.md."""

from __future__ import annotations

from functools import partial

from ..arm import Arm
from ..servo import ServoState
from ..strict_json import encode
from .inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT, Inbox, StateInbox
from .intake import Intake
from .interlock import Interlock
from .messages import followed, heard_word, parse_command, parse_state, setpoint_message
from .protocols import Measured, Reading, Setpoint, UndeliveredError
from .sockets import Receiver, Sender, named

LOOPBACK = "127.0.0.1"
"""The default host: nobody but programs on this machine may move the arm."""


class UdpSource(Receiver):
    """Commands from datagrams to host and port (0: a free one, see `address`). A sender is an address with its port.

    Raises InputError for a host or port that cannot be had.
    """

    def __init__(self, arm: Arm, host: str = LOOPBACK, port: int = 0, *, timeout: float = COMMAND_TIMEOUT) -> None:
        self.interlock = Interlock()
        self._inbox = Inbox(timeout)
        self._intake = Intake(self._inbox, partial(parse_command, arm), partial(heard_word, self))
        super().__init__(host, port)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all datagrams that have arrived."""
        self._intake.take(self.waiting(), now, named)
        return self._inbox.read(now)


class UdpFeedback(Receiver):
    """Joint states from datagrams to host and port (0: a free one, see `address`).

    Raises InputError for a host or port that cannot be had.
    """

    def __init__(self, arm: Arm, host: str = LOOPBACK, port: int = 0, *, timeout: float = FEEDBACK_TIMEOUT) -> None:
        self.interlock = Interlock()
        self._states = StateInbox(timeout)
        self._intake = Intake(self._states, partial(followed, self, partial(parse_state, arm)))
        super().__init__(host, port)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all datagrams that have arrived."""
        self._intake.take(self.waiting(), now, named)
        return self._states.read(now)


class UdpSink(Sender):
    """Setpoints as datagrams to host and port. Raises InputError for a host or port that cannot be."""

    def __init__(self, arm: Arm, host: str, port: int) -> None:
        self._arm = arm
        super().__init__(host, port)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises `UndeliveredError` where nobody seems to listen, OSError where it cannot."""
        if not self.send(encode(setpoint_message(self._arm, setpoint)).encode()):
            raise UndeliveredError(f"nobody listens at {self.receiver}")
