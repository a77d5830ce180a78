"""A target beside what else moves the arm: what plays, and a drag beyond reach, through the stage."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from test_viewer_target import MOTION, ROVER, finish, near, start, text, told
from test_viewer_target import in_the_thread as in_the_thread
from twistarm.viewer.protocol.messages import parse
from twistarm.viewer.stage import Stage


@pytest.mark.usefixtures("in_the_thread")
def test_a_target_stops_what_plays_before_its_answer_comes() -> None:
    stage = Stage(ROVER)
    stage.load(MOTION, 1, True, 0)
    position, quaternion = near(ROVER)
    job = start(stage, kind="position", position=position.tolist(), xyzw=quaternion)
    assert not stage.running
    finish(job)
    assert told(stage)["met"]


@pytest.mark.usefixtures("in_the_thread")
def test_play_straight_after_a_target_goes_first() -> None:
    """The trajectory runs, and the arm has not left its place yet."""
    stage = Stage(ROVER)
    stage.stand_by(MOTION, ROVER.limits)
    position, quaternion = near(ROVER)
    job = start(stage, kind="position", position=position.tolist(), xyzw=quaternion)
    stage.handle(parse(text("play")), 0.0)
    finish(job)
    assert stage.running
    assert_array_equal(stage.theta, MOTION(0.0))
    stage.advance(0.5 * MOTION.duration)
    assert told(stage)["given"] is None
    assert_array_equal(stage.theta, MOTION(0.5 * MOTION.duration))


def test_dragged_beyond_its_reach_the_arm_on_show_does_not_flip() -> None:
    """Straight up, where the joints may be anyhow as long as the arm points there: a search alone turns by radians."""
    stage, thetas = Stage(ROVER), []
    p = ROVER.fk(ROVER.ready)[:3, 3]
    for k in range(30):
        finish(start(stage, kind="position", position=[p[0], p[1], p[2] + 2.0 + 0.01 * k], xyzw=[0, 0, 0, 1]))
        assert told(stage)["met"] is False
        thetas.append(stage.theta)
    assert np.abs(np.diff(thetas, axis=0)).max() < 0.1
