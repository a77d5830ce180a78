"""What its page and the docstrings promise of inverse kinematics."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import KINDS, errors, judged, pinocchio_fk, require_core, target_from, turned
from twistarm import IKSolution, solve_ik
from twistarm.ik import StopReason

ARMS = ("rover_arm", "so101", "scara", "ur5", "panda")


@pytest.fixture(autouse=True)
def _core():
    require_core(load("rover_arm"))


# whatever is asked ------------------------------------------------------------------------------------------------


def asked_of(arm, kind, rng):
    """Targets of a kind: met, turned at random, far out, at the base's origin, half a hair beside, absurdly far."""
    g = arm.fk(arm.random_theta(rng))
    there = [g, g.copy(), g.copy(), np.eye(4), turned(g, [1, 0, 0], 1e-4), g.copy()]
    there[1][:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    there[2][:3, 3] *= 3.0
    there[5][:3, 3] = [9e5, -9e5, 9e5]
    return [target_from(kind, pose, rng) for pose in there]


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("kind", KINDS)
def test_whatever_is_asked_is_answered_inside_the_limits_with_a_reason(name, kind):
    arm, rng = load(name), np.random.default_rng([31, KINDS.index(kind)])
    for target in asked_of(arm, kind, rng):
        solution = solve_ik(arm, target, arm.random_theta(rng))
        assert isinstance(solution, IKSolution)
        assert arm.limits.contains(solution.theta)
        told = solution.position_error, solution.orientation_error
        np.testing.assert_allclose(told, errors(target, pinocchio_fk(arm, solution.theta)), rtol=1e-9, atol=2e-8)
        assert judged(arm, target, solution) == solution.converged == (solution.stop is StopReason.CONVERGED)
        assert ("reason: " in solution.explain()) != solution.converged
