"""Both solvers by one signature: the compiled core behind `solve_ik`, and the textbook's."""

import pytest

from twistarm.ik import IKResult, solve_ik, textbook
from twistarm.ik.request import checked
from twistarm.ik.targets import target_for


def textbook_ik(arm, target, theta0=None, **how):
    """`solve_ik` as it answers without a core."""
    asked = target_for(arm, target)
    usual = {
        "position_tol": 1e-6,
        "orientation_tol": 1e-6,
        "restarts": 100,
        "max_time": None,
        "rng": 0,
        "posture": None,
    }
    request = checked(arm, theta0, **usual | how)
    return IKResult(arm, textbook.solve(arm, asked, request), asked)


# Where there is no core the first is the second; tests/arm/test_engine.py says whether there is one.
SOLVERS = [pytest.param(solve_ik, id="core"), pytest.param(textbook_ik, id="textbook")]
