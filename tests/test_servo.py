"""The servo's meaning: frames, priorities, what is lost, what is held; judged by Pinocchio's kinematics and SciPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from twistarm import Actuators, JointLimits, manipulability
from twistarm.servo import JogCommand, PoseCommand, ServoSettings, ServoState, ServoStatus, TwistCommand, servo_step

DT = 0.01

TRACKING = 1e-3
"""Of the way: how far the tool may be from where the twist would have carried it, away from singularities."""


def pose(arm, state):
    return arm.by_pinocchio(state.theta)[0]


def driven(arm, state, command, steps, dt=DT, **settings):
    """The state after some steps, and the last output."""
    for _ in range(steps):
        state, output = servo_step(arm, state, command, dt, **settings)
    return state, output


LEVEL = np.array([-0.02, -0.1, 1.09, -1.08, 2.01])
"""so101 with its tool level, so that going sideways turns it: the wrist cannot take that back."""


def up_to_speed(arm, command, theta=None, dt=DT):
    """A state from theta (ready) in which the arm moves as commanded."""
    state = ServoState.at(arm, arm.ready if theta is None else theta)
    for _ in range(500):
        state, output = servo_step(arm, state, command, dt)
        if output.scale > 1.0 - 1e-9:
            return state
    raise AssertionError("the command was never reached")


# -- frames ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rover_arm_6dof", "ur5", "panda", "xarm7"])
def test_a_base_twist_moves_the_origin_straight_and_turns_about_base_axes(name):
    arm, v, w = load(name), np.array([0.02, -0.03, 0.01]), np.array([0.05, 0.02, -0.06])
    state = up_to_speed(arm, TwistCommand([*v, *w], "base"))
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


def test_the_base_frame_is_not_the_spatial_twist():
    """Turning in base axes leaves the tool's origin where it is; the spatial twist (0, ω) would swing it round."""
    arm = load("ur5")
    state, _ = driven(arm, ServoState.at(arm, arm.ready), TwistCommand([0, 0, 0, 0, 0, 0.3], "base"), 100)
    assert np.linalg.norm(pose(arm, state)[:3, 3] - arm.by_pinocchio(arm.ready)[0][:3, 3]) < 1e-4
    assert np.linalg.norm(state.theta - arm.ready) > 0.1


def test_six_numbers_are_a_twist_in_tool_axes():
    arm = load("ur5")
    state = ServoState.at(arm, arm.ready)
    bare, _ = servo_step(arm, state, [0.01, 0, 0, 0, 0, 0.1], DT)
    meant, _ = servo_step(arm, state, TwistCommand([0.01, 0, 0, 0, 0, 0.1], "tool"), DT)
    assert np.array_equal(bare.theta, meant.theta)


# -- what the arm cannot do --------------------------------------------------------------------------------------------


def test_five_joints_translate_exactly_and_lose_of_the_rotation_what_they_must():
    """so101 sideways: it must yaw with the motion, and the speed comes before the rotation that was asked for (0)."""
    arm, twist = load("so101"), np.array([0.0, 0.03, 0.0, 0.0, 0.0, 0.0])
    state = up_to_speed(arm, TwistCommand(twist, "base"), LEVEL)
    before = pose(arm, state)
    state, output = driven(arm, state, TwistCommand(twist, "base"), 20)
    moved = pose(arm, state)[:3, 3] - before[:3, 3]
    assert np.linalg.norm(moved - twist[:3] * 20 * DT) <= TRACKING * 0.03 * 20 * DT
    assert np.linalg.norm(output.lost_twist[:3]) < 1e-6
    assert abs(output.lost_twist[5]) > 0.02


