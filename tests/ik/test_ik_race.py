"""The searches of `solve_ik`: where they start, which one wins, and the same bits for the same call."""

from __future__ import annotations

import numpy as np

from catalogue import load
from ik_targets import moved, turned
from twistarm.ik import solve_ik
from twistarm.support.checks import as_seed

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


def test_no_more_searches_than_allowed():
    arm = load("so101")
    far = moved(np.eye(4), [2.0, 0, 0])
    assert solve_ik(arm, far, restarts=3).restarts == 3
    assert solve_ik(arm, far, restarts=1).restarts == 1
