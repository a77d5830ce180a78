"""Targets beyond the reach that are followed, each answer the next start; and targets far along a slide."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import KINDS, errors, pinocchio_fk, require_core, target_from
from twistarm import arm_from_screws, solve_ik
from twistarm.ik import Position

ARMS = ("panda", "so101", "kinova", "stanford")

JUMP = 0.2  # A coordinate that moves by more [rad, m] for a step of a millimetre has jumped.

STEPS = 60


def path(arm, rng, shape):
    """Positions (STEPS, 3) a millimetre apart, on a line, a circle or an eight beyond the arm's reach."""
    d, e, f = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    s, r = 1e-3 * np.arange(STEPS), rng.uniform(0.03, 0.1)
    along, across = {
        "line": (s, 0 * s),
        "circle": (r * np.sin(s / r), r * np.cos(s / r)),
        "eight": (r * np.sin(s / r), r * np.sin(2 * s / r) / 2),
    }[shape]
    reached = arm.fk(arm.random_theta(np.random.default_rng(0), 500))[:, :3, 3]
    middle = reached.mean(0)
    radius = np.linalg.norm(reached - middle, axis=1).max()
    return middle + rng.uniform(1.3, 2.0) * radius * d + np.outer(along, e) + np.outer(across, f)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_that_follows_a_target_beyond_its_reach_does_not_jump(name):
    arm, rng, jumps, silent = load(name), np.random.default_rng(41), 0, 0
    require_core(arm)
    for kind, shape in itertools.product(KINDS, ("line", "circle", "eight")):
        theta, seed = arm.random_theta(rng), int(rng.integers(2**31))
        R = Rotation.random(random_state=seed).as_matrix()
        for i, p in enumerate(path(arm, rng, shape)):
            g = np.eye(4)
            g[:3, :3], g[:3, 3] = R, p
            solution = solve_ik(arm, target_from(kind, g, np.random.default_rng(seed)), theta)
            assert not solution.converged
            jumped = i > 0 and np.abs(solution.theta - theta).max() > JUMP
            jumps += jumped
            silent += jumped and not any("another branch" in note for note in solution.notes)
            theta = solution.theta
    assert jumps <= 0.01 * len(KINDS) * 3 * STEPS
    assert silent == 0


@pytest.mark.parametrize("name", ["ur5", "panda", "rover_arm_6dof"])
def test_no_configuration_as_near_is_nearer_to_the_start(name):
    """SciPy's SLSQP, along the configurations that are as near to the target, finds none by more than a hair."""
    arm, rng = load(name), np.random.default_rng(43)
    require_core(arm)
    for _ in range(3):
        p = rng.normal(size=3)
        target, start = Position(p * (arm.reach + 0.5) / np.linalg.norm(p)), arm.random_theta(rng)
        solution = solve_ik(arm, target, start)

        def beyond(theta, target=target, least=solution.position_error):
            return 1e3 * (least + 1e-11 - errors(target, pinocchio_fk(arm, theta))[0])

        peer = minimize(
            lambda theta, start=start: 0.5 * np.sum((theta - start) ** 2), solution.theta, method="SLSQP",
            bounds=list(zip(arm.limits.lower, arm.limits.upper, strict=True)),
            constraints={"type": "ineq", "fun": beyond}, options={"ftol": 1e-12, "maxiter": 200},
        ).x  # fmt: skip
        found, by_peer = (np.linalg.norm(theta - start) for theta in (solution.theta, peer))
        assert beyond(peer) < -1e-6 or found <= by_peer + 0.01


@pytest.mark.parametrize("distance", [30.0, 1000.0, 90_000.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_slide_whose_limits_are_only_written_down_is_followed_along(kind, distance):
    elbow, rail = load("elbow"), np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    limits = {"lower": np.r_[-999_999.0, elbow.limits.lower], "upper": np.r_[999_999.0, elbow.limits.upper]}
    arm = arm_from_screws(np.column_stack([rail, elbow.screws]), elbow.home, limits=limits)
    require_core(arm)
    rng = np.random.default_rng(47)
    for side in (-distance, distance):
        theta = np.r_[side, elbow.random_theta(rng)]
        assert solve_ik(arm, target_from(kind, arm.fk(theta), rng)).converged
    off = solve_ik(arm, Position([0.0, distance, 10 * elbow.reach]))
    assert off.position_error < 11 * elbow.reach
