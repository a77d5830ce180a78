"""`solve_ik`: its answers, their order and repeatability, limits and whole turns, and what it refuses."""

from __future__ import annotations

import itertools
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import twistarm
from catalogue import load
from ik_targets import STRICT, errors, judged, moved, pinocchio_fk, turned
from strategies import generators
from twistarm import JointLimits, arm_from_screws, joints
from twistarm.arm import Coupling
from twistarm.errors import InputError, NotConvergedError
from twistarm.ik import Approach, Pose, Position, StopReason, Task, damped, race, solve_ik
from twistarm.ik.deadline import Deadline
from twistarm.ik.ranges import joint_ranges, periodic
from twistarm.ik.starts import as_seed, random_start

WRAP_TOL = 1e-12
"""Rounding of an angle and a whole number of turns."""


# answers ------------------------------------------------------------------------------------------------


def test_a_bare_pose_is_met():
    arm = load("ur5")
    g = arm.fk(np.array([0.3, -1.2, 1.4, -0.6, 0.8, 2.0]))
    solution = solve_ik(arm, g)
    assert solution.converged
    assert solution.stop is StopReason.CONVERGED
    assert judged(arm, Pose(g), solution)
    assert solution.method == "damped least squares"
    assert not solution.theta.flags.writeable
    np.testing.assert_array_equal(solution.require(), solution.theta)


def test_the_errors_are_those_of_the_answer():
    arm, rng = load("panda"), np.random.default_rng(0)
    target = Pose(arm.fk(arm.random_theta(rng)))
    solution = solve_ik(arm, target, position_tol=1e-3, orientation_tol=1e-2)
    expected = errors(target, pinocchio_fk(arm, solution.theta))
    np.testing.assert_allclose((solution.position_error, solution.orientation_error), expected, atol=1e-12)


def test_the_start_is_the_ready_pose_unless_given():
    arm = load("panda")
    g = arm.fk(arm.ready)
    solution = solve_ik(arm, g)
    assert (solution.iterations, solution.restarts) == (0, 1)
    np.testing.assert_array_equal(solution.theta, arm.ready)


@pytest.mark.parametrize("name", ["panda", "ur5", "kinova", "so101"])
def test_a_near_start_stays_near(name):
    arm, rng = load(name), np.random.default_rng(3)
    for _ in range(20):
        theta = arm.random_theta(rng)
        theta0 = joint_ranges(arm).inside(theta + rng.uniform(-0.01, 0.01, arm.n))
        solution = solve_ik(arm, arm.fk(theta), theta0)
        assert solution.converged
        assert solution.restarts == 1
        assert np.abs(solution.theta - theta0).max() < 0.2


def test_a_wide_tolerance_is_used():
    arm = load("ur5")
    g = arm.fk(arm.ready)
    solution = solve_ik(arm, moved(g, [0.02, 0, 0]), arm.ready, position_tol=0.05)
    assert solution.converged
    assert solution.iterations == 0


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


@pytest.mark.parametrize(("name", "theta", "theta0"), HARD)
def test_hard_poses_are_met(name, theta, theta0):
    arm = load(name)
    g = arm.fk(joint_ranges(arm).inside(np.array(theta, dtype=float)))
    solution = solve_ik(arm, g, theta0)
    assert judged(arm, Pose(g), solution), solution.explain()


@pytest.mark.parametrize("name", ["ur5", "panda", "so101", "kinova"])
def test_targets_with_joints_at_their_limits_are_met(name):
    arm, rng = load(name), np.random.default_rng(5)
    lower, upper = arm.sampling_bounds
    for _ in range(20):
        theta = arm.random_theta(rng)
        at = rng.random(arm.n) < 0.5
        theta[at] = np.where(rng.random(arm.n) < 0.5, lower, upper)[at]
        target = Pose(arm.fk(theta))
        assert judged(arm, target, solve_ik(arm, target, rng=int(rng.integers(1000))))


# repeatability -------------------------------------------------------------------------------------------


def test_the_same_call_gives_the_same_bits():
    arm, rng = load("so101"), np.random.default_rng(2)
    for _ in range(5):
        g = arm.fk(arm.random_theta(rng))
        first, second = solve_ik(arm, g, rng=7), solve_ik(arm, g, rng=7)
        np.testing.assert_array_equal(first.theta, second.theta)
        assert (first.iterations, first.restarts) == (second.iterations, second.restarts)


