"""Serial ports, with a pseudo-terminal for the wire."""

from __future__ import annotations

import os
import sys
from contextlib import suppress

import numpy as np
import pytest

from stream_stand_ins import FakeClock, Robot, Says, answer
from twistarm.control.stream import Ending, SerialRobot, SerialSource, Setpoint, run
from twistarm.control.stream.serial_link import checksum, parse_state_line, setpoint_line
from twistarm.support.errors import InputError, MissingExtraError


@pytest.fixture
def wire():
    """(our end of the wire, the path of the port)."""
    ours, theirs = os.openpty()
    yield ours, os.ttyname(theirs)
    for end in (ours, theirs):
        with suppress(OSError):
            os.close(end)


def test_a_setpoint_as_a_line_with_the_checksum_of_nmea():
    # The sentence of the NMEA 0183 examples: $GPGLL,5300.97914,N,00259.98174,E,125926,A*28
    assert checksum(b"GPGLL,5300.97914,N,00259.98174,E,125926,A") == 0x28
    rates = np.array([0.5, -0.25])
    line = setpoint_line(Setpoint(7, 1.0, np.array([1.0, -2.0000004]), rates, answer(rates)))
    body = b"7,1.000000,-2.000000,0.500000,-0.250000,E0"
    assert line == body + b"*%02X\n" % checksum(body)


def state_line(rover, number=3, values=(1, 2, 3, 4, 5)):
    body = ",".join(map(str, (number, *values))).encode()
    return body + b"*%02x\r\n" % checksum(body)


def test_a_joint_state_as_a_line(rover):
    values = dict(zip(rover.joint_names, [1.0, 2.0, 3.0, 4.0, 5.0], strict=True))
    assert parse_state_line(rover, state_line(rover)) == (values, 3, None)
    assert parse_state_line(rover, state_line(rover, values=(1, 2, 3, 4, 5, "X"))).interlock == "emergency stop"


def test_no_beginning_and_no_single_wrong_byte_of_a_line_passes(rover):
    line = state_line(rover, values=(0.1, -0.2, 0.3, 4e-1, 0.5)).strip()
    for end in range(len(line)):
        with pytest.raises(InputError):
            parse_state_line(rover, line[:end])
    for k in range(len(line)):
        wrong = line[:k] + bytes([line[k] ^ 0x01]) + line[k + 1 :]
        with pytest.raises(InputError):
            parse_state_line(rover, wrong)


@pytest.mark.parametrize(
    ("number", "values", "why"),
    [
        (1, (1, 2, 3, 4), "must have shape"),
        (1, (1, 2, 3, 4, "nan"), "must be finite"),
        (-1, (1, 2, 3, 4, 5), "number must be a whole number"),
        (1, (1,) * 4000, r"ends with \* and a checksum"),
    ],
)
def test_what_is_no_joint_state_is_refused(rover, number, values, why):
    with pytest.raises(InputError, match=why):
        parse_state_line(rover, state_line(rover, number, values))


def test_commands_as_lines_of_json_even_in_pieces(rover, wire):
    ours, port = wire
    with SerialSource(rover, port) as source:
        assert source.read(1.0).reason == "no command has arrived"
        os.write(ours, b'{"jog": {"elb')
        assert source.read(1.05).command is None
        os.write(ours, b'ow": 0.1}}\n{"jog"')
        assert source.read(1.1).command.theta_dot[2] == 0.1
        os.write(ours, b": 3}\n")
        assert f"command from {port} refused: jog must be" in source.read(1.15).reason


def test_a_line_without_end_is_let_go(rover, wire):
    ours, port = wire
    with SerialSource(rover, port) as source:
        for k in range(5):
            os.write(ours, b"x" * 1000)
            source.read(1.0 + 0.01 * k)
        os.write(ours, b'{"stop": true}\n')  # a line of its own, as nothing is left of the other
        assert source.read(1.1).command is not None


def test_a_wire_that_is_pulled_ends_the_stream(rover, wire):
    ours, port = wire
    clock = FakeClock()
    arm = Robot(rover.ready, clock)
    with SerialSource(rover, port) as source:

        def operate(cycle):
            if cycle.time < 100.5:
                os.write(ours, b'{"jog": {"elbow": -0.2}}\n')
            elif cycle.time < 100.505:
                os.close(ours)

        report = run(rover, source, arm, arm, duration=3.0, clock=clock, on_cycle=operate)
    assert report.ending is Ending.SOURCE_FAILED
    assert report.at_rest
    assert not arm.rates[-1].any()
    assert arm.moving(100.0) < 0.5 + 0.3


def test_a_wire_that_is_too_slow_fails_and_does_not_hold_the_loop(rover, wire):
    _, port = wire
    clock = FakeClock()
    arm = Robot(rover.ready, clock)
    with SerialRobot(rover, port) as sink:  # nobody reads at the other end, and its buffer fills
        report = run(rover, Says(None), sink, arm, duration=30.0, clock=clock)
    assert report.ending is Ending.SINK_FAILED
    assert "imeout" in report.reason


def test_a_port_that_is_none_and_one_without_pyserial(rover, monkeypatch):
    with pytest.raises(InputError, match="cannot open serial port '/dev/none' at 115200 baud"):
        SerialRobot(rover, "/dev/none")
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'twistarm\[serial\]'"):
        SerialSource(rover, "/dev/ttyUSB0")
