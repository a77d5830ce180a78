"""The compiled core against the readable solver: the same verdict on every kind of target, and no worse a nearest."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from ik_targets import KINDS, judged, target_from
from solvers import readable_ik
from twistarm.ik import Pose, Position, solve_ik

ARMS = ("rover_arm", "so101", "scara", "rover_arm_6dof", "ur5", "panda")

POSITION_SLACK, ROTATION_SLACK = 1e-6, 1e-5
"""How much farther [m, rad] than the readable solver's a nearest configuration may be, the rotation where positions are
equal: both are the best of many minima."""


@pytest.fixture(autouse=True)
def _compiled():
    if load("rover_arm").compiled is None:
        pytest.skip("no compiled core; tests/test_engine.py says whether there should be one")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ARMS)
def test_the_same_verdict_on_reachable_targets(name, kind):
    arm, rng = load(name), np.random.default_rng([1, KINDS.index(kind)])
    for theta, theta0 in zip(arm.random_theta(rng, 5), arm.random_theta(rng, 5), strict=True):
        target = target_from(kind, arm.fk(theta), rng)
        ours, readable = solve_ik(arm, target, theta0), readable_ik(arm, target, theta0)
        assert ours.stop is readable.stop
        assert judged(arm, target, ours) == ours.converged


def unreachable(arm, rng):
    """A pose turned at random where the tool is, one too far out, and a position out of reach."""
    g = arm.fk(arm.random_theta(rng))
    turned, far = g.copy(), g.copy()
    turned[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turned[:3, :3] *= np.sign(np.linalg.det(turned[:3, :3]))
    far[:3, 3] *= 1.3 * arm.reach / np.linalg.norm(far[:3, 3])
    return Pose(turned), Pose(far), Position(1.5 * far[:3, 3])


@pytest.mark.parametrize("name", ARMS)
def test_the_same_verdict_where_there_is_no_answer(name):
    arm, rng = load(name), np.random.default_rng(2)
    for target in unreachable(arm, rng):
        ours, readable = solve_ik(arm, target), readable_ik(arm, target)
        assert ours.stop is readable.stop, (ours, readable)
        assert ours.position_error <= readable.position_error + POSITION_SLACK
        if ours.position_error >= readable.position_error - POSITION_SLACK:
            assert ours.orientation_error <= readable.orientation_error + ROTATION_SLACK