def test_the_lost_twist_is_what_the_jacobian_cannot_do():
    """By least squares on Pinocchio's Jacobian: no rates do better on the translation, nor then on the rotation."""
    arm, rng = load("rover_arm"), np.random.default_rng(0)
    for _ in range(20):
        theta, twist = arm.random_theta(rng), rng.normal(size=6) * [0.05, 0.05, 0.05, 0.2, 0.2, 0.2]
        if arm.manipulability(theta).singular_values[-1] < 0.1:
            continue
        _, output = servo_step(arm, ServoState.at(arm, theta), TwistCommand(twist, "tool"), DT)
        if output.status is not ServoStatus.OK:
            continue
        J = arm.by_pinocchio(theta)[2]
        exact, *_ = np.linalg.lstsq(J[:3], twist[:3], rcond=None)
        spare = np.linalg.svd(J[:3])[2][3:].T
        rest, *_ = np.linalg.lstsq(J[3:] @ spare, twist[3:] - J[3:] @ exact, rcond=None)
        best = J @ (exact + spare @ rest)
        np.testing.assert_allclose(output.lost_twist, twist - best, atol=1e-6)


def test_a_rotation_that_the_arm_has_no_joint_for_moves_nothing():
    """rover_arm slides, pitches and rolls: level with the ground it cannot yaw, and a yaw must not make it slide."""
    arm = load("rover_arm")
    level = np.array([0.0, 0.6, -1.2, 0.6, 0.0])
    state, output = driven(arm, ServoState.at(arm, level), TwistCommand([0, 0, 0, 0, 0, 0.2], "base"), 20)
    moved = pose(arm, state) - arm.by_pinocchio(level)[0]
    assert np.abs(moved[:3, 3]).max() < 1e-6
    assert abs(output.lost_twist[5]) > 0.1


def test_what_cannot_be_done_at_all_is_not_called_ok():
    """Out of its plane rr_planar never moves; stretched, ur5 has no motion about base x: both say so in words."""
    for name, twist in (("rr_planar", [0, 0, 0.1, 0, 0, 0]), ("ur5", [0, 0, 0, 0.3, 0, 0])):
        arm = load(name)
        state, output = servo_step(arm, ServoState.at(arm, np.zeros(arm.n)), TwistCommand(twist, "base"), DT)
        assert not state.theta_dot.any() or np.abs(state.theta_dot).max() < 1e-6
        assert output.status is ServoStatus.SLOWED_SINGULARITY
        assert output.lost_share == pytest.approx(1.0, abs=1e-3)
        assert "can hardly move that way" in output.reason


@pytest.mark.parametrize("name", ["rover_arm", "so101", "so100", "scara", "rr_planar", "ur5", "rover_arm_6dof"])
def test_nothing_shakes_at_the_edge_of_the_reach(name):
    """Driven on against its reach for ten seconds, no joint keeps turning round: at most now and then."""
    arm = load(name)
    out = arm.fk(arm.ready)[:3, 3] / np.linalg.norm(arm.fk(arm.ready)[:3, 3])
    for direction in (out, [1.0, 0, 0], [0, 0, 1.0]):
        state, rates = ServoState.at(arm, arm.ready), []
        command = TwistCommand([*(0.1 * arm.reach * np.asarray(direction)), 0, 0, 0], "base")
        for _ in range(1000):
            state, _ = servo_step(arm, state, command, DT)
            rates.append(np.where(np.abs(state.theta_dot) < 1e-3, 0.0, state.theta_dot))
        assert (np.diff(np.sign(rates[400:]), axis=0) != 0).sum(axis=0).max() <= 6, direction


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


def test_nothing_asked_nothing_moves():
    arm = load("so101")
    for command in (TwistCommand(np.zeros(6)), JogCommand(np.zeros(arm.n)), TwistCommand(np.zeros(6), hold="position")):
        state, output = driven(arm, ServoState.at(arm, arm.ready), command, 1000)
        assert np.array_equal(state.theta, arm.ready)
        assert output.status is ServoStatus.OK


# -- singularities -----------------------------------------------------------------------------------------------------


