"""Limits and whole turns in `solve_ik`: answers that keep the bounds, joints that come back near their start."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

import twistarm
from catalogue import load
from strategies import generators
from twistarm import JointLimits, arm_from_screws, joints
from twistarm.arm.arm_data import Coupling
from twistarm.ik import Position, solve_ik
from twistarm.ik.ranges import joint_ranges, periodic

WRAP_TOL = 1e-12  # Rounding of an angle and a whole number of turns.

# limits ---------------------------------------------------------------------------------------------------


def test_a_start_outside_the_limits_comes_inside_first_and_is_noted():
    arm = load("panda")
    theta0 = arm.ready.copy()
    theta0[1] = arm.limits.upper[1] + 0.5
    solution = solve_ik(arm, arm.fk(arm.ready), theta0)
    assert solution.converged
    assert solution.notes == (
        f"theta0 lay outside the limits: panda_joint2 {np.degrees(theta0[1]):.1f}° was brought inside, to "
        f"{np.degrees(arm.limits.upper[1]):.1f}°",
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


@pytest.mark.parametrize("turns", [-3, 1, 140_000])
def test_an_unbounded_joint_comes_back_near_its_start(turns):
    arm = spatial_arm(joints.revolute(Z, [0, 0, 0]))
    theta = np.array([0.4, -0.3, 0.9])
    theta0 = theta + np.array([0.1 + 2 * np.pi * turns, 0.1, -0.1])
    solution = solve_ik(arm, Position(arm.fk(theta)[:3, 3]), theta0)
    assert solution.converged
    assert solution.theta[0] == pytest.approx(theta0[0] - 0.1, abs=1e-5)


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


def coupled_at_half_speed():
    arm = spatial_arm(np.hstack([joints.revolute(Z, [0, 0, 0]), joints.revolute([1, 0, 0], [0, 0, 0.1])]))
    A = np.array([[1.0, 0, 0], [0.5, 0, 0], [0, 1, 0], [0, 0, 1]])
    free = JointLimits.unbounded(3)
    names, types = arm.joint_names[:3], ("revolute",) * 3
    return replace(arm, coupling=Coupling(A, np.zeros(4)), joint_names=names, joint_types=types, limits=free)


@pytest.mark.parametrize("made", [lambda: spatial_arm(joints.helical(Z, [0, 0, 0], 0.05)), coupled_at_half_speed])
def test_what_does_not_return_in_a_whole_turn_is_never_wrapped(made):
    arm, theta = made(), np.array([7.5, -0.3, 0.9])
    solution = solve_ik(arm, Position(arm.fk(theta)[:3, 3]), theta + 0.02)
    assert solution.converged
    np.testing.assert_allclose(solution.theta, theta, atol=1e-4)
