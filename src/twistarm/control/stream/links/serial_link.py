"""Serial ports: commands from a box of controls as lines of JSON, a robot on compact lines; see docs/streaming.md."""

from __future__ import annotations

from functools import partial
from typing import Any

from ....arm.arm import Arm
from ....support.checks import as_whole
from ....support.closeable import Closeable
from ....support.errors import InputError, missing_extra, shown
from ...servo import ServoState
from ..interlock import Interlock
from ..motors import motor_side
from ..protocols import Measured, Reading, Setpoint
from .compact_line import LONGEST_LINE, parse_state_line, setpoint_line
from .inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT, Inbox
from .intake import Intake
from .messages import followed, heard_word, parse_command
from .state_inbox import StateInbox

LARGEST_BAUDRATE = 10**9

BAUDRATE = 115_200
"""The default; 11.5 kB/s: setpoints of six joints at 100 Hz."""

LONGEST_WRITE = 0.05
"""Seconds a write may take: pyserial counts those in which a busy computer let the program wait, too. A link that needs
longer is too slow for any rate."""

MOST_PER_CYCLE = 16 * 1024
"""Bytes read in one cycle: ten times what 1 Mbaud brings in 10 ms."""


class SerialLines(Closeable):
    """A serial port read and written in lines, a context manager.

    Raises InputError for a port that cannot be opened, MissingExtraError without pyserial.
    """

    def __init__(self, port: str, baudrate: int) -> None:
        self.port = port
        self._serial = _opened(port, baudrate)
        self._rest = b""

    def lines(self) -> list[tuple[str, bytes]]:
        """(port, line) for each line that is complete by now. Raises OSError where the port is gone."""
        text = self._rest + self._serial.read(MOST_PER_CYCLE)
        *lines, rest = text.split(b"\n")
        # A line without end: what comes later is judged as a line of its own, and refused.
        self._rest = rest if len(rest) <= LONGEST_LINE else b""
        return [(self.port, line) for line in lines if line.strip()]

    def send(self, line: bytes) -> None:
        """Write a line. Raises OSError where the port is gone or too slow."""
        self._serial.write(line)

    def close(self) -> None:
        """Give the port back. Harmless when repeated."""
        self._serial.close()


class SerialSource(SerialLines):
    """Commands as lines of JSON, as in datagrams (`command_of`), from a box of controls at a serial port."""

    def __init__(self, arm: Arm, port: str, baudrate: int = BAUDRATE, *, timeout: float = COMMAND_TIMEOUT) -> None:
        self.interlock = Interlock()
        self._inbox = Inbox(timeout)
        self._intake = Intake(self._inbox, partial(parse_command, arm), partial(heard_word, self))
        super().__init__(port, baudrate)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command at `now` [s] of all lines that have arrived.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        self._intake.take(self.lines(), now, str)
        return self._inbox.read(now)


class SerialRobot(SerialLines):
    """A robot at a serial port: a sink of setpoint lines and a feedback of joint state lines (`compact_line`).

    units: "joint", or "motor" or "counts" for a robot that knows its motors alone (see `MotorSide`).
    """

    def __init__(
        self,
        arm: Arm,
        port: str,
        baudrate: int = BAUDRATE,
        *,
        timeout: float = FEEDBACK_TIMEOUT,
        units: str = "joint",
    ) -> None:
        self._motors = motor_side(arm, units)
        self.interlock = Interlock()
        self._states = StateInbox(arm, timeout, units=units)
        self._intake = Intake(
            self._states, partial(followed, self, partial(parse_state_line, arm, motors=self._motors))
        )
        super().__init__(port, baudrate)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises OSError where the port is gone or too slow."""
        self.send(setpoint_line(setpoint, self._motors))

    def read(self, now: float) -> Measured:
        """The joint state at `now` [s] of all lines that have arrived."""
        self._intake.take(self.lines(), now, str)
        return self._states.read(now)


def _opened(port: str, baudrate: int) -> Any:
    as_whole(baudrate, "baudrate", 1, LARGEST_BAUDRATE)
    try:
        import serial
    except ImportError as error:
        raise missing_extra("a serial port", "pyserial", "serial") from error
    try:
        return serial.Serial(port, baudrate, timeout=0, write_timeout=LONGEST_WRITE, exclusive=True)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot open serial port {shown(port)} at {baudrate} baud: {error}") from error