def test_an_unreachable_pose_gives_the_same_bits():
    arm = load("so101")
    g = turned(arm.fk(np.array([0.3, -0.5, 0.4, 0.2, 0.1])), [0, 1, 0], 0.4)
    np.testing.assert_array_equal(solve_ik(arm, g).theta, solve_ik(arm, g).theta)


def test_a_generator_gives_the_seed():
    arm, g = load("so101"), load("so101").fk(np.array([1.5, -1.5, 1.2, -1.0, 2.0]))
    first = solve_ik(arm, g, rng=np.random.default_rng(11))
    again = solve_ik(arm, g, rng=np.random.default_rng(11))
    np.testing.assert_array_equal(first.theta, again.theta)
    assert as_seed(np.random.default_rng(11)) != as_seed(np.random.default_rng(12))


def splitmix64(seed, count):
    """The generator as Steele, Lea & Flood print it (OOPSLA 2014, fig. 17), word by word."""
    words = []
    for _ in range(count):
        seed = (seed + 0x9E3779B97F4A7C15) % 2**64
        z = (seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % 2**64
        words.append(z ^ (z >> 31))
    return words


def test_the_generator_of_the_shifts():
    assert splitmix64(1234567, 3) == [6457827717110365317, 3203168211198807973, 9817491932198370423]


@given(st.integers(0, 2**64 - 1), st.integers(0, 10**6))
def test_starts_are_those_of_the_shifted_sequence_r_d(seed, index):
    """frac(shift + index α_i) with α_i = φ⁻ⁱ and φ⁸ = φ + 1 for seven joints, in exact fractions."""
    root = np.roots([1, 0, 0, 0, 0, 0, 0, -1, -1])
    phi = float(root[np.isreal(root)].real.max())
    ranges = joint_ranges(load("panda"))
    shift = np.array(splitmix64(splitmix64(seed, 1)[0], 7)) / 2.0**64
    start = (random_start(ranges, seed, index) - ranges.start_lower) / (ranges.start_upper - ranges.start_lower)
    off = start - (shift + index * phi ** -np.arange(1.0, 8.0))
    np.testing.assert_allclose(off - np.round(off), 0.0, atol=1e-8)


def test_starts_lie_where_random_configurations_do():
    arm = load("kinova")
    ranges = joint_ranges(arm)
    starts = np.array([random_start(ranges, 0, k) for k in range(300)])
    lower, upper = arm.sampling_bounds
    assert (starts >= lower).all()
    assert (starts <= upper).all()
    assert (np.ptp(starts, axis=0) > 0.9 * (upper - lower)).all()


# the winner: (iterations of each search, or None where it fails) -> who wins, how many are run --------------

FAILS = None
WINNERS = (
    ([5], 0, 1),  # theta0 converges: nothing else is run
    ([30, 3, 2] + [9] * 5, 0, 1),
    ([FAILS, 9, 4, 4] + [FAILS] * 4, 2, 8),  # fewest iterations, then the lowest number
    ([FAILS, 9, 9] + [9] * 5, 1, 8),
    ([FAILS] * 8 + [FAILS, 6, FAILS, 2] + [FAILS] * 4, 11, 16),  # the first round in which any converges
    ([FAILS] * 7 + [9] + [1] * 8, 7, 8),  # not a better one of a later round
    ([FAILS, 0] + [FAILS] * 6, 1, 2),  # nobody can need fewer than none
    ([FAILS] * 20, None, 20),
)


@pytest.mark.parametrize(("needed", "winner", "run"), WINNERS)
def test_who_wins_a_race(monkeypatch, needed, winner, run):
    calls = []

    def scripted(arm, target, start, bounds, tolerances, max_iterations):
        k = len(calls)
        calls.append(start)
        converged = needed[k] is not None and needed[k] <= max_iterations
        return damped.Search(np.full(arm.n, float(k)), 0.0, needed[k] or 0, converged)

    monkeypatch.setattr(race, "search", scripted)
    arm = load("ur5")
    tolerances = damped.Tolerances(STRICT, STRICT)
    ranges = joint_ranges(arm)
    result = race.race(
        arm, Pose(np.eye(4)), arm.ready, ranges, tolerances, restarts=len(needed), seed=3, deadline=Deadline()
    )
    assert (None if result.winner is None else result.winner.theta[0]) == winner
    assert len(result.searches) == len(calls) == run
    np.testing.assert_array_equal(calls[0], arm.ready)
    for k in range(1, run):
        np.testing.assert_array_equal(calls[k], random_start(ranges, 3, k))


def test_no_more_searches_than_allowed():
    arm = load("so101")
    far = moved(np.eye(4), [2.0, 0, 0])
    assert solve_ik(arm, far, restarts=3).restarts == 3
    assert solve_ik(arm, far, restarts=1).restarts == 1


# limits ---------------------------------------------------------------------------------------------------


@given(generators)
def test_a_bounded_step_solves_for_the_joints_that_are_free(rng):
    n = 6
    J = rng.normal(size=(n, n))
    H, gradient = J.T @ J + 0.1 * np.eye(n), rng.normal(size=n)
    lower, upper = -rng.uniform(0, 0.5, n), rng.uniform(0, 0.5, n)
    theta = np.where(rng.random(n) < 0.3, lower, np.where(rng.random(n) < 0.3, upper, 0.0))
    reached = damped.bounded_step(H, gradient, theta, (lower, upper))
    assert (reached >= lower).all()
    assert (reached <= upper).all()
    inside = (reached > lower) & (reached < upper)
    slope = gradient + H @ (reached - theta)
    np.testing.assert_allclose(slope[inside], 0, atol=1e-10)


def test_an_outward_pull_freezes_a_joint_at_its_bound():
    H, gradient = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-1.0, -1.0])
    bounds = np.zeros(2), np.array([0.0, 5.0])
    np.testing.assert_allclose(damped.bounded_step(H, gradient, np.zeros(2), bounds), [0.0, 0.5])


