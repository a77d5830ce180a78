"""The reachable cloud: its points are poses inside the limits, its colours the dexterity there, made when asked for."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from recorded_poses import ask
from twistarm import Arm, ArmBuilder, load_arm
from twistarm.viewer.parts.workspace import POINTS, SEED, dexterity_of, directions_of, sampled_workspace
from twistarm.viewer.protocol.jobs import Job, ReplacedError
from twistarm.viewer.stage import Stage

ARM = load_arm("rover_arm")


def cloud_of(arm: Arm) -> tuple[dict[str, Any], NDArray[np.float32], NDArray[np.float64]]:
    """The message, its points (N, 3) and its dexterities (N,)."""
    cloud = sampled_workspace(arm, lambda share: None)
    points = np.frombuffer(base64.b64decode(cloud["points"]), "<f4").reshape(-1, 3)
    values = np.frombuffer(base64.b64decode(cloud["values"]), np.uint8) / 255 * cloud["best"]
    return cloud, points, values


@pytest.mark.parametrize("name", ["panda", "scara"])
def test_points_are_reached_inside_the_limits_and_coloured_by_dexterity(name: str) -> None:
    arm = load_arm(name)
    cloud, points, values = cloud_of(arm)
    theta = arm.random_theta(np.random.default_rng(SEED), POINTS)
    assert np.all((theta >= arm.limits.lower) & (theta <= arm.limits.upper))
    assert points.shape == (POINTS, 3) == (cloud["count"], 3)
    assert np.all((values >= 0) & (values <= 1))
    assert cloud["directions"] == min(6, arm.n)
    chosen = np.r_[0:20, 999:1003, POINTS - 20 : POINTS]  # both sides of a batch's end
    g, _, body = arm.by_pinocchio(theta[chosen])
    assert_allclose(points[chosen], g[:, :3, 3], atol=1e-6)
    scaled = body * np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    scaled[:, :3] /= arm.reach
    if arm.n < 6:
        scaled = scaled.swapaxes(1, 2)
    gram = np.linalg.eigvalsh(scaled @ scaled.swapaxes(1, 2))
    assert_allclose(values[chosen], np.sqrt(np.clip(gram[:, 0], 0, None) / gram[:, -1]), atol=cloud["best"] / 500)


def test_directions_that_an_arm_never_has_do_not_count() -> None:
    builder = ArmBuilder("twins").revolute("a", [0, 0, 1], [0, 0, 0]).revolute("b", [0, 0, 1], [0, 0, 0.2])
    arm = builder.revolute("c", [0, 0, 1], [0.5, 0, 0]).tool(np.eye(4)).build()
    cloud, _, values = cloud_of(arm)  # a and b turn about one axis
    assert cloud["directions"] == 2
    assert values.max() > 0.1


def test_an_arm_that_never_moves_its_tool_is_dark() -> None:
    assert directions_of(np.zeros((5, 2))) == 0
    assert_allclose(dexterity_of(np.zeros((5, 2)), 0), np.zeros(5))
    assert_allclose(dexterity_of(np.array([[2.0, 0.5], [1.0, 0.0], [0.0, 0.0]]), 2), [0.25, 0.0, 0.0])


def switch(stage: Stage, on: bool) -> Job | None:
    return ask(stage, "visible", what="workspace", visible=on)


def clouds(stage: Stage) -> list[dict[str, Any]]:
    return [message for message in stage.messages() if message["type"] == "workspace"]


def test_it_is_sampled_once_when_first_switched_on() -> None:
    stage = Stage(ARM)
    assert ask(stage, "visible", what="frames", visible=True) is None
    assert switch(stage, False) is None
    job = switch(stage, True)
    assert job is not None
    assert job.key == "workspace"
    assert ask(stage, "visible", what="frames", visible=False) is None
    assert clouds(stage) == []
    shares: list[float] = []
    job.finish(job.work(shares.append))
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert 0.9 < shares[-1] < 1
    (first,), (second,) = clouds(stage), clouds(stage)
    assert first is second  # encoded once
    assert switch(stage, False) is None
    assert switch(stage, True) is None


def test_it_ends_where_a_later_job_waits() -> None:
    def replaced(share: float) -> None:
        raise ReplacedError

    with pytest.raises(ReplacedError):
        sampled_workspace(ARM, replaced)
