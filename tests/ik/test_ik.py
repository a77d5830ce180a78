"""`solve_ik`: its answers, hard poses, and what it refuses."""

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize

from catalogue import load
from ik_targets import errors, judged, moved, pinocchio_fk, require_core, target_from
from solvers import SOLVERS
from twistarm import arm_from_screws
from twistarm.ik import Approach, Pose, Position, TolerancedPose, solve_ik
from twistarm.ik.ranges import joint_ranges
from twistarm.support.checks import as_seed
from twistarm.support.errors import NotConvergedError

# answers ------------------------------------------------------------------------------------------------


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


# What a redundant arm does with the freedom that a target leaves it.


def null_gradient(arm, theta, posture, J):
    """The way down from θ − posture that neither a row of the target nor a bound resists: 0 at a minimum."""
    free = np.ones(arm.n, dtype=bool)
    for _ in range(arm.n):
        away = np.where(free, theta - posture, 0.0)
        away[free] -= np.linalg.pinv(J[:, free], rcond=1e-6) @ J[:, free] @ away[free]
        outward = (theta <= arm.limits.lower + 1e-9) & (away > 0) | (theta >= arm.limits.upper - 1e-9) & (away < 0)
        if not outward.any():
            break
        free &= ~outward
    return away


@pytest.mark.parametrize("name", ["panda", "xarm7"])
@pytest.mark.parametrize("posture", ["theta0", "middle", "given"])
def test_the_answer_is_a_minimum_of_the_distance_to_the_posture(name, posture):
    arm, rng = load(name), np.random.default_rng(3)
    for _ in range(3):
        g, theta0, given = arm.fk(arm.random_theta(rng)), arm.random_theta(rng), arm.random_theta(rng)
        preferred = {"theta0": theta0, "middle": arm.limits.middle(), "given": given}[posture]
        plain = solve_ik(arm, g, theta0)
        near = solve_ik(arm, g, theta0, posture=given if posture == "given" else posture)
        assert near.converged
        assert judged(arm, near.target, near)
        assert np.linalg.norm(near.theta - preferred) <= np.linalg.norm(plain.theta - preferred) + 1e-9
        gradient = null_gradient(arm, near.theta, preferred, arm.by_pinocchio(near.theta)[2])
        assert np.linalg.norm(gradient) < 1e-3


@pytest.mark.parametrize("kind", ["Position", "Approach", "Pose"])
@pytest.mark.parametrize("name", ["ur5", "so101"])
def test_a_second_call_from_the_answer_moves_nothing(name, kind):
    arm, rng = load(name), np.random.default_rng(11)
    for _ in range(100):
        target = target_from(kind, arm.fk(arm.random_theta(rng)), rng)
        posture = arm.random_theta(rng)
        once = solve_ik(arm, target, arm.random_theta(rng), posture=posture)
        if once.converged:
            again = solve_ik(arm, target, once.theta, posture=posture)
            np.testing.assert_allclose(again.theta, once.theta, rtol=0, atol=1e-6)


def test_three_joints_in_a_plane_against_an_optimiser():
    """Three parallel axes 1 m apart and a position: one degree of freedom to spare; SciPy's SLSQP from the answer."""
    screws = np.array([[0, 0, 0, 0, 0, 1], [0, -1, 0, 0, 0, 1], [0, -2, 0, 0, 0, 1.0]]).T
    home = np.eye(4) + 3.0 * np.eye(4, k=3)
    arm = arm_from_screws(screws, home, limits={"lower": -2.5, "upper": 2.5})
    target, posture = Position([1.2, 1.0, 0.0]), np.array([0.3, 0.2, 0.1])
    near = solve_ik(arm, target, posture=posture)
    held = {"type": "eq", "fun": lambda x: arm.fk(x)[:2, 3] - target.p[:2]}
    best = minimize(lambda x: ((x - posture) ** 2).sum(), near.theta, constraints=held, bounds=[(-2.5, 2.5)] * 3)
    assert best.success
    np.testing.assert_allclose(near.theta, best.x, atol=1e-4)


def test_a_position_and_an_approach_leave_freedom_too():
    arm, rng = load("ur5"), np.random.default_rng(4)
    for _ in range(3):
        g = arm.fk(arm.random_theta(rng))
        for target in (Position(g[:3, 3]), Approach(g[:3, 3], g[:3, 2], [0, 0, 1])):
            plain = solve_ik(arm, target, arm.ready)
            near = solve_ik(arm, target, arm.ready, posture="theta0")
            assert max(errors(target, pinocchio_fk(arm, near.theta))) <= 1.01e-6
            assert np.linalg.norm(near.theta - arm.ready) <= np.linalg.norm(plain.theta - arm.ready) + 1e-9


def test_where_nothing_is_free_only_whole_turns_are_left():
    arm = load("ur5")
    theta = arm.random_theta(np.random.default_rng(5))
    near = solve_ik(arm, arm.fk(theta), theta + 0.01, posture="middle")
    turns = (near.theta - theta) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-5)
    assert (np.abs(near.theta) <= np.pi + 1e-6).all()
