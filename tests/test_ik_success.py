"""Success of `solve_ik` on targets built reachable, for every arm of the catalogue and every kind of target."""

from __future__ import annotations

import time

import numpy as np
import pytest

from ik_targets import KINDS, judged, target_from
from twistarm.ik import solve_ik

FOUND = 0.99
"""The share that must be found, strictly; every answer called converged is judged again by Pinocchio."""


def sweep(arm, kind, count, seed):
    """How many of `count` targets are met, from starts as random as the targets; and the seconds each call took."""
    rng = np.random.default_rng(seed)
    found, seconds = 0, []
    for _ in range(count):
        target = target_from(kind, arm.fk(arm.random_theta(rng)), rng)
        theta0 = arm.random_theta(rng)
        begun = time.perf_counter()
        solution = solve_ik(arm, target, theta0)
        seconds.append(time.perf_counter() - begun)
        assert solution.within_limits
        assert judged(arm, target, solution) == solution.converged, solution.explain()
        found += solution.converged
    return found, seconds


@pytest.mark.parametrize("kind", KINDS)
def test_reachable_targets_are_found(catalogue_arm, kind):
    found, _ = sweep(catalogue_arm, kind, 20, [20260701, KINDS.index(kind)])
    assert found >= FOUND * 20


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_thousand_reachable_targets_are_found(catalogue_arm, kind, record_property):
    found, seconds = sweep(catalogue_arm, kind, 1000, [20260702, KINDS.index(kind)])
    median, p99 = 1e3 * np.percentile(seconds, [50, 99])
    record_property("ik", f"{catalogue_arm.name} {kind}: {found / 10:.1f} %, {median:.2f} ms, p99 {p99:.1f} ms")
    print(f"{catalogue_arm.name:16}{kind:10}{found / 10:6.1f} %  median {median:6.2f} ms  p99 {p99:6.1f} ms")
    assert found >= FOUND * 1000
