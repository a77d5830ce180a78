"""Serial ports, with a pseudo-terminal for the wire, and values on the motors' side of a differential wrist."""

import json
import os
import sys
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from stream_stand_ins import FakeClock, Robot, Says, answer
from twistarm import Actuators
from twistarm.control.stream import (
    Ending,
    SerialRobot,
    SerialSource,
    Setpoint,
    StateInbox,
    UdpFeedback,
    UdpSource,
    parse_state,
    run,
    setpoint_message,
)
from twistarm.control.stream.messages import motor_side
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


NAMES = ("rail", "shoulder", "elbow", "left", "right")


@pytest.fixture
def driven(rover):
    """Gears 400, 100, −80; a differential of 60; ticks of 4096 a turn at the wrist; a shoulder's zero at 0.4 rad."""
    G = np.diag([400.0, 100.0, -80.0, 60.0, -60.0])
    G[3, 4] = G[4, 3] = 60.0
    ticks = np.array([np.nan, np.nan, np.nan, 4096, 4096])
    units = ("turn", "rad", "rad", "tick", "tick")
    return replace(rover, actuators=Actuators(NAMES, rover.joint_names, G, np.array([0, 0.4, 0, 0, 0]), units, ticks))


@pytest.fixture
def setpoint():
    rates = np.array([0.01, 0.2, 0.3, 0.5, 0.1])
    return Setpoint(7, 1.0, np.array([0.1, -0.5, 1.0, 0.25, -0.5]), rates, answer(rates))


MOTOR = [40.0, -49.6, -80.0, -15.0, 45.0]
MOTOR_DOT = [4.0, 20.0, -24.0, 36.0, 24.0]
TICKS = 4096 / (2 * np.pi)


def test_setpoints_in_motor_units_and_in_counts(driven, setpoint):
    message = setpoint_message(driven, setpoint, motor_side(driven, "motor"))
    assert (message["motor_names"], message["units"]) == (list(NAMES), "motor")
    assert message["motor"] == pytest.approx(MOTOR)
    assert message["motor_dot"] == pytest.approx(MOTOR_DOT)
    counted = setpoint_message(driven, setpoint, motor_side(driven, "counts"))
    assert counted["motor"] == pytest.approx([40 / (2 * np.pi), -49.6, -80, -15 * TICKS, 45 * TICKS])
    assert counted["motor_dot"][3:] == pytest.approx([36 * TICKS, 24 * TICKS])
    line = setpoint_line(setpoint, motor_side(driven, "motor"))
    assert [float(value) for value in line.split(b",")[1:-1]] == pytest.approx(MOTOR + MOTOR_DOT)


def test_joint_states_from_motors_in_any_order(driven, setpoint):
    side = motor_side(driven, "motor")
    message = {"motor_names": NAMES[::-1], "motor": MOTOR[::-1], "number": 3}
    values, number, _ = parse_state(driven, json.dumps(message), side)
    states = StateInbox(driven, units="motor")
    states.put("drives", values, 1.0, number)
    assert states.read(1.0).theta == pytest.approx(setpoint.theta)
    for k, name in enumerate(NAMES):  # a drive each, those of the differential too, and a wheel's
        states.put(name, {name: MOTOR[k], "wheel": 1.0}, 2.0 + 0.01 * k)
    measured = states.read(2.1)
    assert measured.theta == pytest.approx(setpoint.theta)
    assert measured.time == pytest.approx(2.0)
    body = ",".join(map(str, (3, *MOTOR, "S"))).encode()
    state = parse_state_line(driven, body + b"*%02X" % checksum(body), side)
    assert list(state.values.values()) == pytest.approx(MOTOR)
    assert state.interlock == "stopped"


def test_joints_of_a_robot_that_reports_its_motors_are_refused(driven):
    with pytest.raises(InputError, match="motor_names"):
        parse_state(driven, json.dumps({"joint_names": ["slide"], "theta": [0.0]}), motor_side(driven, "counts"))


def test_units_that_cannot_be(rover, driven):
    with pytest.raises(InputError, match="units must be 'joint', 'motor' or 'counts'"):
        UdpFeedback(driven, units="degrees")
    with pytest.raises(InputError, match="need actuators for each joint of rover_arm"):
        UdpFeedback(replace(rover, actuators=None), units="motor")
    with pytest.raises(InputError, match="units of commands must be 'joint'"):
        UdpSource(driven, units="motor")
