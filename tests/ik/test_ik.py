"""`solve_ik`: its answers, hard poses, and what it refuses."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from catalogue import load
from ik_targets import judged, moved, require_core
from solvers import SOLVERS
from twistarm.ik import Pose, Position, StopReason, TolerancedPose, solve_ik
from twistarm.ik.ranges import joint_ranges
from twistarm.support.checks import as_seed
from twistarm.support.errors import NotConvergedError

# answers ------------------------------------------------------------------------------------------------


def test_a_bare_pose_is_reached():
    arm = load("ur5")
    g = arm.fk(np.array([0.3, -1.2, 1.4, -0.6, 0.8, 2.0]))
    solution = solve_ik(arm, g)
    assert solution.converged
    assert solution.stop is StopReason.CONVERGED
    assert judged(arm, Pose(g), solution)
    assert solution.method == "damped least squares"
    assert not solution.theta.flags.writeable
    np.testing.assert_array_equal(solution.require(), solution.theta)


def test_the_start_is_the_ready_pose_unless_given():
    arm = load("panda")
    g = arm.fk(arm.ready)
    solution = solve_ik(arm, g)
    assert (solution.iterations, solution.restarts) == (0, 1)
    np.testing.assert_array_equal(solution.theta, arm.ready)


# hard cases: (arm, theta of the target, theta0); one line to add another ----------------------------------

PI = np.pi
HARD = (
    ("rover_arm", [0, 0, 0, 0, 0], None),  # stretched: position rows of rank 2
    ("rover_arm", [0.5, 0, 0, 0, 0], [-0.5, 1, -1, 1, 3]),  # stretched, slide at its bound
    ("ur5", [0, 0, 0, 0, 0, 0], None),  # elbow and wrist singular at once
    ("ur5", [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0]),  # the start is the answer
    ("ur5", [0.4, -1, 1.5, 0.2, 0.0, 0.3], [0.4 + PI, -1, 1.5, 0.2, 0.0, 0.3]),  # base half a turn away
    ("ur5", [1, -1, 1.5, 0.2, 1.0, 0.3 + PI], [1, -1, 1.5, 0.2, 1.0, 0.3]),  # tool turned by exactly π
    ("ur5", [1, -1, 1.5, 0.2, 1.0, 2 * PI - 0.01], [1, -1, 1.5, 0.2, 1.0, -2 * PI + 0.01]),  # across the turn
    ("ur10", [0, -PI / 2, 0, -PI / 2, 0, 0], None),  # straight up
    ("panda", [0, 0, 0, -0.0698, 0, 0, 0], None),  # straight up, at the elbow's bound
    ("panda", [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973], None),  # all joints at upper bounds
    ("panda", [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973], None),  # all at lower bounds
    ("kinova", [0, PI, PI, 0, PI, 0], None),  # continuous joints, straight up
    ("so101", [0, 0, 0, 0, 0], None),
    ("xarm7", [0, 0, 0, 0, 0, 0, 0], None),  # shoulder singular
)


@pytest.mark.parametrize("solve", SOLVERS)
@pytest.mark.parametrize(("name", "theta", "theta0"), HARD)
def test_hard_poses_are_reached(solve, name, theta, theta0):
    arm = load(name)
    g = arm.fk(joint_ranges(arm).inside(np.array(theta, dtype=float)))
    solution = solve(arm, g, theta0)
    assert judged(arm, Pose(g), solution), solution.explain()


def test_require_carries_the_solution():
    arm = load("ur5")
    require_core(arm)
    solution = solve_ik(arm, Position([5.0, 0, 0]), restarts=2)
    with pytest.raises(NotConvergedError, match="position .* out of reach") as caught:
        solution.require()
    assert caught.value.solution is solution


@pytest.mark.parametrize("restarts", [1, 3])
def test_the_same_call_gives_the_same_bits_and_no_more_searches_than_allowed(restarts):
    arm, rng = load("so101"), np.random.default_rng(2)
    poses = [*arm.fk(arm.random_theta(rng, 5)), moved(np.eye(4), [2.0, 0, 0])]
    for g in poses:
        first, second = (solve_ik(arm, g, rng=np.random.default_rng(11), restarts=restarts) for _ in range(2))
        np.testing.assert_array_equal(first.theta, second.theta)
        assert (first.iterations, first.restarts) == (second.iterations, second.restarts)
        assert first.restarts <= restarts
    assert first.restarts == restarts
    assert as_seed(np.random.default_rng(11)) != as_seed(np.random.default_rng(12))


def test_a_solution_can_be_pickled():
    arm = load("ur5")
    solution = solve_ik(arm, TolerancedPose(arm.fk(arm.ready), [0, 0, 0, 0, 0, np.inf]))
    copy = pickle.loads(pickle.dumps(solution))
    np.testing.assert_array_equal(copy.theta, solution.theta)
    assert copy.explain() == solution.explain()
