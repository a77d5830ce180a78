"""Success of `solve_ik` and `solve_ik_batch` on targets built reachable: every arm, every kind of target."""

from __future__ import annotations

import time

import numpy as np
import pytest

from catalogue import load
from ik_targets import KINDS, at_some_limits, judged, judged_batch, pinocchio_poses, require_core, target_from
from twistarm.ik import solve_ik, solve_ik_batch
from twistarm.ik.targets import as_target

FOUND, FOUND_AT_LIMITS, FOUND_OF_A_KIND = 0.9999, 0.999, 0.999
"""Shares that must be found, strictly; every answer called converged is judged again by Pinocchio."""

MEASURED = ("panda", "ur5", "kinova", "so101", "rover_arm", "rover_arm_6dof")

ALONE = 50
"""One in so many targets of a sweep is asked of `solve_ik` too."""


def sweep(arm, kind, count, seed):
    """How many of `count` targets are met one by one, from starts as random as the targets."""
    rng = np.random.default_rng(seed)
    found = 0
    for g in pinocchio_poses(arm, arm.random_theta(rng, count)):
        target = target_from(kind, g, rng)
        solution = solve_ik(arm, target, arm.random_theta(rng))
        assert solution.within_limits
        assert judged(arm, target, solution) == solution.converged, solution
        found += solution.converged
    return found


def sweep_at_once(arm, targets, starts, what):
    """The share of targets met as a batch, and of a part one by one; no answer is wrong, none leaves the limits."""
    begun = time.perf_counter()
    batch = solve_ik_batch(arm, targets, starts)
    micros = 1e6 * (time.perf_counter() - begun) / len(targets)
    assert arm.limits.contains(batch.theta).all()
    met = judged_batch(arm, targets, batch)
    assert (met == batch.converged).all(), f"{(met != batch.converged).sum()} wrongly told"
    alone = 0
    for i in range(0, len(targets), ALONE):
        solution = solve_ik(arm, targets[i], starts[i])
        assert judged(arm, as_target(targets[i]), solution) == solution.converged, solution
        alone += not solution.converged
    print(f"{arm.name:16}{what:12}{100 * met.mean():9.3f} % of {len(targets):6}  {micros:8.2f} us each")
    assert alone <= max(1, 0.005 * len(targets) / ALONE)
    return met.mean()


@pytest.mark.parametrize("kind", KINDS)
def test_reachable_targets_are_found(catalogue_arm, kind):
    assert sweep(catalogue_arm, kind, 20, [20260701, KINDS.index(kind)]) == 20


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_reachable_targets_are_found(catalogue_arm, kind):
    require_core(catalogue_arm)
    rng = np.random.default_rng([20260702, KINDS.index(kind)])
    poses = pinocchio_poses(catalogue_arm, catalogue_arm.random_theta(rng, 1000))
    targets = [target_from(kind, g, rng) for g in poses]
    starts = catalogue_arm.random_theta(rng, len(targets))
    assert sweep_at_once(catalogue_arm, targets, starts, kind) >= FOUND_OF_A_KIND


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_a_hundred_thousand_poses_are_found(name):
    arm, rng = load(name), np.random.default_rng([20260703, MEASURED.index(name)])
    require_core(arm)
    poses = pinocchio_poses(arm, arm.random_theta(rng, 100_000))
    assert sweep_at_once(arm, poses, arm.random_theta(rng, len(poses)), "anywhere") >= FOUND


@pytest.mark.slow
@pytest.mark.parametrize("name", MEASURED)
def test_ten_thousand_poses_at_limits_are_found(name):
    arm, rng = load(name), np.random.default_rng([20260704, MEASURED.index(name)])
    require_core(arm)
    poses = pinocchio_poses(arm, at_some_limits(arm, rng, 10_000))
    assert sweep_at_once(arm, poses, arm.random_theta(rng, len(poses)), "at limits") >= FOUND_AT_LIMITS
