"""The servo's meaning: frames, priorities, what is lost; judged by Pinocchio's kinematics and SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from servo_drives import DT, TRACKING, driven, pose, up_to_speed
from twistarm import arm_from_screws, joints
from twistarm.control.servo import JogCommand, ServoState, ServoStatus, TwistCommand, servo_step

BENT = {"xarm7": [2.4, 1.7, 4.1, 0.5, 3.1, -1.3, -0.9]}
"""A posture that is not singular, where the arm's ready is."""


@pytest.mark.parametrize("name", ["rover_arm_6dof", "ur5", "panda", "xarm7"])
def test_a_base_twist_moves_the_origin_straight_and_turns_about_base_axes(name):
    arm, v, w = load(name), np.array([0.02, -0.03, 0.01]), np.array([0.05, 0.02, -0.06])
    state = up_to_speed(arm, TwistCommand([*v, *w], "base"), BENT.get(name))
    before = pose(arm, state)
    state, _ = driven(arm, state, TwistCommand([*v, *w], "base"), 50)
    after, time = pose(arm, state), 50 * DT
    assert np.linalg.norm(after[:3, 3] - before[:3, 3] - v * time) <= TRACKING * np.linalg.norm(v) * time
    turned = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec()
    assert np.linalg.norm(turned - w * time) <= TRACKING * np.linalg.norm(w) * time


@pytest.mark.parametrize("name", ["rover_arm_6dof", "ur5", "panda"])
def test_a_tool_twist_is_the_body_twist(name):
    """Under a constant body twist V the tool goes from g to g exp(V t), MLS §2.4.2."""
    from scipy.linalg import expm

    arm, V, time = load(name), np.array([0.02, -0.01, 0.03, 0.1, -0.05, 0.08]), 50 * DT
    state = up_to_speed(arm, TwistCommand(V))
    before = pose(arm, state)
    state, _ = driven(arm, state, TwistCommand(V), 50)
    hat = np.zeros((4, 4))
    hat[:3, :3] = np.array([[0, -V[5], V[4]], [V[5], 0, -V[3]], [-V[4], V[3], 0]])
    hat[:3, 3] = V[:3]
    meant = before @ expm(hat * time)
    after = pose(arm, state)
    assert np.linalg.norm(after[:3, 3] - meant[:3, 3]) <= TRACKING * np.linalg.norm(V[:3]) * time
    assert np.abs(after[:3, :3] - meant[:3, :3]).max() <= TRACKING * np.linalg.norm(V[3:]) * time


def test_six_numbers_are_a_twist_in_tool_axes():
    arm = load("ur5")
    state = ServoState.at(arm, arm.ready)
    bare, _ = servo_step(arm, state, [0.01, 0, 0, 0, 0, 0.1], DT)
    meant, _ = servo_step(arm, state, TwistCommand([0.01, 0, 0, 0, 0, 0.1], "tool"), DT)
    assert np.array_equal(bare.theta, meant.theta)


def test_the_lost_twist_is_what_the_jacobian_cannot_do():
    """By least squares on Pinocchio's Jacobian: no rates do better on the translation, nor then much on the rotation.

    Where a rotation is lacking, damping takes some of the others, the more the faster it is.
    """
    arm, rng = load("rover_arm"), np.random.default_rng(0)
    for _ in range(20):
        theta, twist = arm.random_theta(rng), rng.normal(size=6) * 0.05
        if arm.manipulability(theta).singular_values[-1] < 0.1:
            continue
        _, output = servo_step(arm, ServoState.at(arm, theta), TwistCommand(twist, "tool"), DT)
        if output.status is not ServoStatus.OK:
            continue
        J = arm.by_pinocchio(theta)[2]
        exact, *_ = np.linalg.lstsq(J[:3], twist[:3], rcond=None)
        spare = np.linalg.svd(J[:3])[2][3:].T
        if np.linalg.svd(J[3:] @ spare)[1][-1] < 0.5:
            continue
        rest, *_ = np.linalg.lstsq(J[3:] @ spare, twist[3:] - J[3:] @ exact, rcond=None)
        best = J @ (exact + spare @ rest)
        np.testing.assert_allclose(output.lost_twist[:3], (twist - best)[:3], atol=1e-5)
        np.testing.assert_allclose(output.lost_twist[3:], (twist - best)[3:], atol=0.1 * np.linalg.norm(twist[3:]))


def test_a_rotation_that_the_arm_has_no_joint_for_moves_nothing():
    """rover_arm slides, pitches and rolls: level with the ground it cannot yaw, and a yaw must not make it slide."""
    arm = load("rover_arm")
    level = np.array([0.0, 0.6, -1.2, 0.6, 0.0])
    state, output = driven(arm, ServoState.at(arm, level), TwistCommand([0, 0, 0, 0, 0, 0.2], "base"), 20)
    moved = pose(arm, state) - arm.by_pinocchio(level)[0]
    assert np.abs(moved[:3, 3]).max() < 1e-6
    assert abs(output.lost_twist[5]) > 0.1


def test_a_slide_is_measured_in_the_length():
    """The same arm in metres and in millimetres moves alike: a slide's rate counts as much as a turn of that length."""
    states = []
    for scale in (1.0, 1000.0):
        screws = np.hstack(
            [
                joints.prismatic([1, 0, 0]),
                joints.revolute([0, 0, 1], [0, 0, 0]),
                joints.revolute([0, 0, 1], [scale, 0, 0]),
            ]
        )
        home = np.eye(4)
        home[0, 3] = 1.7 * scale
        arm = arm_from_screws(screws, home, name="scaled")
        twist = [0.05 * scale, 0.03 * scale, 0, 0, 0, 0.1]
        state, _ = driven(arm, ServoState.at(arm, [0.1 * scale, 0.3, 0.8]), TwistCommand(twist, "base"), 50)
        states.append(state.theta / [scale, 1, 1])
    np.testing.assert_allclose(states[0], states[1], atol=1e-6)


def test_nothing_asked_nothing_moves():
    arm = load("so101")
    for command in (TwistCommand(np.zeros(6)), JogCommand(np.zeros(arm.n)), TwistCommand(np.zeros(6), hold="position")):
        state, output = driven(arm, ServoState.at(arm, arm.ready), command, 1000)
        assert np.array_equal(state.theta, arm.ready)
        assert output.status is ServoStatus.OK
