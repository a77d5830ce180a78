"""Configurations that follow a curve: their branches, and projection by rows that finite differences confirm."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from ik_targets import pinocchio_fk
from twistarm import Approach, Pose, Position, TolerancedPose, load_arm, rotations
from twistarm.ik.targets import target_for
from twistarm.planning.cartesian import branches as finding
from twistarm.planning.cartesian.projection import ALL_BUT_EXACT, errors_and_rows, projected

ARM = load_arm("rover_arm", limits={"acceleration": 3.0})


def likes(g: np.ndarray) -> list:
    return [
        Pose(g),
        Position(g[:3, 3]),
        Approach(g[:3, 3], g[:3, :3] @ [0.6, 0.0, 0.8], [0.6, 0.0, 0.8]),
        TolerancedPose(g, np.zeros(6)),
        TolerancedPose(g, np.zeros(6), frame="base"),
    ]


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof"])
def test_rows_are_the_derivatives_of_errors(name):
    arm = load_arm(name)
    rng = np.random.default_rng(3)
    for theta in rng.uniform(-0.5, 0.5, (5, arm.n)):
        g = arm.fk(theta)
        for like in likes(g):

            def errors(at: np.ndarray, like=like, g=g) -> np.ndarray:
                return errors_and_rows(like, g[None], arm.fk(at)[None], arm.body_jacobian(at)[None])[0][0]

            rows = errors_and_rows(like, g[None], g[None], arm.body_jacobian(theta)[None])[1][0]
            step = 1e-6 * np.eye(arm.n)
            differences = [(errors(theta + each) - errors(theta - each)) / 2e-6 for each in step]
            np.testing.assert_allclose(rows, np.transpose(differences), atol=1e-7)


def test_errors_of_a_task_away_from_its_target_are_what_exceeds_the_tolerances():
    theta = ARM.ready
    g = ARM.fk(theta)
    off = g.copy()
    off[:3, 3] += [0.02, 0.0, -0.005]
    off[:3, :3] = rotations.exp([0.0, 0.0, 0.3]) @ g[:3, :3]
    task = TolerancedPose(g, [0.005, 0.0, 0.01, np.inf, np.inf, 0.1], frame="base")
    e, J = errors_and_rows(task, g[None], off[None], ARM.body_jacobian(theta)[None])
    np.testing.assert_allclose(e[0], [0.015, 0.0, 0.0, 0.0, 0.0, 0.2], atol=1e-12)
    assert [bool(row.any()) for row in J[0]] == [True, True, False, False, False, True]


def test_projected_configurations_meet_their_targets_inside_the_limits():
    rng = np.random.default_rng(8)
    wanted = rng.uniform(np.maximum(ARM.limits.lower, -3.0), np.minimum(ARM.limits.upper, 3.0), (200, ARM.n))
    ideal = ARM.fk(wanted)
    for like in likes(ideal[0])[1:3]:
        theta, met = projected(ARM, like, ideal, wanted + rng.uniform(-0.1, 0.1, wanted.shape), ALL_BUT_EXACT)
        assert met.mean() > 0.9
        assert ARM.limits.contains(theta).all()
        for g, one in zip(ideal[met], ARM.fk(theta[met]), strict=True):
            assert like.at(g).position_error(one) <= 1e-9
            assert like.at(g).orientation_error(one) <= 1e-8


@pytest.mark.parametrize(("name", "kind"), [("rover_arm", "approach"), ("panda", "pose"), ("ur5", "approach")])
def test_branches_of_an_arm_that_is_left_free_meet_the_target_in_many_postures(name: str, kind: str) -> None:
    arm = load(name)
    g = arm.fk(arm.random_theta(22))
    like = Pose(g) if kind == "pose" else target_for(arm, Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis))
    found = finding.branches(arm, like, arm.ready)
    assert len(found) > 10
    assert (np.diff(np.linalg.norm(found - arm.ready, axis=1)) >= 0).all()
    assert arm.limits.contains(found).all()
    assert max(np.abs(found - found[0]).max(axis=1)) > 1.0
    for theta in found[::7]:
        reached = pinocchio_fk(arm, theta)
        assert like.position_error(reached) <= 1e-8
        assert like.orientation_error(reached) <= 1e-8
