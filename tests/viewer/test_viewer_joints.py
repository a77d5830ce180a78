"""The joints of the page: random configurations, limits in rad and degrees, what a servo refuses, the page's files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from recorded_poses import ask
from twistarm import ArmBuilder, load_arm
from twistarm.support.errors import LimitError
from twistarm.viewer.stage import Stage

LOWER, UPPER = (-0.5, 0.25, 0.0), (0.1, 0.3, 0.2)

ARM = (
    ArmBuilder("trio")
    .revolute("turn", [0, 0, 1], [0, 0, 0.1], lower=LOWER[0], upper=UPPER[0])
    .revolute("bend", [0, 1, 0], [0, 0, 0.3], lower=LOWER[1], upper=UPPER[1])
    .prismatic("reach", [1, 0, 0], lower=LOWER[2], upper=UPPER[2])
    .tool(np.eye(4))
    .build()
)

FREE = ArmBuilder("free").revolute("turn", [0, 0, 1], [0, 0, 0]).prismatic("reach", [1, 0, 0]).tool(np.eye(4)).build()


def at_random(stage: Stage) -> Any:
    ask(stage, "random", ease=False)
    return stage.theta


def test_random_configurations_are_inside_the_limits_and_never_the_same() -> None:
    stage = Stage(ARM)
    drawn = np.array([at_random(stage) for _ in range(200)])
    assert np.all((drawn >= LOWER) & (drawn <= UPPER))
    assert len(np.unique(drawn, axis=0)) == 200
    # Of 200 even draws, none in one of the tenths at the ends: less than 1 in 10^8 for all six.
    share = (drawn - LOWER) / np.subtract(UPPER, LOWER)
    assert np.all(share.min(axis=0) < 0.1)
    assert np.all(share.max(axis=0) > 0.9)


def test_without_limits_random_is_within_a_turn_and_a_metre() -> None:
    stage = Stage(FREE)
    for _ in range(50):
        assert np.all(np.abs(at_random(stage)) <= [np.pi, 1.0])


def test_random_leaves_the_joints_beside_the_arm_alone() -> None:
    stage = Stage(load_arm("rover_arm"))
    ask(stage, "joint", name="finger_left", value=0.02)
    at_random(stage)
    assert stage.others["finger_left"] == 0.02


PAIR = (
    ArmBuilder("pair")
    .revolute("turn", [0, 0, 1], [0, 0, 0], lower=-1.5, upper=1.5)
    .prismatic("slide", [1, 0, 0], lower=-0.2, upper=0.2)
    .tool(np.eye(4))
    .build()
)


@pytest.mark.parametrize("beyond", [1e-4, 2e-6])
@pytest.mark.parametrize(("name", "limit"), [("turn", 1.5), ("turn", -1.5), ("slide", 0.2), ("slide", -0.2)])
def test_a_little_beyond_a_limit_is_refused(name: str, limit: float, beyond: float) -> None:
    stage, value = Stage(PAIR), limit * (1 + beyond / abs(limit))
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "joint", name=name, value=value)
    with pytest.raises(LimitError, match=f"{name} = .* is outside its limits"):
        ask(stage, "theta", theta=[value if joint == name else 0.0 for joint in PAIR.joint_names])
    assert_array_equal(stage.theta, PAIR.ready)
