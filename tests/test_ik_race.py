"""The searches of `solve_ik`: where they start, which one wins, and the same bits for the same call."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from catalogue import load
from ik_targets import STRICT, moved, turned
from twistarm.checks import as_seed
from twistarm.ik import Pose, damped, race, solve_ik
from twistarm.ik.deadline import Deadline
from twistarm.ik.ranges import joint_ranges
from twistarm.ik.starts import random_start

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
