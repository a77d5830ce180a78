"""Targets built reachable are reached, of every kind by every arm; and whatever is asked is answered."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import (
    KINDS,
    at_some_limits,
    errors,
    judged,
    judged_batch,
    pinocchio_fk,
    pinocchio_poses,
    require_core,
    target_from,
    turned,
)
from twistarm.ik import StopReason, solve_ik, solve_ik_batch
from twistarm.ik.targets import as_target

MEASURED = ("panda", "ur5", "kinova", "so101", "rover_arm", "rover_arm_6dof")

ALONE = 50  # One in so many targets of a sweep is asked of `solve_ik` too.


def sweep_at_once(arm, targets, rng):
    """The share of targets reached as a batch, and of a part one by one; no answer is wrong, none leaves the limits."""
    starts = arm.random_theta(rng, len(targets))
    batch = solve_ik_batch(arm, targets, starts)
    assert arm.limits.contains(batch.theta).all()
    reached = judged_batch(arm, targets, batch)
    assert (reached == batch.converged).all(), f"{(reached != batch.converged).sum()} wrong verdicts"
    alone = 0
    for i in range(0, len(targets), ALONE):
        solution = solve_ik(arm, targets[i], starts[i])
        assert judged(arm, as_target(targets[i]), solution) == solution.converged, solution
        alone += not solution.converged
    assert alone <= max(1, 0.005 * len(targets) / ALONE)
    return reached.mean()


@pytest.mark.parametrize("kind", KINDS)
def test_reachable_targets_are_found(catalogue_arm, kind):
    arm, rng = catalogue_arm, np.random.default_rng([20260701, KINDS.index(kind)])
    for g in pinocchio_poses(arm, arm.random_theta(rng, 20)):
        target = target_from(kind, g, rng)
        assert judged(arm, target, solve_ik(arm, target, arm.random_theta(rng)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_reachable_targets_are_found(catalogue_arm, kind):
    require_core(catalogue_arm)
    rng = np.random.default_rng([20260702, KINDS.index(kind)])
    poses = pinocchio_poses(catalogue_arm, catalogue_arm.random_theta(rng, 1000))
    assert sweep_at_once(catalogue_arm, [target_from(kind, g, rng) for g in poses], rng) >= 0.999


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_a_hundred_thousand_poses_are_found_and_ten_thousand_at_limits(name):
    arm, rng = load(name), np.random.default_rng([20260703, MEASURED.index(name)])
    require_core(arm)
    assert sweep_at_once(arm, pinocchio_poses(arm, arm.random_theta(rng, 100_000)), rng) >= 0.9999
    assert sweep_at_once(arm, pinocchio_poses(arm, at_some_limits(arm, rng, 10_000)), rng) >= 0.999


def asked_of(arm, kind, rng):
    """Targets of a kind: reached, turned at random, far out, at the base's origin, half a hair beside, absurdly far."""
    g = arm.fk(arm.random_theta(rng))
    there = [g, g.copy(), g.copy(), np.eye(4), turned(g, [1, 0, 0], 1e-4), g.copy()]
    there[1][:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    there[2][:3, 3] *= 3.0
    there[5][:3, 3] = [9e5, -9e5, 9e5]
    return [target_from(kind, pose, rng) for pose in there]


@pytest.mark.parametrize("name", ["rover_arm", "so101", "scara", "ur5", "panda"])
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_is_asked_is_answered_inside_the_limits_with_a_reason(name, kind):
    arm, rng = load(name), np.random.default_rng([31, KINDS.index(kind)])
    require_core(arm)
    for target in asked_of(arm, kind, rng):
        solution = solve_ik(arm, target, arm.random_theta(rng))
        assert arm.limits.contains(solution.theta)
        given = solution.position_error, solution.orientation_error
        np.testing.assert_allclose(given, errors(target, pinocchio_fk(arm, solution.theta)), rtol=1e-9, atol=2e-8)
        assert judged(arm, target, solution) == solution.converged == (solution.stop is StopReason.CONVERGED)
        assert ("reason: " in solution.explain()) != solution.converged
