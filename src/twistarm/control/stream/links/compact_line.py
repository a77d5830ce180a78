"""Setpoints and joint states as short lines with a checksum, for microcontrollers; see docs/streaming.md.

setpoint: `number,theta_1,…,theta_n,rate_1,…,rate_n,ES*hh`; joint state: `number,theta_1,…,theta_n*hh`, or with `,E`
after theta_n. The order is base to tip, in rad, m, rad/s, m/s with six decimals. E is the interlock's or the robot's
state: E enabled, S stopped, X emergency stop. S is the servo's status, a digit in the order of `ServoStatus`. hh is the
exclusive or of all bytes before the `*` in two hexadecimal digits (NMEA 0183).
"""

from __future__ import annotations

from functools import reduce
from operator import xor

import numpy as np

from ....arm.arm import Arm
from ....support.checks import as_theta
from ....support.errors import InputError
from ....support.strict_json import counter, short
from ...servo import ServoStatus
from ..interlock import EMERGENCY_STOP, ENABLED, STOPPED
from ..motors import MotorSide
from ..protocols import Setpoint
from .messages import StateMessage

LETTERS = {ENABLED: "E", STOPPED: "S", EMERGENCY_STOP: "X"}

STATE_OF = {letter: word for word, letter in LETTERS.items()}

STATUSES = tuple(ServoStatus)

LONGEST_LINE = 4096
"""Bytes: a joint state of 250 joints is half of it."""


def setpoint_line(setpoint: Setpoint, motors: MotorSide | None = None) -> bytes:
    """The setpoint as a line with its end, of `motors` in place of joints if given."""
    values = np.concatenate(motors.of(setpoint) if motors else (setpoint.theta, setpoint.theta_dot)).tolist()
    state = f"{LETTERS[setpoint.interlock]}{STATUSES.index(setpoint.output.status)}"
    body = ",".join([str(setpoint.number), *(f"{value:.6f}" for value in values), state]).encode()
    return body + b"*%02X\n" % checksum(body)


def parse_state_line(arm: Arm, line: bytes, motors: MotorSide | None = None) -> StateMessage:
    """The joint state in a line. Raises InputError unless it is a number, n finite values and the checksum."""
    body, star, given = line.strip().rpartition(b"*")
    if len(line) > LONGEST_LINE or not star:
        raise InputError(f"a joint state line ends with * and a checksum; got {short(line)}")
    if given.upper() != b"%02X" % checksum(body):
        raise InputError(f"the checksum of a joint state line is {checksum(body):02X}; got {short(given)}")
    try:
        number, *values = body.decode("ascii").split(",")
        interlock = STATE_OF.get(values[-1]) if values else None
        values = values[:-1] if interlock else values
        said = [float(value) for value in values]
        names = motors.names if motors else arm.joint_names
        as_theta(said, len(names), "the joint state line", names)
        return StateMessage(dict(zip(names, said, strict=True)), counter(int(number), "number"), interlock)
    except ValueError as error:  # InputError is one
        raise InputError(f"a joint state line is number,theta_1,…,theta_{arm.n}[,E|S|X]*hh: {error}") from error


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes."""
    return reduce(xor, body, 0)
