"""Serial ports: commands as JSON lines, a robot by compact lines with a checksum (docs/streaming.md).

setpoint: `number,theta_1,…,theta_n,rate_1,…,rate_n,ES*hh`; joint state: `number,theta_1,…,theta_n*hh`, or with `,E`
after theta_n. The order is base to tip, in rad, m, rad/s, m/s with six decimals. E is the interlock's or the robot's
state: E enabled, S stopped, X emergency stop. S is the servo's status, a digit in the order of `STATUSES`. hh is the
XOR of all bytes before the `*`, in two hexadecimal digits (NMEA 0183).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from operator import xor
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import as_theta, as_whole
from ...support.errors import InputError, missing_extra, quote
from ...support.interrupts import Closeable
from ..servo import STATUSES
from .inbox import CommandInput, StateInput
from .messages import MotorSide, StateMessage
from .protocols import EMERGENCY_STOP, ENABLED, MESSAGE_TIMEOUT, STOPPED, Setpoint

LETTERS = {ENABLED: "E", STOPPED: "S", EMERGENCY_STOP: "X"}

STATE_OF = {letter: word for word, letter in LETTERS.items()}

LONGEST_LINE = 4096  # Most bytes of a line: twice a joint state of 250 joints.

LARGEST_BAUDRATE = 10**9

BAUDRATE = 115_200  # Default baud rate: 11.5 kB/s, enough for setpoints of six joints at 100 Hz.
# Most seconds of a write. pyserial also counts time in which a busy computer delays the program. A link that needs
# longer is too slow for any rate.
LONGEST_WRITE = 0.05
MOST_PER_CYCLE = 16 * 1024  # Bytes read in one cycle: ten times what 1 Mbaud brings in 10 ms.


def setpoint_line(setpoint: Setpoint, motors: MotorSide | None = None) -> bytes:
    """The setpoint as a line with its end. `motors`, if given, replace the joints."""
    values = np.concatenate(motors.of(setpoint) if motors else (setpoint.theta, setpoint.theta_dot)).tolist()
    state = f"{LETTERS[setpoint.interlock]}{STATUSES.index(setpoint.output.status)}"
    body = ",".join([str(setpoint.number), *(f"{value:.6f}" for value in values), state]).encode()
    return body + b"*%02X\n" % checksum(body)


def parse_state_line(arm: Arm, line: bytes, motors: MotorSide | None = None) -> StateMessage:
    """The joint state in a line. Raises InputError unless it is a number, n finite values and the checksum."""
    body, star, given = line.strip().rpartition(b"*")
    if len(line) > LONGEST_LINE or not star:
        raise InputError(f"a joint state line ends with * and a checksum; got {quote(line)}")
    if given.upper() != b"%02X" % checksum(body):
        raise InputError(f"the checksum of a joint state line is {checksum(body):02X}; got {quote(given)}")
    try:
        number, *values = body.decode("ascii").split(",")
        interlock = STATE_OF.get(values[-1]) if values else None
        values = values[:-1] if interlock else values
        names = motors.names if motors else arm.joint_names
        theta = as_theta([float(value) for value in values], len(names), "the joint state line", names).tolist()
        return StateMessage(dict(zip(names, theta, strict=True)), as_whole(int(number), "number"), interlock)
    except ValueError as error:  # InputError is one
        raise InputError(f"a joint state line is number,theta_1,…,theta_{arm.n}[,E|S|X]*hh: {error}") from error


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes."""
    return reduce(xor, body, 0)


class SerialLines(Closeable):
    """A serial port read and written in lines, a context manager.

    timeout [s]: how long a message counts. units: "joint"; of a robot also "motor" or "counts" (see `MotorSide`).
    Raises InputError for a port that cannot be opened, MissingExtraError without pyserial.
    """

    _begin: Callable[..., None]

    def __init__(
        self, arm: Arm, port: str, baudrate: int = BAUDRATE, *, timeout: float = MESSAGE_TIMEOUT, units: str = "joint"
    ) -> None:
        self._begin(arm, timeout, units)
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


class SerialSource(SerialLines, CommandInput):
    """Commands as lines of JSON (`command_of`) from a box of controls at a serial port."""


class SerialRobot(SerialLines, StateInput):
    """A robot at a serial port: setpoint lines out, joint state lines in."""

    _state_of = staticmethod(parse_state_line)

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
        raise InputError(f"cannot open serial port {quote(port)} at {baudrate} baud: {error}") from error