def test_outward_until_stretched_and_back():
    """UR5 pushed outward: the elbow closes in on straight without passing it, rates stay calm, and it returns."""
    arm = load("ur5")
    out = TwistCommand([0.2, 0, 0, 0, 0, 0], "base")
    state, rates, statuses = ServoState.at(arm, arm.ready), [], set()
    for _ in range(1200):
        state, output = servo_step(arm, state, out, DT)
        rates.append(state.theta_dot)
        statuses.add(output.status)
    assert ServoStatus.SLOWED_SINGULARITY in statuses
    assert abs(state.theta[2]) < 0.05  # stretched
    assert np.abs(np.diff(rates, axis=0))[5:].max() < 0.35  # rad/s from one cycle to the next
    before = pose(arm, state)
    state, _ = driven(arm, state, TwistCommand([-0.2, 0, 0, 0, 0, 0], "base"), 100)
    assert pose(arm, state)[0, 3] < before[0, 3] - 0.15


@pytest.mark.parametrize("name", ["ur5", "elbow", "rr_planar"])
def test_an_arm_leaves_a_posture_that_is_exactly_singular(name):
    """Stretched at theta = 0, the tool is pulled back toward the base, where no joint rates lead to first order."""
    arm = load(name)
    g = arm.by_pinocchio(np.zeros(arm.n))[0]
    base = np.zeros(3) if name == "rr_planar" else np.array([0, 0, g[2, 3]])
    inward = (base - g[:3, 3]) / np.linalg.norm(base - g[:3, 3])
    state, _ = driven(arm, ServoState.at(arm, np.zeros(arm.n)), TwistCommand([*0.1 * inward, 0, 0, 0], "base"), 300)
    assert inward @ (pose(arm, state)[:3, 3] - g[:3, 3]) > 0.2


def test_the_length_is_stated_and_can_be_set():
    """Singular values with metres measured in ten times the reach are smaller, so that damping begins earlier."""
    arm = load("ur5")
    theta = arm.ready.copy()
    theta[2] = 0.4
    least = [
        np.linalg.svd(manipulability.scaled_jacobian(arm.body_jacobian(theta), np.zeros(6, bool), length))[1][-1]
        for length in (arm.reach, 10 * arm.reach)
    ]
    assert least[1] < 0.04 < least[0]
    twist = TwistCommand([0.0, 0.05, 0.05, 0, 0, 0], "base")
    plain, longer = (
        servo_step(arm, ServoState.at(arm, theta), twist, DT, settings=settings)[1]
        for settings in (ServoSettings(), ServoSettings(length=10 * arm.reach))
    )
    assert plain.status is ServoStatus.OK
    assert longer.status is ServoStatus.SLOWED_SINGULARITY


# -- limits ------------------------------------------------------------------------------------------------------------


def test_a_joint_at_its_limit_stops_and_the_rest_of_the_motion_goes_on():
    arm = load("rover_arm")
    slide, out = arm.limits.upper[0], TwistCommand([0.05, 0.05, 0.0, 0, 0, 0], "base")
    start = arm.ready.copy()
    start[0] = slide - 0.02
    state, output = driven(arm, ServoState.at(arm, start), out, 150)
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(start)[0][:3, 3]
    assert state.theta[0] <= slide
    assert slide - state.theta[0] < 1e-3
    assert abs(moved[1] - 0.02) < 2e-3 or abs(moved[0]) > 0.03
    assert output.status is ServoStatus.SLOWED_LIMIT
    assert output.joint == arm.joint_names[0]
    assert "upper position limit" in output.reason


def test_a_jog_into_a_limit_halts_there_and_says_which():
    arm = load("so101")
    rates = np.zeros(arm.n)
    rates[1] = 0.5
    state, output = driven(arm, ServoState.at(arm, arm.ready), JogCommand(rates), 1000)
    assert state.theta[1] == pytest.approx(arm.limits.upper[1], abs=1e-6)
    assert output.status is ServoStatus.HALTED_LIMIT
    assert output.joint == arm.joint_names[1]
    state, output = driven(arm, state, JogCommand(-rates), 20)
    assert output.status is ServoStatus.OK
    assert state.theta[1] < arm.limits.upper[1] - 0.05


