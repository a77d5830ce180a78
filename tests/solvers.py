"""Both solvers by one signature: the compiled core behind `solve_ik`, and the readable one that specifies it."""

from __future__ import annotations

import pytest

from twistarm.ik import IKSolution, readable, solve_ik
from twistarm.ik.request import checked
from twistarm.ik.targets import target_for


def readable_ik(
    arm,
    target,
    theta0=None,
    *,
    position_tol=1e-6,
    orientation_tol=1e-6,
    restarts=100,
    max_time=None,
    rng=0,
    posture=None,
):
    """`solve_ik` by the readable solver, whatever engine the arm has."""
    asked = target_for(arm, target)
    request = checked(arm, theta0, posture, (position_tol, orientation_tol), restarts, max_time, rng)
    return IKSolution(arm, readable.solve(arm, asked, request), asked)


SOLVERS = [pytest.param(solve_ik, id="core"), pytest.param(readable_ik, id="readable")]
"""Where there is no core the first is the second; tests/test_engine.py says whether there is one."""
