"""The servo at limits: what is slowed, what stops, and that the rest goes on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from servo_drives import driven, pose
from twistarm import Actuators, JointLimits
from twistarm.control.servo import JogCommand, ServoSettings, ServoState, ServoStatus, TwistCommand


def test_a_motor_at_its_position_limit_is_named():
    """A differential wrist: rolling on drives the left motor to its end, which halts the roll and is said."""
    arm = load("rover_arm")
    G = np.zeros((2, 5))
    G[:, 3:] = [[2.0, 2.0], [2.0, -2.0]]
    most = np.full(2, np.inf)
    limits = JointLimits(np.full(2, -4.0), np.full(2, 4.0), most, np.full(2, 20.0), most, most)
    motors = Actuators(("left", "right"), arm.joint_names, G, np.zeros(2), ("rad",) * 2, np.full(2, np.nan), limits)
    wired = replace(arm, actuators=motors)
    state, output = driven(wired, ServoState.at(wired, np.zeros(5)), JogCommand([0, 0, 0, 0, 0.5]), 800)
    assert output.status is ServoStatus.HALTED_LIMIT
    assert output.joint in ("left", "right")
    assert np.abs(G @ state.theta).max() == pytest.approx(4.0, abs=1e-3)
    _, output = driven(wired, state, JogCommand([0, 0, 0, 0, -0.5]), 20)
    assert output.status is ServoStatus.OK


def test_at_two_limits_at_once_the_rest_goes_where_it_is_told():
    """The slide at its end while the twist is too fast for the shoulder: what is left is x and z about as asked.

    What a joint at its end takes from a level damps the rest of it: 13 % here, at 1 m/s, and less the slower it is.
    """
    arm = load("rover_arm")
    start = arm.ready.copy()
    start[0] = arm.limits.upper[0]
    state, output = driven(arm, ServoState.at(arm, start), TwistCommand([1.0, 1.0, -1.0, 0, 0, 0], "base"), 25)
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(start)[0][:3, 3]
    assert (output.status, output.joint) == (ServoStatus.SLOWED_LIMIT, arm.joint_names[0])
    assert "upper position limit" in output.explain()
    assert moved[0] > 0.02
    assert abs(moved[0] + moved[2]) < 0.15 * moved[0]
    assert abs(moved[1]) < 1e-9


@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_a_jog_into_a_limit_halts_there_or_a_margin_before_and_says_which(margin):
    arm, settings = load("so101"), ServoSettings(position_margin=margin)
    rates = np.zeros(arm.n)
    rates[1] = 0.5
    state, output = driven(arm, ServoState.at(arm, arm.ready), JogCommand(rates), 1000, settings=settings)
    assert state.theta[1] == pytest.approx(arm.limits.upper[1] - margin, abs=1e-6)
    assert output.status is ServoStatus.HALTED_LIMIT
    assert output.joint == arm.joint_names[1]
    state, output = driven(arm, state, JogCommand(-rates), 20, settings=settings)
    assert output.status is ServoStatus.OK
    assert state.theta[1] < arm.limits.upper[1] - margin - 0.05


def test_from_outside_the_limits_there_is_only_the_way_back():
    arm = load("so101")
    outside = arm.ready.copy()
    outside[1] = arm.limits.upper[1] + 0.05
    rates = np.zeros(arm.n)
    rates[1] = 0.2
    farther, output = driven(arm, ServoState.at(arm, outside), JogCommand(rates), 10)
    assert farther.theta[1] == outside[1]
    assert output.status is ServoStatus.HALTED_LIMIT
    nearer, _ = driven(arm, ServoState.at(arm, outside), JogCommand(-rates), 10)
    assert nearer.theta[1] < outside[1] - 0.01


@pytest.mark.parametrize(
    ("name", "twist", "steps"),
    [("rover_arm_6dof", [0.6, 0.9, -0.5, 0, 0, 0], 30), ("rover_arm", [0.05, 0.08, -0.04, 0, 0, 0], 5)],
    ids=["velocity", "acceleration"],
)
def test_a_limit_of_rates_slows_the_whole_twist_and_does_not_bend_it(name, twist, steps):
    arm, along = load(name), np.array(twist[:3]) / np.linalg.norm(twist)
    state, output = driven(arm, ServoState.at(arm, arm.ready), TwistCommand(twist, "base"), steps)
    assert 0.0 < output.scale < 0.9
    assert (output.status is ServoStatus.SLOWED_LIMIT) == (name == "rover_arm_6dof")
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(arm.ready)[0][:3, 3]
    assert np.linalg.norm(moved - moved @ along * along) < 1e-2 * (moved @ along)