def test_a_saturated_step_is_solved_again():
    # Free, both joints would move by 1/3; the first is cut at 0.1, and the second makes up for it.
    H, gradient = np.array([[2.0, 1.0], [1.0, 2.0]]), np.array([-1.0, -1.0])
    bounds = np.full(2, -1.0), np.array([0.1, 1.0])
    np.testing.assert_allclose(damped.bounded_step(H, gradient, np.zeros(2), bounds), [0.1, 0.45])


@pytest.mark.parametrize("name", ["panda", "so101", "rover_arm"])
def test_every_answer_keeps_the_limits(name):
    arm, rng = load(name), np.random.default_rng(9)
    for _ in range(5):
        g = turned(arm.fk(arm.random_theta(rng)), [1, 0, 0], rng.uniform(-1, 1))
        solution = solve_ik(arm, g, restarts=8)
        assert solution.within_limits
        assert arm.limits.contains(solution.theta)


def test_a_start_outside_the_limits_comes_inside_first_and_is_noted():
    arm = load("panda")
    theta0 = arm.ready.copy()
    theta0[1] = arm.limits.upper[1] + 0.5
    solution = solve_ik(arm, arm.fk(arm.ready), theta0)
    assert solution.converged
    assert solution.notes == (
        f"theta0 lay outside the limits: panda_joint2 {theta0[1]:.4g} rad was brought inside, to "
        f"{arm.limits.upper[1]:.4g} rad",
    )
    assert solution.notes[0] in solution.explain()
    assert solve_ik(arm, arm.fk(arm.ready), arm.ready).notes == ()


def test_a_start_a_whole_turn_outside_comes_inside_to_the_same_place():
    arm = load("panda")
    ranges = joint_ranges(arm)
    np.testing.assert_allclose(ranges.inside(arm.ready + 2 * np.pi), arm.ready, atol=WRAP_TOL)
    np.testing.assert_array_equal(ranges.inside(arm.ready), arm.ready)


# whole turns ------------------------------------------------------------------------------------------------

Z = [0.0, 0.0, 1.0]
PERIODIC = (
    # screw, multipliers of the joints that follow the coordinate, whether 2π of it moves nothing
    ("a hinge", joints.revolute(Z, [1, 0, 0]), [1.0], True),
    ("a hinge the other way", joints.revolute(Z, [1, 0, 0]), [-1.0], True),
    ("a slide", joints.prismatic(Z), [1.0], False),
    ("a helical joint", joints.helical(Z, [1, 0, 0], 0.01), [1.0], False),
    ("a follower at half speed", np.hstack([joints.revolute(Z, [0, 0, 0])] * 2), [1.0, 0.5], False),
    ("a follower at double speed", np.hstack([joints.revolute(Z, [0, 0, 0])] * 2), [1.0, -2.0], True),
    ("a geared hinge", 2.0 * joints.revolute(Z, [1, 0, 0]), [1.0], True),
    ("a geared hinge, half", 2.0 * joints.revolute(Z, [1, 0, 0]), [0.5], True),
    ("a hinge with a slide", np.hstack([joints.revolute(Z, [0, 0, 0]), joints.prismatic(Z)]), [1.0, 0.1], False),
)


