"""A stream on the motors' side: what a differential wrist's drives are told, and what they say."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from stream_stand_ins import answer
from twistarm import Actuators
from twistarm.control.stream import Setpoint, StateInbox, UdpFeedback, parse_state, setpoint_message
from twistarm.control.stream.messages import motor_side
from twistarm.control.stream.serial_link import checksum, parse_state_line, setpoint_line
from twistarm.support.errors import InputError

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
    said = {"motor_names": NAMES[::-1], "motor": MOTOR[::-1], "number": 3}
    values, number, _ = parse_state(driven, json.dumps(said), side)
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
