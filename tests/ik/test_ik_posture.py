"""What a redundant arm does with the freedom that a target leaves it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from catalogue import load
from ik_targets import errors, judged, pinocchio_fk, target_from
from twistarm import arm_from_screws
from twistarm.ik import Approach, Position, solve_ik


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
    home = np.eye(4)
    home[0, 3] = 3.0
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
