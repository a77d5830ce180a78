"""Setpoints and joint states as short lines with a checksum, for microcontrollers; see docs/streaming.md.

setpoint: `number,theta_1,…,theta_n,rate_1,…,rate_n*hh`; joint state: `number,theta_1,…,theta_n*hh`. Base to tip, rad,
m, rad/s, m/s with six decimals; hh is the exclusive or of all bytes before the `*`, two hexadecimal digits (NMEA 0183).
"""

from __future__ import annotations

from functools import reduce
from operator import xor

import numpy as np

from ..arm import Arm
from ..checks import as_theta
from ..errors import InputError
from ..strict_json import counter, short
from .messages import StateMessage
from .protocols import Setpoint

LONGEST_LINE = 4096
"""Bytes: a joint state of 250 joints is half of it."""


def setpoint_line(setpoint: Setpoint) -> bytes:
    """The setpoint as a line, its end included."""
    values = np.concatenate([setpoint.theta, setpoint.theta_dot]).tolist()
    body = ",".join([str(setpoint.number), *(f"{value:.6f}" for value in values)]).encode()
    return body + b"*%02X\n" % checksum(body)


def parse_state_line(arm: Arm, line: bytes) -> StateMessage:
    """The joint state in a line; InputError for anything but a number and n finite values with their checksum."""
    body, star, given = line.strip().rpartition(b"*")
    if len(line) > LONGEST_LINE or not star:
        raise InputError(f"a joint state line ends with * and a checksum; got {short(line)}")
    if given.upper() != b"%02X" % checksum(body):
        raise InputError(f"the checksum of a joint state line is {checksum(body):02X}; got {short(given)}")
    try:
        number, *values = body.decode("ascii").split(",")
        theta = as_theta([float(value) for value in values], arm.n, "the joint state line", arm.joint_names)
        return StateMessage(theta, counter(int(number), "number"))
    except ValueError as error:  # InputError is one
        raise InputError(f"a joint state line is number,theta_1,…,theta_{arm.n}*hh: {error}") from error


def checksum(body: bytes) -> int:
    """The exclusive or of all bytes."""
    return reduce(xor, body, 0)
