"""What its page and the docstrings promise of inverse kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import KINDS, STRICT, errors, judged, pinocchio_fk, require_core, target_from, turned
from twistarm import IKSolution, solve_ik
from twistarm.ik import Approach, StopReason

ARMS = ("rover_arm", "so101", "scara", "ur5", "panda")


@pytest.fixture(autouse=True)
def _core():
    require_core(load("rover_arm"))


# whatever is asked ------------------------------------------------------------------------------------------------


def asked_of(arm, kind, rng):
    """Targets of a kind: met, turned at random, far out, at the base's origin, half a hair beside, absurdly far."""
    g = arm.fk(arm.random_theta(rng))
    there = [g, g.copy(), g.copy(), np.eye(4), turned(g, [1, 0, 0], 1e-4), g.copy()]
    there[1][:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    there[2][:3, 3] *= 3.0
    there[5][:3, 3] = [9e5, -9e5, 9e5]
    return [target_from(kind, pose, rng) for pose in there]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_is_asked_is_answered_inside_the_limits_with_a_reason(name, kind):
    arm, rng = load(name), np.random.default_rng([31, KINDS.index(kind)])
    for target in asked_of(arm, kind, rng):
        solution = solve_ik(arm, target, arm.random_theta(rng))
        assert isinstance(solution, IKSolution)
        assert arm.limits.contains(solution.theta)
        told = solution.position_error, solution.orientation_error
        np.testing.assert_allclose(told, errors(target, pinocchio_fk(arm, solution.theta)), rtol=1e-9, atol=2e-8)
        assert judged(arm, target, solution) == solution.converged == (solution.stop is StopReason.CONVERGED)
        assert ("reason: " in solution.explain()) != solution.converged


@pytest.mark.parametrize("name", ["rover_arm", "so101", "so100"])
def test_on_a_five_joint_arm_an_approach_is_met_however_the_pose_is_rolled(name):
    """Rolled about the axis that it points, a tool still points, by the arm's own axis as by one that is named."""
    arm, rng = load(name), np.random.default_rng(32)
    axis = arm.tool_axis
    for theta in arm.random_theta(rng, 10):
        g = pinocchio_fk(arm, theta)
        direction = turned(g, axis, rng.uniform(-2, 2))[:3, :3] @ axis
        for approach in (Approach(g[:3, 3], direction), Approach(g[:3, 3], direction, axis)):
            reached = pinocchio_fk(arm, solve_ik(arm, approach).require())
            assert np.linalg.norm(reached[:3, 3] - g[:3, 3]) <= 1.01 * STRICT
            assert np.linalg.norm(reached[:3, :3] @ axis - g[:3, :3] @ axis) <= 1.01 * STRICT


@pytest.mark.parametrize("name", ["ur5", "kinova", "panda"])
def test_no_whole_turn_would_bring_a_joint_nearer_to_its_start(name):
    """Of every joint all whole turns are tried: those that lie inside the limits and move nothing, by Pinocchio."""
    arm, rng = load(name), np.random.default_rng(34)
    for theta in arm.random_theta(rng, 20):
        theta0 = arm.random_theta(rng)
        answer = solve_ik(arm, arm.fk(theta), theta0).require()
        for joint in range(arm.n):
            for turns in (-2, -1, 1, 2):
                other = answer.copy()
                other[joint] += 2 * np.pi * turns
                if arm.limits.contains(other) and np.allclose(pinocchio_fk(arm, other), pinocchio_fk(arm, answer)):
                    assert abs(other[joint] - theta0[joint]) >= abs(answer[joint] - theta0[joint]) - 1e-9