def test_the_margin_is_kept():
    arm = load("so101")
    rates = np.zeros(arm.n)
    rates[1] = 0.5
    settings = ServoSettings(position_margin=0.1)
    state, _ = driven(arm, ServoState.at(arm, arm.ready), JogCommand(rates), 1000, settings=settings)
    assert state.theta[1] == pytest.approx(arm.limits.upper[1] - 0.1, abs=1e-6)


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


def test_a_velocity_limit_slows_the_whole_twist_and_does_not_bend_it():
    arm, twist = load("rover_arm_6dof"), np.array([0.6, 0.9, -0.5, 0, 0, 0])
    state, output = driven(arm, ServoState.at(arm, arm.ready), TwistCommand(twist, "base"), 30)
    assert output.status is ServoStatus.SLOWED_LIMIT
    assert 0.0 < output.scale < 0.8
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(arm.ready)[0][:3, 3]
    along = moved @ twist[:3] / np.linalg.norm(twist)
    assert np.linalg.norm(moved - along * twist[:3] / np.linalg.norm(twist)) < 0.01 * along


def test_an_acceleration_limit_does_not_bend_it_either():
    arm, twist = load("rover_arm"), np.array([0.05, 0.08, -0.04, 0, 0, 0])
    state = ServoState.at(arm, arm.ready)
    for _ in range(5):
        state, output = servo_step(arm, state, TwistCommand(twist, "base"), DT)
    assert output.scale < 0.9
    moved = pose(arm, state)[:3, 3] - arm.by_pinocchio(arm.ready)[0][:3, 3]
    across = moved - (moved @ twist[:3]) / (twist @ twist) * twist[:3]
    assert np.linalg.norm(across) < 1e-3 * np.linalg.norm(moved)


# -- poses and what is held --------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("frame", ["tool", "base"])
def test_the_orientation_is_held_while_the_tool_pushes(frame):
    arm = load("rover_arm")
    push = TwistCommand([0.05, 0.0, 0.0, 0, 0, 0], frame, "orientation")
    before = arm.by_pinocchio(arm.ready)[0]
    state, _ = driven(arm, ServoState.at(arm, arm.ready), push, 200)
    after = pose(arm, state)
    assert np.linalg.norm(after[:3, 3] - before[:3, 3]) > 0.05
    assert np.abs(after[:3, :3] - before[:3, :3]).max() < 1e-5


def test_what_is_held_goes_before_what_is_asked():
    """so101 cannot go sideways without yawing: with the orientation held it stays, without it goes."""
    arm = load("so101")
    for hold, least, most in ((None, 0.02, 1.0), ("orientation", 0.0, 0.004)):
        state, output = driven(arm, ServoState.at(arm, LEVEL), TwistCommand([0, 0.05, 0, 0, 0, 0], "base", hold), 60)
        moved = abs(pose(arm, state)[1, 3] - arm.by_pinocchio(LEVEL)[0][1, 3])
        assert least <= moved <= most, hold
        if hold:
            assert abs(output.lost_twist[1]) > 0.03


def test_what_is_held_starts_anew_with_another_command():
    arm = load("rover_arm")
    push = TwistCommand([0.05, 0, 0, 0, 0, 0], "base", "orientation")
    state, _ = driven(arm, ServoState.at(arm, arm.ready), push, 10)
    assert state.held is not None
    turned, _ = driven(arm, state, TwistCommand([0, 0, 0, 0, 0.2, 0], "base"), 50)
    assert turned.held is None
    there = pose(arm, turned)
    again, _ = driven(arm, turned, push, 50)
    assert np.abs(pose(arm, again)[:3, :3] - there[:3, :3]).max() < 0.02
