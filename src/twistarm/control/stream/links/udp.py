"""UDP: commands and joint states in, setpoints out, one JSON message to a datagram; see docs/streaming.md."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial

from ....arm.arm import Arm, require_arm
from ....support.strict_json import encode
from ...servo import ServoState
from ..interlock import Interlock
from ..motors import motor_side
from ..protocols import Measured, Reading, Setpoint, UndeliveredError
from .inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT, Inbox
from .intake import STATE_SENDERS, STATES_EACH, Intake
from .messages import followed, heard_word, parse_command, parse_state, setpoint_message
from .signing import Signer
from .sockets import Receiver, Sender, named
from .state_inbox import StateInbox

LOOPBACK = "127.0.0.1"
"""The default host: nobody but programs on this machine may move the arm."""


class UdpSource(Receiver):
    """Commands from datagrams to host and port (0: a free one, see `address`). A sender is an address with its port.

    senders: hosts that may send, none: all. key: what must sign the datagrams (see `Signer`, `read_key`). Raises
    InputError for a host or port that cannot be had, and for a key that is none.
    """

    def __init__(
        self,
        arm: Arm,
        host: str = LOOPBACK,
        port: int = 0,
        *,
        timeout: float = COMMAND_TIMEOUT,
        senders: Collection[str] = (),
        key: bytes | None = None,
    ) -> None:
        require_arm(arm)
        self.interlock = Interlock()
        self._inbox = Inbox(timeout)
        self._intake = Intake(self._inbox, partial(parse_command, arm), partial(heard_word, self))
        super().__init__(host, port, senders, key)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all datagrams that have arrived.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        self._intake.take(self.admitted(), now, named)
        reading = self._inbox.read(now)
        return reading if reading.command is not None else replace(reading, reason=reading.reason + self.note)


class UdpFeedback(Receiver):
    """Joint states from datagrams to host and port (0: a free one, see `address`); senders and key as in `UdpSource`.

    units: "joint", or "motor" or "counts" where the robot tells of its motors (see `MotorSide`).

    Raises InputError for a host or port that cannot be had, and for a key that is none.
    """

    def __init__(
        self,
        arm: Arm,
        host: str = LOOPBACK,
        port: int = 0,
        *,
        timeout: float = FEEDBACK_TIMEOUT,
        senders: Collection[str] = (),
        key: bytes | None = None,
        units: str = "joint",
    ) -> None:
        self.interlock = Interlock()
        self._states = StateInbox(arm, timeout, units=units)
        self._intake = Intake(
            self._states, partial(followed, self, partial(parse_state, arm, motors=motor_side(arm, units))),
            senders=STATE_SENDERS, each=STATES_EACH,
        )  # fmt: skip
        super().__init__(host, port, senders, key)

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all datagrams that have arrived."""
        self._intake.take(self.admitted(), now, named)
        measured = self._states.read(now)
        return measured if measured.theta is not None else replace(measured, reason=measured.reason + self.note)


class UdpSink(Sender):
    """Setpoints as datagrams to host and port, signed where there is a key (see `Signer`).

    units: "joint", or "motor" or "counts" for the motors too (see `MotorSide`).

    Raises InputError for a host or port that cannot be, and for a key that is none.
    """

    def __init__(
        self, arm: Arm, host: str = LOOPBACK, port: int = 0, *, key: bytes | None = None, units: str = "joint"
    ) -> None:
        self._arm = require_arm(arm)
        self._motors = motor_side(arm, units)
        self._signer = None if key is None else Signer(key)
        super().__init__(host, port)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises `UndeliveredError` where nobody seems to listen, OSError where it cannot."""
        text = encode(setpoint_message(self._arm, setpoint, self._motors)).encode()
        if not self.send(text if self._signer is None else self._signer.sign(text)):
            raise UndeliveredError(f"nobody listens at {self.receiver}")
