"""A trajectory on show: its clock by hand, what pages may do to it, its plots, and the way of the tool."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from recorded_poses import HOME, LEFT, REACH, ask, done, said
from twistarm import Arm, ArmBuilder, load_trajectory, plan_joint, save_trajectory
from twistarm.arm.usual_limits import with_defaults
from twistarm.planning.trajectory import Trajectory
from twistarm.support.errors import InputError
from twistarm.viewer.parts.arm_data import tool_path
from twistarm.viewer.parts.player import MOST_POINTS, plots
from twistarm.viewer.parts.show import Playback
from twistarm.viewer.stage import Stage

ARM = ArmBuilder("one").revolute("a", [0, 0, 1], [0, 0, 0], lower=-3, upper=3).tool(np.eye(4)).build()
# theta(t) = t until t = 2 s.
LINE = Trajectory(ARM.joint_names, ARM.units, [[0.0], [2.0]], [0, 2], [0, 2], [[[1.0]], [[0.0]]])


@pytest.fixture
def standing() -> Stage:
    """The line is loaded and waits at its start."""
    stage = Stage(ARM)
    stage.load(LINE)
    return stage


@pytest.mark.parametrize(("asked", "shown"), [(-1.0, 0.0), (0.0, 0.0), (0.5, 0.5), (2.0, 2.0), (2.5, 2.0), (1e6, 2.0)])
def test_a_moment_is_sought_or_the_nearer_end(standing: Stage, asked: float, shown: float) -> None:
    ask(standing, "play")
    ask(standing, "seek", time=asked)
    assert not standing.running
    assert (said(standing, "frame")["time"], standing.theta[0]) == (shown, shown)


def test_played_at_the_end_it_starts_anew(standing: Stage) -> None:
    for end in (2.0, 3.0):
        ask(standing, "seek", time=end)
        ask(standing, "play")  # at 0 s of the clock
        assert (standing.running, standing.playback.time) == (True, 0.0)
        standing.advance(0.75)
        assert (standing.running, standing.theta[0]) == (True, 0.75)
    standing.advance(9.0)
    assert (standing.running, standing.playback.time, standing.theta[0]) == (False, 2.0, 2.0)
    ask(standing, "play")
    assert standing.playback.time == 0.0


def test_paused_it_goes_on_from_where_it_was_and_again_and_again_it_passes_the_end() -> None:
    at = Playback(LINE, speed=0.5)
    for begin, end in ((10.0, 0.5), (20.0, 1.0)):
        at.play(begin)
        at.advance(begin + 1.0)
        at.running = False
        at.advance(begin + 2.0)
        assert at.time == end
    at = Playback(LINE, loop=True)
    at.play(0.0)
    at.advance(5.5)
    assert (at.running, at.time) == (True, 1.5)
    assert_array_equal(at.theta(), [1.5])


@pytest.mark.parametrize("speed", [0.05, 1.0, 20.0])
def test_a_pace_that_pages_may_set(standing: Stage, speed: float) -> None:
    ask(standing, "pace", speed=speed, loop=True)
    player = said(standing, "player")
    assert (player["speed"], player["loop"]) == (speed, True)
    ask(standing, "play")
    standing.advance(0.01)
    assert standing.theta[0] == pytest.approx(0.01 * speed, abs=1e-15)


@pytest.mark.parametrize(
    ("kind", "fields"), [("play", {}), ("pause", {}), ("seek", {"time": 1.0}), ("pace", {"speed": 1.0, "loop": False})]
)
def test_without_a_trajectory_there_is_nothing_to_play(kind: str, fields: dict[str, Any]) -> None:
    stage = Stage(ARM)
    with pytest.raises(InputError, match=f"no motion to {kind}"):
        ask(stage, kind, **fields)
    assert_array_equal(stage.theta, np.zeros(1))


ROUNDED = 0.5000001e-6  # Plots have six decimals.


@pytest.mark.parametrize("kind", ["s_curve", "time_optimal"])
def test_plots_are_samples_of_the_trajectory_and_of_what_limits_it(stage: Stage, kind: Any) -> None:
    assert said(stage, "plots")["times"] == []
    done(ask(stage, "plan", kind=kind, stop=False))
    message = said(stage, "plots")
    motion = plan_joint(stage.arm, [HOME, REACH, LEFT], kind=kind, limits=with_defaults(stage.arm))
    times = np.array(message["times"])
    assert (times[0], times[-1]) == (0.0, motion.duration)
    assert (np.diff(times) > 0).all()
    assert len(times) <= MOST_POINTS
    for order, rate in enumerate(("position", "velocity", "acceleration")):
        assert_allclose(np.transpose(message[rate]), motion(times, order), rtol=0, atol=ROUNDED)
        worst = np.abs(motion(np.linspace(0, motion.duration, 20_001), order)).max(axis=0)
        assert_allclose([joint["peak"][rate] for joint in message["joints"]], worst, rtol=1e-3)
    yaw, pitch, slide = message["joints"]
    assert (yaw["name"], yaw["unit"], slide["unit"]) == ("yaw", "rad", "m")
    assert yaw["limits"] == {"position": [None, None], "velocity": 1.0, "acceleration": 3.0}
    assert yaw["usual"] == ["velocity", "acceleration"]
    assert_allclose(yaw["range"], [-np.pi, np.pi])
    assert pitch["limits"] == {"position": [-1.5, 1.5], "velocity": 2.0, "acceleration": 3.0}
    assert slide["usual"] == ["acceleration"]


def test_a_jump_is_plotted_as_a_jump(arm: Arm) -> None:
    """A time-optimal motion's acceleration changes at once: between two samples a nanosecond of the motion apart."""
    motion = plan_joint(arm, [HOME, REACH], kind="time_optimal", limits={"velocity": 1.0, "acceleration": 2.0})
    message = plots(arm, motion)
    times, values = np.array(message["times"]), np.array(message["acceleration"])
    jumps = np.abs(np.diff(values, axis=1)).max(axis=0) > 1e-6
    assert jumps.sum() == len(motion.breakpoints) - 2
    assert np.diff(times)[jumps].max() < 1e-8


