"""Where the arm cannot follow and settings.on_unreachable is "stop": it stands on its course, says why."""

import numpy as np
import pytest
from benchmarks.servo import MADE, case, random, scaled_jacobian, servo_arm
from scipy.spatial.transform import Rotation

from family_arms import pose_of
from twistarm.control.servo import ServoSettings, ServoState, TwistCommand, servo_step

ARMS = ("four_joints", "slide_and_pitches", "rover_arm", "ur5", "panda")
TWISTS = (0, 5, 10, 15)  # Of an arm: each kind of twist, and each kind of start, once.

DT, SECONDS = 0.01, 8.0
STOP = ServoSettings(on_unreachable="stop")

OFF, TURNED = 1e-3, np.radians(0.5)  # What the tool may be beside its course [m, rad].
AT = 0.01  # How far from its limit a joint may stand that is said to be at it [rad, m].


def walk(arm, theta, twist, seconds):
    """The states and answers of a held twist in base axes."""
    state, states, answers = ServoState.at(arm, theta), [], []
    for _ in range(round(seconds / DT)):
        state, output = servo_step(arm, state, TwistCommand(twist, "base"), DT, settings=STOP)
        states.append(state)
        answers.append(output)
    return states, answers


def pose(arm, theta):
    """Of the tool, without twistarm's kinematics: by Pinocchio, or by matrix exponentials of the joints' screws."""
    return pose_of(arm, theta) if arm.name in MADE else arm.by_pinocchio(theta)[0]


def beside(arm, start, g, twist):
    """How far the tool at g is from the course of the twist from `start` on [m, rad]: p + s v, exp(s [ω]) R.

    Arms below six joints may turn the tool on the way of a twist that moves it.
    """
    v, w = np.array(twist[:3]), np.array(twist[3:])
    along, turned = g[:3, 3] - start[:3, 3], Rotation.from_matrix(g[:3, :3] @ start[:3, :3].T)
    s = along @ v / (v @ v) if v.any() else turned.as_rotvec() @ w / (w @ w)
    angle = (turned * Rotation.from_rotvec(s * w).inv()).magnitude()
    return np.linalg.norm(along - s * v), angle if arm.n >= 6 or not v.any() else 0.0


def why_is_true(arm, theta, output):
    """Whether the joint that is said to be at its limit is, or the arm loses a motion here, or has none such."""
    if output.status == "HALTED_LIMIT":
        k = arm.joint_names.index(output.joint)
        end = {"lower": arm.limits.lower, "upper": arm.limits.upper}
        return any(side in output.explain() and abs(theta[k] - end[side][k]) < AT for side in end)
    least = np.linalg.svd(scaled_jacobian(arm, theta), compute_uv=False)[min(arm.n, 6) - 1]
    return least < 0.2 or "cannot" in output.explain()


EVERY_OTHER = [
    pytest.param(name, accelerating, marks=[pytest.mark.slow] if (k + accelerating) % 2 else [])
    for k, name in enumerate(ARMS)
    for accelerating in (True, False)
]
"""Every arm once among the quick tests, with limits of acceleration or without."""


@pytest.mark.parametrize(("name", "accelerating"), EVERY_OTHER)
def test_it_stands_on_its_course_and_says_why(name, accelerating):
    arm, rng = servo_arm(name, accelerating), random(name, "on_unreachable", 0)
    for number in TWISTS:
        drawn = case(arm, rng, number)
        states, answers = walk(arm, drawn.theta, drawn.twist, SECONDS)
        label = (name, accelerating, number, drawn)
        start = pose(arm, drawn.theta)
        for state in states[99::100]:
            off, turned = beside(arm, start, pose(arm, state.theta), drawn.twist)
            assert off <= OFF, label
            assert turned <= TURNED, label
        last = states[-100:]
        if max(np.abs(state.theta_dot).max() for state in last) > 1e-4:
            continue  # still on its way
        reasons = {output.explain() for output in answers[-100:]}
        assert len(reasons) == 1, (reasons, label)
        assert answers[-1].status != "OK", label
        assert why_is_true(arm, last[-1].theta, answers[-1]), (reasons, label)


@pytest.mark.parametrize("name", [pytest.param("four_joints", marks=pytest.mark.slow), "rover_arm", "ur5"])
def test_an_arm_that_stopped_stretched_comes_back_on_its_course(name):
    arm, up = servo_arm(name), np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    stretched = walk(arm, arm.ready, up, 15.0)[0][-1].theta
    assert np.linalg.svd(scaled_jacobian(arm, stretched), compute_uv=False)[min(arm.n, 6) - 1] < 1e-3
    start = pose(arm, stretched)
    back = [pose(arm, state.theta) for state in walk(arm, stretched, -up, 1.0)[0]]
    assert max(beside(arm, start, g, -up)[0] for g in back[::10]) <= OFF
    assert start[2, 3] - back[-1][2, 3] > 0.05
