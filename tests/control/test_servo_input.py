"""What cannot be used: a command is refused where it is made, and a step never raises for a bad moment."""

import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from twistarm import InputError, TwistarmError, UnknownNameError, arm_from_screws, joints
from twistarm.arm import engine
from twistarm.control.servo import JogCommand, PoseCommand, ServoSettings, ServoState, TwistCommand, servo_step

DT = 0.01

PUSH = TwistCommand([0.05, 0, 0, 0, 0, 0], "base", "orientation")
MOVING = TwistCommand([0.05, 0, 0, 0, 0, 0], "base")


def moving(arm, steps=30):
    state = ServoState.at(arm, arm.ready)
    for _ in range(steps):
        state, _ = servo_step(arm, state, MOVING, DT)
    return state


REFUSED = [
    (lambda: TwistCommand([0, 0, 0]), r"twist must have shape \(\.\.\., 6\); got \(3,\)"),
    (lambda: TwistCommand(np.zeros(6), "world"), "frame must be 'tool' or 'base'; got 'world'"),
    (lambda: TwistCommand(np.zeros(6), hold="elbow"), "hold must be 'position', 'orientation' or six booleans"),
    (lambda: TwistCommand([0, 0, 0, 0, 0, 1], hold="orientation"), "a held component cannot be commanded"),
    (lambda: JogCommand([[0.0]]), r"theta_dot must be one number per joint, shape \(n,\)"),
    (lambda: JogCommand({"elbow": 0.1}), r"JogCommand\.of"),
    (lambda: PoseCommand(np.eye(4), linear_speed=0.0), "linear_speed must be above 0"),
    (lambda: TwistCommand([0, 0, 1e155, 0, 0, 0]), "twist must be at most 10000 in size, in SI units; got 1e.155"),
    (lambda: PoseCommand(np.array([[1, 0, 0, 1e160], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])), "g must be at most"),
    (lambda: ServoState.at(load("ur5"), np.full(6, 1e9)), "theta must be at most 1e.06 in size; got 1e.09"),
    (lambda: ServoSettings(singularity_threshold=1e-4), "singularity_threshold must be more than 0.001"),
    (lambda: ServoSettings(position_margin=5), "286°"),
]


