"""UDP: commands and joint states in, setpoints out, one JSON message per datagram; see docs/streaming.md."""

from __future__ import annotations

from collections.abc import Collection

from ....arm.arm import Arm, require_arm
from ....support.strict_json import encode
from ..motors import motor_side
from ..protocols import Setpoint, UndeliveredError
from .inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from .intake import CommandLink, StateLink
from .messages import parse_state, setpoint_message
from .signing import Signer
from .sockets import Receiver, Sender

LOOPBACK = "127.0.0.1"
"""The default host: nobody but programs on this machine may move the arm."""


class UdpSource(Receiver, CommandLink):
    """Commands from datagrams to host and port (0: a free one, see `address`). A sender is an address with its port.

    senders: allowed hosts, empty for all. key: the key that signs the datagrams (see `Signer`, `read_key`). Raises
    InputError for an unusable host or port, and for an invalid key.
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
        CommandLink.__init__(self, arm, timeout)
        Receiver.__init__(self, host, port, senders, key)


class UdpFeedback(Receiver, StateLink):
    """Joint states from datagrams to host and port (0: a free one, see `address`); senders and key as in `UdpSource`.

    units: "joint", or "motor" or "counts" for a robot that reports its motors (see `MotorSide`).

    Raises InputError for an unusable host or port, and for an invalid key.
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
        StateLink.__init__(self, arm, timeout, units, parse_state)
        Receiver.__init__(self, host, port, senders, key)


class UdpSink(Sender):
    """Setpoints as datagrams to host and port, signed if there is a key (see `Signer`).

    units: "joint", or "motor" or "counts" to include the motors (see `MotorSide`).

    Raises InputError for an unusable host or port, and for an invalid key.
    """

    def __init__(
        self, arm: Arm, host: str = LOOPBACK, port: int = 0, *, key: bytes | None = None, units: str = "joint"
    ) -> None:
        self._arm = require_arm(arm)
        self._motors = motor_side(arm, units)
        self._signer = None if key is None else Signer(key)
        super().__init__(host, port)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises `UndeliveredError` without a listener, OSError if it cannot send."""
        text = encode(setpoint_message(self._arm, setpoint, self._motors)).encode()
        if not self.send(text if self._signer is None else self._signer.sign(text)):
            raise UndeliveredError(f"nobody listens at {self.receiver}")
