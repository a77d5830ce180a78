"""The servo's meaning: frames, priorities, limits, poses; judged by Pinocchio's kinematics and SciPy."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from family_arms import twist_motion
from servo_drives import DT, LEVEL, TRACKING, WRIST, driven, pose, up_to_speed, with_motors
from twistarm import arm_from_screws, joints
from twistarm.control.servo import JogCommand, PoseCommand, ServoSettings, ServoState, TwistCommand, servo_step

# A posture that is not singular, where the arm's ready is.
BENT = {"xarm7": [2.4, 1.7, 4.1, 0.5, 3.1, -1.3, -0.9]}


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
    arm, V, time = load(name), np.array([0.02, -0.01, 0.03, 0.1, -0.05, 0.08]), 50 * DT
    state = up_to_speed(arm, TwistCommand(V))
    before = pose(arm, state)
    state, _ = driven(arm, state, TwistCommand(V), 50)
    meant = before @ twist_motion(V, time)
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
        if output.status != "OK":
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
        elbow = joints.revolute([0, 0, 1], [scale, 0, 0])
        screws = np.hstack([joints.prismatic([1, 0, 0]), joints.revolute([0, 0, 1], [0, 0, 0]), elbow])
        arm = arm_from_screws(screws, np.eye(4) + 1.7 * scale * np.eye(4, k=3), name="scaled")
        twist = [0.05 * scale, 0.03 * scale, 0, 0, 0, 0.1]
        state, _ = driven(arm, ServoState.at(arm, [0.1 * scale, 0.3, 0.8]), TwistCommand(twist, "base"), 50)
        states.append(state.theta / [scale, 1, 1])
    np.testing.assert_allclose(states[0], states[1], atol=1e-6)


def test_a_motor_at_its_position_limit_is_named():
    """A differential wrist: rolling on drives the left motor to its end, which halts the roll and is said."""
    wired = with_motors(load("rover_arm"), WRIST, position=4.0, acceleration=20.0)
    state, output = driven(wired, ServoState.at(wired, np.zeros(5)), JogCommand([0, 0, 0, 0, 0.5]), 800)
    assert output.status == "HALTED_LIMIT"
    assert output.joint in ("motor_0", "motor_1")
    assert np.abs(WRIST @ state.theta).max() == pytest.approx(4.0, abs=1e-3)
    _, output = driven(wired, state, JogCommand([0, 0, 0, 0, -0.5]), 20)
    assert output.status == "OK"


def test_at_two_limits_at_once_the_rest_goes_where_it_is_commanded():
    """The slide at its end while the twist is too fast for the shoulder: what is left is x and z about as asked.

    What a joint at its end takes from a level damps the rest of it: 13 % here, at 1 m/s, and less the slower it is.
    """
    arm = load("rover_arm")
    start = arm.ready.copy()
    start[0] = arm.limits.upper[0]
    state, output = driven(arm, ServoState.at(arm, start), TwistCommand([1.0, 1.0, -1.0, 0, 0, 0], "base"), 25)
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(start)[0][:3, 3]
    assert (output.status, output.joint) == ("SLOWED_LIMIT", arm.joint_names[0])
    assert "upper position limit" in output.explain()
    assert moved[0] > 0.02
    assert abs(moved[0] + moved[2]) < 0.15 * moved[0]
    assert abs(moved[1]) < 1e-9


def test_rounding_at_a_limit_stops_nothing():
    """One joint stands at its limit and is not asked to move, but for the rounding of the twist that asks."""
    arm, rng = load("ur5"), np.random.default_rng(6)
    for k in range(arm.n):
        theta, rates = np.array([0.4, -1.2, 1.3, 0.6, 1.1, 0.2]), 0.1 * rng.uniform(-1.0, 1.0, arm.n)
        theta[k], rates[k] = 0.3, 0.0  # off any singularity
        ends = {"upper": {arm.joint_names[k]: 0.3}, "velocity": np.inf, "acceleration": np.inf}
        wired = replace(arm, limits=arm.limits.with_(ends, arm.joint_names), named_states={}, known_ready=theta)
        twist = arm.by_pinocchio(theta)[2] @ rates
        state, output = servo_step(wired, ServoState.at(wired, theta), TwistCommand(twist), DT)
        assert (output.status, output.scale) == ("OK", 1.0)
        np.testing.assert_allclose(state.theta_dot, rates, atol=5e-3)


@pytest.mark.parametrize("margin", [0.0, 0.1])
def test_a_jog_into_a_limit_halts_there_or_a_margin_before_and_says_which(margin):
    arm, settings = load("so101"), ServoSettings(position_margin=margin)
    rates = np.zeros(arm.n)
    rates[1] = 0.5
    state, output = driven(arm, ServoState.at(arm, arm.ready), JogCommand(rates), 1000, settings=settings)
    assert state.theta[1] == pytest.approx(arm.limits.upper[1] - margin, abs=1e-6)
    assert output.status == "HALTED_LIMIT"
    assert output.joint == arm.joint_names[1]
    state, output = driven(arm, state, JogCommand(-rates), 20, settings=settings)
    assert output.status == "OK"
    assert state.theta[1] < arm.limits.upper[1] - margin - 0.05


def test_from_outside_the_limits_there_is_only_the_way_back():
    arm = load("so101")
    outside = arm.ready.copy()
    outside[1] = arm.limits.upper[1] + 0.05
    rates = np.zeros(arm.n)
    rates[1] = 0.2
    farther, output = driven(arm, ServoState.at(arm, outside), JogCommand(rates), 10)
    assert farther.theta[1] == outside[1]
    assert output.status == "HALTED_LIMIT"
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
    assert (output.status == "SLOWED_LIMIT") == (name == "rover_arm_6dof")
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(arm.ready)[0][:3, 3]
    assert np.linalg.norm(moved - moved @ along * along) < 1e-2 * (moved @ along)


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
        assert np.linalg.norm(pose(arm, off)[:3, 3] - state.held_pose[:3, 3]) > 0.003
        back, _ = driven(arm, off, hold, 30)
        assert np.linalg.norm(pose(arm, back)[:3, 3] - state.held_pose[:3, 3]) < 1e-5


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