@pytest.mark.parametrize(("make", "words"), REFUSED)
def test_what_cannot_be_a_command_is_refused_where_it_is_made(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_a_jog_by_names():
    arm = load("rover_arm")
    name = arm.joint_names[2]
    assert JogCommand.of(arm, {name: 0.3}).theta_dot.tolist() == [0.0, 0.0, 0.3, 0.0, 0.0]
    with pytest.raises(UnknownNameError, match="no joint 'elbo' in rover_arm"):
        JogCommand.of(arm, {"elbo": 0.3})


BAD_COMMANDS = [
    (None, "no command"),
    ([0.0] * 5, "twist must have shape"),
    ([math.nan] * 6, "twist must be finite"),
    ("forward", "twist"),
    (object(), "twist"),
    (JogCommand([0.1, 0.1]), "a jog of rover_arm has 5 rates; got 2"),
]


@pytest.mark.parametrize(("command", "words"), BAD_COMMANDS)
def test_a_bad_command_brings_the_arm_to_rest_along_its_limits(command, words):
    arm = load("rover_arm")
    state = moving(arm)
    speed = np.abs(state.theta_dot).max()
    assert speed > 0.01
    for _ in range(100):
        before = state
        state, output = servo_step(arm, state, command, DT)
        assert output.status == "STALE"
        assert words in output.explain()
        assert (np.abs(state.theta_dot - before.theta_dot) <= arm.limits.acceleration * DT + 1e-12).all()
    assert not state.theta_dot.any()


@pytest.mark.parametrize("dt", [0.0, -0.01, 1.0, math.nan, math.inf, "soon", None])
def test_a_bad_time_step_is_refused_and_the_arm_is_still(dt):
    arm = load("rover_arm")
    state = moving(arm)
    after, output = servo_step(arm, state, MOVING, dt)
    assert output.status == "STALE"
    assert "dt must be more than 0 and at most 0.1 s" in output.explain()
    assert not output.theta_dot.any()
    assert np.array_equal(after.theta, state.theta)


BAD_STATES = [
    *({"theta": bad} for bad in ([math.nan] * 5, [0.0] * 4, [1e300] * 5, "here", None)),
    *({"held_pose": bad} for bad in (np.full((4, 4), math.nan), np.eye(3), "there")),
]


@pytest.mark.parametrize("bad", BAD_STATES)
def test_a_bad_state_is_refused(bad):
    arm = load("rover_arm")
    state, _ = servo_step(arm, ServoState.at(arm, arm.ready), PUSH, DT)
    _, output = servo_step(arm, replace(state, **bad), PUSH, DT)
    assert output.status == "STALE"
    assert "the state cannot be used" in output.explain()
    assert not output.theta_dot.any()


@pytest.mark.parametrize("margin", [0.05, 0.3, 1.5])
def test_a_margin_wider_than_the_range_leaves_its_middle(margin):
    lower, upper = np.array([-0.0156, -0.1, 0.3]), np.array([0.0111, 0.7, 0.3])
    screws = np.hstack([joints.revolute([0, 0, 1], [k, 0, 0]) for k in range(3)])
    arm = arm_from_screws(screws, np.eye(4), limits={"lower": lower, "upper": upper, "velocity": 1.0}, name="narrow")
    state, settings = ServoState.at(arm, (lower + upper) / 2), ServoSettings(position_margin=margin)
    for _ in range(100):
        state, output = servo_step(arm, state, JogCommand([1.0, 1.0, 1.0]), DT, settings=settings)
    assert output.status != "STALE"
    most = np.maximum(upper - margin, (lower + upper) / 2)
    np.testing.assert_allclose(state.theta, most, atol=1e-9)


@pytest.mark.parametrize("reach", [1e-3, 1.0, 1e3])
def test_the_fastest_command_that_is_accepted_leaves_numbers_finite(reach):
    """Arms of a millimetre and of a kilometre, 10⁴ m/s and 10⁴ rad/s: no NaN, no limit exceeded."""
    screws = np.hstack([joints.revolute([0, 0, 1], [k * reach / 3, 0, 0]) for k in range(3)])
    home = np.eye(4) + reach * np.eye(4, k=3)
    arm = arm_from_screws(screws, home, limits={"velocity": 1.0, "acceleration": 2.0}, name="scaled")
    for command in (TwistCommand(np.full(6, 1e4)), JogCommand(np.full(3, -1e4)), PoseCommand(np.eye(4))):
        state = ServoState.at(arm, [0.1, 0.4, -0.2])
        for _ in range(50):
            state, output = servo_step(arm, state, command, DT)
            assert np.isfinite(state.theta).all()
            assert np.isfinite(output.lost_twist).all()
            assert (np.abs(state.theta_dot) <= 1.0 + 1e-9).all()


def test_lists_and_other_floats_serve_as_well():
    arm = load("rover_arm")
    state, _ = servo_step(arm, ServoState.at(arm, arm.ready), PUSH, DT)
    plain, _ = servo_step(arm, state, PUSH, DT)
    same = {"theta": state.theta.tolist(), "theta_dot": state.theta_dot.tolist(), "held_pose": state.held_pose.tolist()}
    for other, dt in (
        (same, DT),
        ({"held_pose": np.asfortranarray(state.held_pose)}, np.float64(DT)),
        ({}, np.float32(DT)),
    ):
        listed, _ = servo_step(arm, replace(state, **other), PUSH, dt)
        np.testing.assert_allclose(plain.theta, listed.theta, atol=1e-8)


@pytest.mark.parametrize("steps", [10_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_steps_leave_nothing_behind(steps):
    arm = load("rover_arm")
    there, back = TwistCommand([0.03, 0, 0, 0, 0, 0], "base"), TwistCommand([-0.03, 0, 0, 0, 0, 0], "base")
    state = ServoState.at(arm, arm.ready)
    tracemalloc.start()
    try:
        for k in range(steps):
            if k == 2000:
                before = tracemalloc.get_traced_memory()[0]
            state, _ = servo_step(arm, state, there if k % 200 < 100 else back, DT)
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert grown < 20_000


def test_where_there_is_no_core_it_says_how_to_get_one(monkeypatch):
    monkeypatch.setattr(engine, "core", lambda: None)
    monkeypatch.setattr(engine, "why_not", lambda: "it was not compiled; compile it")
    arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4))
    with pytest.raises(TwistarmError, match="^the servo needs the compiled core: it was not compiled; compile it$"):
        servo_step(arm, ServoState.at(arm, [0.0]), MOVING, DT)
