"""`reach_ball`: no configuration of any arm is outside, and it is as small as known arms allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from joint_arms import KINDS, by_hand, random_chain
from twistarm import Approach, JointLimits, Pose, Position, arm_from_screws, joints
from twistarm.arm.arm_data import Coupling
from twistarm.ik.reached import reach_ball


def farthest(arm, like, ball, seed):
    """The greatest distance from the ball's centre, over random configurations and corners of the limits."""
    rng, ends = np.random.default_rng(seed), np.array(arm.sampling_bounds)
    corners = ends[rng.integers(2, size=(1000, arm.n)), np.arange(arm.n)]
    g = arm.fk(np.vstack([arm.random_theta(rng, 3000), corners]))
    return np.linalg.norm(g[:, :3, :3] @ ball.x + g[:, :3, 3] - ball.centre, axis=1).max()


def kinds_of(arm):
    return Position([0.0] * 3), Approach([0.0] * 3, [0.0, 0.0, -1.0]).of(arm), Pose(np.eye(4))


def test_no_configuration_of_a_known_arm_is_outside(catalogue_arm):
    for like in kinds_of(catalogue_arm):
        ball = reach_ball(catalogue_arm, like)
        assert farthest(catalogue_arm, like, ball, 4) <= ball.radius <= 1.5 * farthest(catalogue_arm, like, ball, 5)


@pytest.mark.parametrize("seed", range(40))
def test_no_configuration_of_a_random_arm_is_outside(seed):
    """Joints of all six kinds, some coupled to others, and limits about any middle or missing."""
    rng = np.random.default_rng(seed)
    arm = by_hand(*random_chain(rng.choice(KINDS, size=rng.integers(1, 6)), seed))
    m, n = arm.n, rng.integers(1, arm.n + 1)
    A = np.eye(m)[:, :n]
    A[n:] = rng.normal(size=(m - n, n)) * (rng.random((m - n, n)) < 0.5)
    middle, half = 2.0 * rng.normal(size=n), rng.uniform(0.0, 3.0, n)
    lower, upper = (np.where(rng.random(n) < 0.2, sign * np.inf, middle + sign * half) for sign in (-1.0, 1.0))
    names, limits = arm.joint_names[:n], replace(JointLimits.unbounded(n), lower=lower, upper=upper)
    coupling, types = Coupling(A, np.zeros(m)), arm.joint_types[:n]
    arm = replace(arm, coupling=coupling, joint_names=names, joint_types=types, limits=limits)
    for like in kinds_of(arm):
        ball = reach_ball(arm, like, arm.sampling_bounds)
        assert farthest(arm, like, ball, seed) <= ball.radius < np.inf
        assert ball.radius <= reach_ball(arm, like).radius


def test_slides_alone_stay_in_the_ball_about_the_middle_of_their_box():
    limits = {"lower": {"a": -0.3, "b": 0.0}, "upper": {"a": 0.5, "b": 0.2}}
    home = np.eye(4)
    home[:3, 3] = [0.1, 0.0, 0.2]
    screws = np.hstack([joints.prismatic([1, 0, 0]), joints.prismatic([0, 1, 0])])
    ball = reach_ball(arm_from_screws(screws, home, joints=["a", "b"], limits=limits), Position([0.0] * 3))
    assert ball.centre == pytest.approx([0.2, 0.1, 0.2])
    assert ball.radius == pytest.approx(0.4 + 0.1, abs=1e-6)


def test_two_links_reach_their_sum():
    assert reach_ball(load("rr_planar"), Position([0.0] * 3)).radius == pytest.approx(0.7, abs=1e-6)
