"""What is held stays where it was, whatever the rest of the command loses; judged by Pinocchio's kinematics."""

import numpy as np
import pytest
from benchmarks.servo import at_limits, random, ranges, servo_arm
from scipy.spatial.transform import Rotation

from servo_drives import DT
from twistarm.control.servo import ServoState, TwistCommand, servo_step

ARMS = ("ur5", "panda", "so101", "rover_arm", "rover_arm_6dof")
STEPS = 250
KEPT, TURNED = 5e-4, 5e-4  # How far what is held may be off [m, rad].

SPEED = {"position": 0.5, "orientation": 0.15, "mixed": 0.4}


def starts(arm, rng):
    """Stretched or folded at zero, at limits, beside one, anywhere."""
    lower, upper = ranges(arm)
    yield np.clip(np.zeros(arm.n), lower, upper)
    yield at_limits(arm, rng)
    beside = rng.uniform(lower, upper)
    beside[3] = (upper if np.isfinite(arm.limits.upper[3]) else beside + 0.05)[3] - 0.05
    yield beside
    yield rng.uniform(lower, upper)


def drawn_command(rng, what):
    twist = np.concatenate([rng.normal(size=3) * (what != "position"), rng.normal(size=3) * (what != "orientation")])
    held = rng.permutation([True, True, False] * 2) if what == "mixed" else None
    twist = np.where(held, 0.0, twist) if what == "mixed" else twist
    hold = [bool(component) for component in held] if what == "mixed" else what
    return TwistCommand(SPEED[what] * twist / np.linalg.norm(twist), ("base", "tool")[rng.integers(2)], hold)


def astray(arm, theta, start, command):
    """How far the held components are off where they were [m, rad], in axes of the command's frame."""
    g = arm.by_pinocchio(theta)[0]
    R = g[:3, :3] if command.frame == "tool" else np.eye(3)
    moved = R.T @ (g[:3, 3] - start[:3, 3])
    turned = R.T @ Rotation.from_matrix(g[:3, :3] @ start[:3, :3].T).as_rotvec()
    off = np.where(command.held, np.concatenate([moved, turned]), 0.0)
    return np.linalg.norm(off[:3]), np.linalg.norm(off[3:])


@pytest.mark.parametrize("accelerating", [True, pytest.param(False, marks=pytest.mark.slow)])
@pytest.mark.parametrize("rounds", [1, pytest.param(10, marks=pytest.mark.slow)])
@pytest.mark.parametrize("what", SPEED)
@pytest.mark.parametrize("name", ARMS)
def test_what_is_held_stays(name, what, rounds, accelerating):
    arm, rng = servo_arm(name, accelerating), random(name, f"held {what}", 0)
    for _ in range(rounds):
        for theta in starts(arm, rng):
            command, state = drawn_command(rng, what), ServoState.at(arm, theta)
            start = arm.by_pinocchio(theta)[0]
            for k in range(STEPS):
                state, _ = servo_step(arm, state, command, DT)
                if k % 10 == 0:
                    off, turned = astray(arm, state.theta, start, command)
                    assert off <= KEPT, (name, what, accelerating, theta, command, k)
                    assert turned <= TURNED, (name, what, accelerating, theta, command, k)


@pytest.mark.parametrize("name", ["ur5", pytest.param("panda", marks=pytest.mark.slow)])
def test_a_tool_that_drifts_off_its_command_is_not_called_ok(name):
    """Turning in place from singular and random postures without a hold: what the position pays is said."""
    arm, rng, drifting = servo_arm(name, accelerating=False), random(name, "drift", 0), 0
    for theta in (start for _ in range(3) for start in starts(arm, rng)):
        axis = rng.normal(size=3)
        command, state = TwistCommand([0, 0, 0, *0.4 * axis / np.linalg.norm(axis)], "base"), ServoState.at(arm, theta)
        for _ in range(100):
            state, output = servo_step(arm, state, command, DT)
            done = arm.by_pinocchio(state.theta)[2] @ state.theta_dot  # body twist
            off = np.linalg.norm(done[:3]) / arm.reach
            drifting += off > 0.05
            assert output.status != "OK" or off < 0.015, (theta, command.twist, off)
    assert drifting > 10
