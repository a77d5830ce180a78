"""What the pages are sent to compute the numbers of the theory: the axes of an arm and the rates of its motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from joint_arms import Joint, by_hand, from_urdf, random_chain
from recorded_poses import ask
from twistarm import ArmBuilder, load_arm, plan_joint
from twistarm.viewer.parts.theory import axes
from twistarm.viewer.stage import Stage


def test_a_thread_made_of_two_joints_has_two_axes(tmp_path: Path) -> None:
    chain, home = random_chain(["revolute", "helical"], 11)
    chain[1] = Joint("helical", chain[1].R, chain[1].point, 0.005)
    assert [axis["pitch"] for axis in axes(from_urdf(chain, home, tmp_path))["joints"]] == [0, 0, None]
    assert axes(by_hand(chain, home))["joints"][1]["pitch"] == pytest.approx(0.005, rel=1e-9)


def test_an_arm_in_wrong_units_is_shown() -> None:
    far = np.eye(4)
    far[0, 3] = 4.5e6
    stage = Stage(ArmBuilder("far").revolute("a", [0, 0, 1], [0, 0, 0]).tool(far).build())
    assert stage.hello({})["core"]["forms"] == {}


def test_the_rates_of_a_motion() -> None:
    arm = load_arm("panda")
    stage = Stage(arm)
    assert stage.frame()["rates"] is None
    goal = arm.random_theta(np.random.default_rng(2))
    trajectory = plan_joint(arm, [arm.ready, goal], limits={"velocity": 1.0, "acceleration": 2.0})
    stage.load(trajectory).play(0.0)
    assert stage.frame()["rates"] == [0.0] * arm.n
    t, step = 0.4, 1e-5
    stage.advance(t)
    rates = stage.frame()["rates"]
    assert_allclose(rates, (trajectory(t + step) - trajectory(t - step)) / (2 * step), atol=1e-8)
    ask(stage, "pause")
    assert stage.frame()["rates"] == rates
    stage.show(stage.theta + 0.01)  # elsewhere: no longer the motion's
    assert stage.frame()["rates"] is None


def test_a_motion_without_rates_is_shown_all_the_same() -> None:
    class Still:
        joint_names = load_arm("scara").joint_names
        duration = 1.0

        def __call__(self, t: Any, order: int = 0) -> Any:
            if order:
                raise ValueError("no rates")
            return np.zeros(len(self.joint_names))

    stage = Stage(load_arm("scara"))
    stage.load(Still())  # type: ignore[arg-type]
    assert stage.frame()["rates"] is None
