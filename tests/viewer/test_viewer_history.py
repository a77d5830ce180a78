"""Undo and redo on the pages, and the way to a pose: the process's side."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from recorded_poses import HOME, REACH, ask, done, said
from twistarm.support.errors import InputError, LimitError
from twistarm.viewer.stage import Stage


def test_every_edit_of_the_list_is_undone_and_redone(stage: Stage) -> None:
    """Back through four edits and forth again the list is what it was, numbers and all."""
    first, second, third = (pose["id"] for pose in said(stage, "program")["poses"])
    ask(stage, "rename", id=first, name="start")
    ask(stage, "reorder", id=third, place=0)
    ask(stage, "delete", id=second)
    ask(stage, "poses", joints=list(stage.arm.joint_names), poses=[{"name": "other", "theta": list(REACH)}])
    stood = stage.theta
    seen = [stage.poses.poses]
    for _ in range(4):
        ask(stage, "undo")
        seen.append(stage.poses.poses)
    assert [[pose.name for pose in poses] for poses in seen] == [
        ["other"], ["left", "start"], ["left", "start", "reach"], ["start", "reach", "left"], ["home", "reach", "left"]
    ]  # fmt: skip
    assert [pose.id for pose in seen[-1]] == [first, second, third]
    assert stage.theta is stood
    for poses in reversed(seen[:-1]):
        ask(stage, "redo")
        assert stage.poses.poses is poses
    with pytest.raises(InputError, match="nothing to redo"):
        ask(stage, "redo")


def test_the_way_to_a_pose_is_straight_eased_and_ends_on_it_to_the_bit(stage: Stage) -> None:
    ask(stage, "theta", theta=list(HOME))
    goal = np.array(REACH)
    ask(stage, "go", id=said(stage, "program")["poses"][1]["id"], ease=True)
    assert not said(stage, "frame")["running"]  # no trajectory plays
    shares = []
    for now in (0.0, 0.01, 0.125, 0.25, 0.375, 0.49):
        stage.advance(now)
        way = stage.theta - np.array(HOME)
        shares.append(float(way @ (goal - HOME) / ((goal - HOME) @ (goal - HOME))))
        assert_allclose(way, shares[-1] * (goal - HOME), atol=1e-12)
    assert_allclose(shares[3], 0.5)
    assert shares[1] < 0.01 < 0.99 < shares[5]  # slow at both ends
    assert stage.moving
    stage.advance(0.5)
    assert_array_equal(stage.theta, goal)
    assert not stage.moving


def pause_after_play(stage: Stage) -> None:
    ask(stage, "play")
    assert stage.running
    ask(stage, "pause")


OTHERS: dict[str, Callable[[Stage], Any]] = {
    "joint": lambda stage: ask(stage, "joint", name=stage.arm.joint_names[0], value=0.11),
    "play": pause_after_play,
    "show": lambda stage: stage.show(stage.theta),
    "servo": lambda stage: stage.begin_drive(""),
}


@pytest.mark.parametrize("other", OTHERS)
def test_whatever_else_moves_the_arm_ends_the_way_to_a_pose(stage: Stage, other: str) -> None:
    ask(stage, "theta", theta=list(HOME))
    done(ask(stage, "plan", kind="s_curve", stop=False))
    ask(stage, "go", id=said(stage, "program")["poses"][1]["id"], ease=True)
    stage.advance(0.2)
    there = np.array([0.11, *stage.theta[1:]]) if other == "joint" else stage.theta
    OTHERS[other](stage)
    stage.advance(0.3)
    assert_array_equal(stage.theta, there)
    assert not stage.moving


def test_what_is_refused_does_not_end_the_way_to_a_pose(stage: Stage) -> None:
    ask(stage, "theta", theta=list(HOME))
    ask(stage, "go", id=said(stage, "program")["poses"][1]["id"], ease=True)
    stage.advance(0.2)
    with pytest.raises(LimitError):
        ask(stage, "joint", name=stage.arm.joint_names[2], value=99.0)
    stage.advance(0.5)
    assert_array_equal(stage.theta, REACH)
