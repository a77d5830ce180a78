"""Random drives through singularities and into limits: nothing is ever exceeded, and the arm can always move away."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from servo_drives import broken, drive, next_command, random_arm, travelled, with_motors
from twistarm import arm_from_screws, joints
from twistarm.control.servo import JogCommand, ServoState, TwistCommand, servo_step

QUICK, WHOLE = 15, 1000

SIZES = [pytest.param(n, marks=pytest.mark.slow) if n in (4, 6, 7) else n for n in range(3, 9)]

AWAY = 0.1  # Least singular value, metres measured in the reach, of a posture away from singularities.


def check_way_back(n, numbers, seed=2):
    """Driven on until nothing more is possible, the arm goes back when the command turns round."""
    for number in numbers:
        rng = np.random.default_rng([seed, n, number])
        arm = random_arm(rng, n)
        twist = rng.normal(size=6) * [0.3, 0.3, 0.3, 0.8, 0.8, 0.8]
        if number % 2:
            twist[3:] = 0.0
        there, state = travelled(arm, ServoState.at(arm, arm.random_theta(rng)), twist, 8.0)
        back, _ = travelled(arm, ServoState.at(arm, state.theta), -twist, 4.0)
        assert back > 0.02 or back > 0.5 * there, (number, back, there)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("drives", [QUICK, pytest.param(WHOLE, marks=pytest.mark.slow)])
def test_no_limit_is_ever_exceeded(n, drives):
    for number in range(drives):
        _, _, faults = drive([1, n, number])
        assert not faults, (number, faults[:3])


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("drives", [QUICK, pytest.param(WHOLE, marks=pytest.mark.slow)])
def test_the_arm_can_always_move_away(n, drives):
    check_way_back(n, range(drives))


@pytest.mark.parametrize(("n", "number", "seed"), [(3, 85, 2), (3, 127, 2), (3, 403, 77), (4, 141, 77)])
def test_an_arm_leaves_a_rest_that_the_turn_of_its_tool_holds_up(n, number, seed):
    """Of few joints: the way out of the position would turn the tool, and does not lead far."""
    check_way_back(n, [number], seed)


@pytest.mark.parametrize("n", SIZES)
def test_the_tool_does_what_can_be_done(n):
    """Over one step it moves by scale · (twist − lost), judged by forward kinematics, SciPy taking the logarithm."""
    for number in range(20):
        rng = np.random.default_rng([3, n, number])
        arm = random_arm(rng, n, unlimited=True)
        scale = np.repeat([1.0 / arm.reach, 1.0], 3)
        twist = rng.normal(size=6) * 0.05 / scale
        state = ServoState.at(arm, arm.random_theta(rng))
        for k in range(12):
            before = arm.fk(state.theta)
            near = arm.manipulability(state.theta).singular_values[-1] < AWAY
            state, output = servo_step(arm, state, TwistCommand(twist, "base"), 0.01)
            if near or k < 3 or output.status != "OK":
                continue
            after = arm.fk(state.theta)
            turned = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec()
            done = np.concatenate([after[:3, 3] - before[:3, 3], turned]) / 0.01
            meant = output.scale * (twist - output.lost_twist)
            assert np.linalg.norm(scale * (done - meant)) <= 1e-3 * np.linalg.norm(scale * meant), (number, k)


def test_motors_keep_theirs():
    """A differential wrist: its motors turn by sum and difference of two joints, whose own limits are not enough."""
    rng = np.random.default_rng(4)
    arm = random_arm(rng, 5)
    G = np.diag([20.0, 30.0, 30.0, 10.0, 10.0])
    G[3, 4], G[4, 3] = 10.0, -10.0
    arm = with_motors(arm, G, velocity=12.0, acceleration=60.0)
    state, command, busy = ServoState.at(arm, arm.ready), None, 0
    for k in range(2000):
        if k % 40 == 0:
            command = next_command(rng, arm, command)
        after, _ = servo_step(arm, state, command, 0.01)
        rates, before = G @ after.theta_dot, G @ state.theta_dot
        assert (np.abs(rates) <= 12.0 * (1 + 1e-9)).all(), k
        assert (np.abs(rates - before) <= 0.6 * (1 + 1e-6)).all(), k
        assert not broken(arm, state, after, 0.01), k
        busy += bool((np.abs(rates) > 11.9).any())
        state = after
    assert busy > 20  # the limits were met, not avoided


def test_a_row_that_hardly_moves_keeps_its_acceleration_too():
    """Two slides, one at speed, told rates of 1e-12: the way there may not pass through large rates of the other."""
    screws = np.hstack([joints.prismatic([1, 0, 0]), joints.prismatic([0, 1, 0])])
    arm = arm_from_screws(screws, np.eye(4), limits={"velocity": 2.0, "acceleration": 1.0}, name="gantry")
    state = ServoState.moving(arm, [0.0, 0.0], [1.0, 0.0])
    for command in (JogCommand([2e-12, 0.9e-12]), TwistCommand([2e-12, 0.9e-12, 0, 0, 0, 0])):
        after, _ = servo_step(arm, state, command, 0.01)
        assert (np.abs(after.theta_dot - state.theta_dot) <= 0.01 + 1e-9).all()


def test_a_step_is_pure():
    arm = load("rover_arm")
    state, command = ServoState.at(arm, arm.ready), TwistCommand([0.05, 0.0, 0.0, 0.0, 0.1, 0.0])
    kept = state.theta.copy()
    first, second = (servo_step(arm, state, command, 0.01) for _ in range(2))
    assert np.array_equal(state.theta, kept)
    assert np.array_equal(first[0].theta, second[0].theta)
    with pytest.raises(ValueError, match="read-only"):
        first[0].theta[0] = 1.0