@pytest.mark.parametrize(("what", "screws", "multipliers", "expected"), PERIODIC)
def test_which_coordinates_move_nothing_in_a_whole_turn(what, screws, multipliers, expected):
    A = np.array(multipliers)[:, None]
    assert periodic(screws, A).tolist() == [expected]
    same = np.allclose(twistarm.poe.fk(screws, np.eye(4), 2 * np.pi * A[:, 0]), np.eye(4), atol=1e-9)
    assert same == expected


def spatial_arm(first, limits=None):
    """`first` (6, k), then two hinges: enough for a position."""
    home = np.eye(4)
    home[:3, 3] = [0.8, 0.0, 0.1]
    S = np.hstack([first, joints.revolute([0, 1, 0], [0, 0, 0.1]), joints.revolute([0, 1, 0], [0.5, 0, 0.1])])
    return arm_from_screws(S, home, limits=limits)


@pytest.mark.parametrize("turns", [-3, 1, 40])
def test_an_unbounded_joint_comes_back_near_its_start(turns):
    arm = spatial_arm(joints.revolute(Z, [0, 0, 0]))
    theta = np.array([0.4, -0.3, 0.9])
    theta0 = theta + np.array([0.1 + 2 * np.pi * turns, 0.1, -0.1])
    solution = solve_ik(arm, Position(arm.fk(theta)[:3, 3]), theta0)
    assert solution.converged
    assert solution.theta[0] == pytest.approx(theta0[0] - 0.1, abs=1e-5)


def test_a_wrapped_joint_stays_inside_the_limits():
    arm = load("ur5")
    theta = np.array([-1.2, -1.2, 1.4, -0.6, 0.8, 2.0])
    theta0 = np.array([5.0, -1.0, 1.2, -0.5, 1.0, -4.0])
    solution = solve_ik(arm, arm.fk(theta), theta0)
    assert solution.converged
    assert arm.limits.contains(solution.theta)
    np.testing.assert_allclose(solution.theta[[0, 5]], [-1.2 + 2 * np.pi, 2.0 - 2 * np.pi], atol=1e-5)


@given(generators)
def test_wrapping_finds_the_nearest_representative_inside(rng):
    arm = load("ur5")
    ranges = joint_ranges(arm)
    theta, near = rng.uniform(-40, 40, 6), arm.random_theta(rng)
    wrapped = ranges.wrapped(theta, near)
    for i in np.flatnonzero(ranges.turns):
        candidates = theta[i] + 2 * np.pi * np.arange(-10, 11)
        inside = candidates[(candidates >= arm.limits.lower[i]) & (candidates <= arm.limits.upper[i])]
        assert abs(wrapped[i] - near[i]) == pytest.approx(np.abs(inside - near[i]).min(), abs=WRAP_TOL)


def test_a_helical_joint_is_never_wrapped():
    arm = spatial_arm(joints.helical(Z, [0, 0, 0], 0.05))
    theta = np.array([9.0, -0.3, 0.9])
    solution = solve_ik(arm, Position(arm.fk(theta)[:3, 3]), theta + 0.05)
    assert solution.converged
    np.testing.assert_allclose(solution.theta, theta, atol=1e-4)


def test_a_follower_at_half_speed_is_never_wrapped():
    arm = spatial_arm(np.hstack([joints.revolute(Z, [0, 0, 0]), joints.revolute([1, 0, 0], [0, 0, 0.1])]))
    A = np.array([[1.0, 0, 0], [0.5, 0, 0], [0, 1, 0], [0, 0, 1]])
    coupled = replace(
        arm,
        coupling=Coupling(A, np.zeros(4)),
        joint_names=arm.joint_names[:3],
        joint_types=("revolute",) * 3,
        limits=JointLimits.unbounded(3),
    )
    theta = np.array([7.5, -0.3, 0.9])
    solution = solve_ik(coupled, Position(coupled.fk(theta)[:3, 3]), theta + 0.02)
    assert solution.converged
    np.testing.assert_allclose(solution.theta, theta, atol=1e-4)


