"""Limits for arms that give none: a turning joint and a slide, with and without limits of their own."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from twistarm import Arm, ArmBuilder
from twistarm.usual_limits import defaults_line, with_defaults


@pytest.fixture(scope="module")
def arm() -> Arm:
    builder = ArmBuilder("crane").revolute("turn", [0, 0, 1], [0, 0, 0], lower=-2, upper=2, velocity=0.5)
    return builder.prismatic("reach", [1, 0, 0], lower=0, upper=0.5).tool(np.eye(4)).build()


def test_what_is_given_stays_and_what_is_not_is_usual(arm: Arm) -> None:
    limits = with_defaults(arm)
    assert limits.velocity.tolist() == [0.5, 0.25]
    assert limits.acceleration.tolist() == [3.0, 1.0]
    for name in ("lower", "upper", "jerk", "effort"):
        assert_array_equal(getattr(limits, name), getattr(arm.limits, name))


def test_other_limits_than_the_arm_s(arm: Arm) -> None:
    limits = with_defaults(arm, arm.limits.with_({"acceleration": {"reach": 7.0}}, arm.joint_names))
    assert limits.velocity.tolist() == [0.5, 0.25]
    assert limits.acceleration.tolist() == [3.0, 7.0]


def test_what_stands_in_is_said(arm: Arm) -> None:
    assert defaults_line(arm) == (
        "no limits given, used instead: velocity 0.25 m/s for reach; "
        "acceleration 3 rad/s² for turn; acceleration 1 m/s² for reach"
    )
    assert defaults_line(arm, with_defaults(arm)) == ""
