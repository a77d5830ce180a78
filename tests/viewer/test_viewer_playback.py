"""A trajectory on show: its clock by hand, what pages may do to it, and what they are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from recorded_poses import ask, said
from twistarm import ArmBuilder
from twistarm.limits.joint_limits import JointLimits
from twistarm.planning.trajectory import Trajectory
from twistarm.support.errors import InputError
from twistarm.viewer.parts.playback import Playback
from twistarm.viewer.stage import Stage

ARM = ArmBuilder("one").revolute("a", [0, 0, 1], [0, 0, 0], lower=-3, upper=3).tool(np.eye(4)).build()
LINE = Trajectory(ARM.joint_names, ARM.units, [[0.0], [2.0]], [0, 2], [0, 2], [[[1.0]], [[0.0]]])
"""theta(t) = t until t = 2 s."""


@pytest.fixture
def stage() -> Stage:
    """The line is loaded and waits at its start."""
    stage = Stage(ARM)
    stage.stand_by(LINE, JointLimits.unbounded(1))
    return stage


# the clock --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("asked", "shown"), [(-1.0, 0.0), (0.0, 0.0), (0.5, 0.5), (2.0, 2.0), (2.5, 2.0), (1e6, 2.0)])
def test_a_moment_is_sought_or_the_nearer_end(stage: Stage, asked: float, shown: float) -> None:
    ask(stage, "play")
    ask(stage, "seek", time=asked)
    assert not stage.running
    assert (said(stage, "frame")["time"], stage.theta[0]) == (shown, shown)


def test_played_at_the_end_it_starts_anew(stage: Stage) -> None:
    for end in (2.0, 3.0):
        ask(stage, "seek", time=end)
        ask(stage, "play")  # at 0 s of the clock
        assert (stage.running, stage.playback.time) == (True, 0.0)
        stage.advance(0.75)
        assert (stage.running, stage.theta[0]) == (True, 0.75)
    stage.advance(9.0)
    assert (stage.running, stage.playback.time, stage.theta[0]) == (False, 2.0, 2.0)
    ask(stage, "play")
    assert stage.playback.time == 0.0


def test_paused_it_goes_on_from_where_it_was() -> None:
    at = Playback(LINE, speed=0.5)
    at.play(10.0)
    at.advance(11.0)
    at.running = False
    at.advance(12.0)
    assert at.time == 0.5
    at.play(20.0)
    at.advance(21.0)
    assert at.time == 1.0


def test_again_and_again_it_passes_the_end() -> None:
    at = Playback(LINE, loop=True)
    at.play(0.0)
    at.advance(5.5)
    assert (at.running, at.time) == (True, 1.5)
    assert_array_equal(at.theta(), [1.5])


# what pages may ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.05, 1.0, 20.0])
def test_a_pace_that_pages_may_set(stage: Stage, speed: float) -> None:
    ask(stage, "pace", speed=speed, loop=True)
    player = said(stage, "player")
    assert (player["speed"], player["loop"]) == (speed, True)
    ask(stage, "play")
    stage.advance(0.01)
    assert stage.theta[0] == pytest.approx(0.01 * speed, abs=1e-15)


@pytest.mark.parametrize("speed", [-1.0, 0.0, 0.01, 0.049, 20.1, 21.0])
def test_a_pace_that_is_refused_and_changes_nothing(stage: Stage, speed: float) -> None:
    ask(stage, "pace", speed=2.0, loop=True)
    with pytest.raises(InputError) as refused:
        ask(stage, "pace", speed=speed, loop=False)
    assert str(refused.value) == f"speed must be 0.05 … 20 times the trajectory's own; got {speed:g}"
    player = said(stage, "player")
    assert (player["speed"], player["loop"]) == (2.0, True)


@pytest.mark.parametrize(
    ("kind", "fields"), [("play", {}), ("pause", {}), ("seek", {"time": 1.0}), ("pace", {"speed": 1.0, "loop": False})]
)
def test_without_a_trajectory_there_is_nothing_to_play(kind: str, fields: dict[str, Any]) -> None:
    stage = Stage(ARM)
    with pytest.raises(InputError, match=f"nothing to {kind}: no trajectory is loaded"):
        ask(stage, kind, **fields)
    assert_array_equal(stage.theta, np.zeros(1))
