"""Serial ports: commands as lines of JSON, a robot by compact lines; see docs/streaming.md."""

from __future__ import annotations

from typing import Any

from ....arm.arm import Arm
from ....support.checks import as_whole
from ....support.closeable import Closeable
from ....support.errors import InputError, missing_extra, shown
from ..protocols import Setpoint
from .compact_line import LONGEST_LINE, parse_state_line, setpoint_line
from .inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from .intake import CommandLink, StateLink

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

    def arrivals(self) -> list[tuple[str, bytes]]:
        """(port, line) for each line that is complete by now. Raises OSError where the port is gone."""
        text = self._rest + self._serial.read(MOST_PER_CYCLE)
        *lines, rest = text.split(b"\n")
        # Of a line without end nothing is kept: what comes later is judged as a line of its own.
        self._rest = rest if len(rest) <= LONGEST_LINE else b""
        return [(self.port, line) for line in lines if line.strip()]

    def send(self, line: bytes) -> None:
        """Write a line. Raises OSError where the port is gone or too slow."""
        self._serial.write(line)

    def close(self) -> None:
        """Give the port back. Harmless when repeated."""
        self._serial.close()


class SerialSource(SerialLines, CommandLink):
    """Commands as lines of JSON (`command_of`) from a box of controls at a serial port."""

    def __init__(self, arm: Arm, port: str, baudrate: int = BAUDRATE, *, timeout: float = COMMAND_TIMEOUT) -> None:
        CommandLink.__init__(self, arm, timeout)
        SerialLines.__init__(self, port, baudrate)


class SerialRobot(SerialLines, StateLink):
    """A robot at a serial port: a sink of setpoint lines and a feedback of joint state lines (`compact_line`).

    units: "joint", or "motor" or "counts" for a robot that knows only its motors (see `MotorSide`).
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
        StateLink.__init__(self, arm, timeout, units, parse_state_line)
        SerialLines.__init__(self, port, baudrate)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint. Raises OSError where the port is gone or too slow."""
        self.send(setpoint_line(setpoint, self.motors))


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
