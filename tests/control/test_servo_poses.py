"""Poses that the servo goes to, and components that it holds; judged by Pinocchio's kinematics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from servo_drives import DT, LEVEL, driven, pose
from twistarm.control.servo import PoseCommand, ServoState, TwistCommand, servo_step


def test_what_is_held_changes_with_the_command_that_holds():
    """What is held counts from the switch, not from the first command."""
    arm, second = load("rover_arm_6dof"), TwistCommand([0.05, 0, 0, 0, 0, 0], "base", "orientation")
    for first in (
        TwistCommand([0, 0, 0, 0.2, 0, 0], "base", "position"),
        TwistCommand([0.05, 0, 0, 0, 0, 0], "tool", "orientation"),
        TwistCommand([0, 0, 0, 0.2, 0, 0], "base"),
    ):
        state, _ = driven(arm, ServoState.at(arm, arm.ready), first, 60)
        switched, _ = driven(arm, replace(state, theta_dot=np.zeros(6)), second, 100)
        turned = pose(arm, switched)[:3, :3] @ pose(arm, state)[:3, :3].T
        assert np.linalg.norm(Rotation.from_matrix(turned).as_rotvec()) < 1e-4


def test_held_in_the_tools_axes_the_tool_comes_back_along_them():
    """ur5's tool stands askew: pushed off along each base axis, it returns to the position held in tool axes."""
    arm = load("ur5")
    hold = TwistCommand([0, 0, 0, 0, 0, 0], "tool", "position")
    state, _ = servo_step(arm, ServoState.at(arm, arm.ready), hold, DT)
    for push in np.eye(3):
        moved, _ = driven(arm, state, TwistCommand([*0.1 * push, 0, 0, 0], "base"), 5)
        off = replace(state, theta=moved.theta, theta_dot=np.zeros(6))
        assert np.linalg.norm(pose(arm, off)[:3, 3] - state.held[:3, 3]) > 0.003
        back, _ = driven(arm, off, hold, 30)
        assert np.linalg.norm(pose(arm, back)[:3, 3] - state.held[:3, 3]) < 1e-5


def test_the_speeds_of_a_pose_are_kept():
    arm = load("ur5")
    g = arm.by_pinocchio(arm.ready)[0].copy()
    g[:3, :3] = g[:3, :3] @ Rotation.from_rotvec([0, 0, 1.0]).as_matrix()
    fastest = 0.0
    state = ServoState.at(arm, arm.ready)
    for _ in range(100):
        before = pose(arm, state)
        state, _ = servo_step(arm, state, PoseCommand(g, angular_speed=0.3), DT)
        turned = Rotation.from_matrix(pose(arm, state)[:3, :3] @ before[:3, :3].T).as_rotvec()
        fastest = max(fastest, np.linalg.norm(turned) / DT)
    assert 0.29 < fastest < 0.301


@pytest.mark.parametrize("name", ["rover_arm_6dof", "ur5", "panda"])
def test_a_pose_is_reached_without_overshoot_and_held(name):
    arm = load(name)
    goal = arm.by_pinocchio(arm.ready)[0].copy()
    goal[:3, 3] += [-0.05, 0.04, -0.06]
    goal[:3, :3] = goal[:3, :3] @ Rotation.from_rotvec([0.2, -0.1, 0.3]).as_matrix()
    state, errors = ServoState.at(arm, arm.ready), []
    for _ in range(600):
        state, output = servo_step(arm, state, PoseCommand(goal), DT)
        errors.append(np.linalg.norm(pose(arm, state)[:3, 3] - goal[:3, 3]))
    assert errors[-1] < 1e-6
    assert (np.diff(errors) < 1e-6).all()
    assert np.abs(pose(arm, state)[:3, :3] - goal[:3, :3]).max() < 1e-6
    assert max(output.remaining) < 1e-6
    assert np.abs(state.theta_dot).max() < 1e-5


def test_a_moving_pose_is_followed_without_lag():
    arm, v = load("ur5"), np.array([0.0, 0.05, -0.03])
    start = arm.by_pinocchio(arm.ready)[0]
    state = ServoState.at(arm, arm.ready)
    for k in range(200):
        goal = start.copy()
        goal[:3, 3] += v * k * DT
        state, _ = servo_step(arm, state, PoseCommand(goal, velocity=[*v, 0, 0, 0]), DT)
    meant = start[:3, 3] + v * 200 * DT
    assert np.linalg.norm(pose(arm, state)[:3, 3] - meant) < 1e-4


def test_what_is_held_goes_before_what_is_asked():
    """so101 cannot go sideways without yawing: with the orientation held it stays, without it goes."""
    arm = load("so101")
    for hold, least, most in ((None, 0.02, 1.0), ("orientation", 0.0, 0.004)):
        state, output = driven(arm, ServoState.at(arm, LEVEL), TwistCommand([0, 0.05, 0, 0, 0, 0], "base", hold), 60)
        moved = abs(pose(arm, state)[1, 3] - arm.by_pinocchio(LEVEL)[0][1, 3])
        assert least <= moved <= most, hold
        if hold:
            assert abs(output.lost_twist[1]) > 0.03