def test_a_trajectory_of_python_is_plotted_against_its_own_limits_or_the_arm_s(arm: Arm, tmp_path: Path) -> None:
    motion = plan_joint(arm, [HOME, REACH], limits={"velocity": 0.4, "acceleration": 1.7})
    read = load_trajectory(arm, save_trajectory(motion, tmp_path / "m.csv"))
    for each, velocity, acceleration in ((motion, [0.4] * 3, [1.7] * 3), (read, [None, 2.0, 0.5], [None] * 3)):
        stage = Stage(arm)
        stage.load(each).play(0.0)
        joints = said(stage, "plots")["joints"]
        assert [joint["limits"]["velocity"] for joint in joints] == velocity
        assert [joint["limits"]["acceleration"] for joint in joints] == acceleration
        assert all(joint["usual"] == [] for joint in joints)


def test_a_motion_of_many_pieces_and_one_of_none(arm: Arm) -> None:
    rng = np.random.default_rng(4)
    many = plan_joint(arm, arm.random_theta(rng, size=200), kind="time_optimal", limits=with_defaults(arm))
    assert len(plots(arm, many)["times"]) == MOST_POINTS <= 300  # about a plot's width in pixels
    still = plan_joint(arm, [HOME, HOME], limits=with_defaults(arm))
    assert plots(arm, still)["times"] == [0.0]


TOOL = np.array([[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1.0]])
TURNER = ArmBuilder("turner").revolute("a", [0, 0, 1], [0, 0, 0.1]).tool(TOOL).build()
TURN = plan_joint(TURNER, [[0.0], [np.pi / 2]], limits={"velocity": 1.0, "acceleration": 2.0})


def test_a_turn_draws_its_arc_and_configurations_their_order() -> None:
    drawn = tool_path(TURNER, TURN)
    points = np.array(drawn["points"])
    assert_allclose(np.linalg.norm(points[:, :2], axis=1), 0.3, atol=2e-6)
    assert_allclose(points[[0, -1]], [[0.3, 0, 0.4], [0, 0.3, 0.4]], atol=1e-4)
    assert len(points) <= 400
    assert 0 < drawn["radius"] < 0.01
    drawn = tool_path(TURNER, [[0.0], [np.pi], [np.pi], [np.pi / 2]])
    assert_allclose(drawn["points"], [[0.3, 0, 0.4], [-0.3, 0, 0.4], [0, 0.3, 0.4]], atol=1e-6)
    assert tool_path(TURNER, [[0.5], [0.5]])["points"] == [], "a tool that stays draws nothing"


@pytest.mark.parametrize("motion", [[0.1], np.zeros((0, 1)), [[0.1, 0.2]], [[np.nan]], [[0.0], [1e9]], "up"])
def test_what_is_no_motion(motion: object) -> None:
    with pytest.raises(InputError):
        tool_path(TURNER, motion)  # type: ignore[arg-type]