# what is refused ----------------------------------------------------------------------------------------------

NAN = float("nan")
MISUSED = (
    (lambda arm: solve_ik("ur5", np.eye(4)), "arm must be an Arm, as load_arm returns it; got str"),
    (lambda arm: solve_ik(arm, np.eye(3)), "target must be a Pose, Position, Approach or Task, or a pose (4, 4)"),
    (lambda arm: solve_ik(arm, np.full((4, 4), NAN)), "must be finite"),
    (lambda arm: solve_ik(arm, np.diag([2.0, 2, 2, 1])), "rotation of the pose g is not in SO(3)"),
    (lambda arm: solve_ik(arm, np.eye(4), np.zeros(5)), "theta0 must have shape (..., 6): shoulder_pan_joint"),
    (lambda arm: solve_ik(arm, np.eye(4), np.zeros((2, 6))), "theta0 must be one configuration of shape (6,)"),
    (lambda arm: solve_ik(arm, np.eye(4), [NAN] * 6), "theta0 must be finite"),
    (lambda arm: solve_ik(arm, np.eye(4), position_tol=0), "position_tol [m] must be one number, at least 1e-12"),
    (lambda arm: solve_ik(arm, np.eye(4), position_tol=-1), "position_tol [m] must be one number"),
    (lambda arm: solve_ik(arm, np.eye(4), position_tol=[1, 1]), "position_tol [m] must be one number"),
    (lambda arm: solve_ik(arm, np.eye(4), orientation_tol=NAN), "orientation_tol [rad] must be finite"),
    (lambda arm: solve_ik(arm, np.eye(4), orientation_tol=0), "orientation_tol [rad] must be one number"),
    (lambda arm: solve_ik(arm, np.eye(4), restarts=0), "restarts must be a whole number, at least 1"),
    (lambda arm: solve_ik(arm, np.eye(4), restarts=2.5), "restarts must be a whole number"),
    (lambda arm: solve_ik(arm, np.eye(4), max_time=0), "max_time must be a positive number of seconds"),
    (lambda arm: solve_ik(arm, np.eye(4), max_time=NAN), "max_time [s] must be finite"),
    (lambda arm: solve_ik(arm, np.eye(4), rng=-1), "rng must be a seed, an integer from 0 to 2^64 − 1"),
    (lambda arm: solve_ik(arm, np.eye(4), rng="seed"), "rng must be a seed"),
    (lambda arm: solve_ik(arm, np.eye(4), rng=True), "rng must be a seed"),
)


@pytest.mark.parametrize(("call", "text"), MISUSED)
def test_misuse_is_refused(call, text):
    with pytest.raises(InputError) as caught:
        call(load("ur5"))
    assert text in str(caught.value)


def test_require_carries_the_solution():
    arm = load("ur5")
    solution = solve_ik(arm, Position([5.0, 0, 0]), restarts=2)
    with pytest.raises(NotConvergedError) as caught:
        solution.require()
    assert caught.value.solution is solution
    assert "ur5 does not meet the position (5, 0, 0) m: position " in str(caught.value)
    assert "out of reach; solution.explain() says more" in str(caught.value)


def test_a_solution_can_be_pickled():
    arm = load("ur5")
    solution = solve_ik(arm, Task(arm.fk(arm.ready), [0, 0, 0, 0, 0, np.inf]))
    copy = pickle.loads(pickle.dumps(solution))
    np.testing.assert_array_equal(copy.theta, solution.theta)
    assert copy.explain() == solution.explain()


def test_lists_and_single_precision_are_accepted():
    arm = load("ur5")
    g = arm.fk(arm.ready)
    for pose, theta0 in itertools.product((g.tolist(), g.astype(np.float32), np.asfortranarray(g)), (None, [0] * 6)):
        assert solve_ik(arm, pose, theta0, orientation_tol=1e-5).converged


def test_an_approach_leaves_the_turn_about_the_tool_axis_free():
    arm, rng = load("ur5"), np.random.default_rng(4)
    g = arm.fk(arm.random_theta(rng))
    solution = solve_ik(arm, Approach(g[:3, 3], g[:3, 2]))
    reached = pinocchio_fk(arm, solution.theta)
    np.testing.assert_allclose(reached[:3, 2], g[:3, 2], atol=2 * STRICT)
    np.testing.assert_allclose(reached[:3, 3], g[:3, 3], atol=2 * STRICT)
