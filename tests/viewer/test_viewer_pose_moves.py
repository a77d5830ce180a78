"""How the arm moves from one recorded pose to the next: the process's side."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from catalogue import load
from recorded_poses import ask, done, said
from twistarm import Position, Trajectory, solve_ik
from twistarm.support.errors import InputError
from twistarm.viewer.stage import Stage

ARM = load("rover_arm")
HERE = ARM.fk(ARM.ready)[:3, 3]
WAY = 1e-4
"""How far a tool may leave its way [m]."""

Points = NDArray[np.float64]


def meeting(*offset: float) -> Points:
    """A configuration with the tool's origin beside that of the ready one [m]."""
    found = solve_ik(ARM, Position(HERE + offset), ARM.ready)
    assert found.converged
    return found.theta


def recorded(*poses: tuple[Points, str]) -> Stage:
    stage = Stage(ARM, ARM.ready)
    for theta, by in poses:
        stage.show(theta)
        ask(stage, "record", name="")
        ask(stage, "move", id=said(stage, "program")["poses"][-1]["id"], by=by)
    return stage


def planned(stage: Stage, **asked: Any) -> Trajectory:
    done(ask(stage, "plan", **{"kind": "s_curve", "stop": False, "corner": 0.02, **asked}))
    assert stage.playback is not None
    return stage.playback.trajectory


def way(motion: Trajectory) -> Points:
    return ARM.fk(motion(np.linspace(0.0, motion.duration, 2001)))[:, :3, 3]


def off_line(points: Points, a: Points, b: Points) -> Points:
    """Distances of points from the straight piece between a and b."""
    along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(points - (a + along[:, None] * (b - a)), axis=1)


def test_lines_are_straight_and_corners_round_within_their_radius() -> None:
    thetas = ARM.ready, meeting(0.0, 0.0, -0.15), meeting(0.0, 0.2, -0.15)
    a, b, c = (ARM.fk(theta)[:3, 3] for theta in thetas)
    stage = recorded(*((theta, "line") for theta in thetas))
    for asked, most in (({"stop": True}, WAY), ({"corner": 0.03}, 0.03)):
        points = way(planned(stage, **asked))
        away = np.minimum(off_line(points, a, b), off_line(points, b, c))
        assert away.max() <= most
        near = np.linalg.norm(points - b, axis=1).min()
        assert near < WAY if "stop" in asked else near > 0.005
        free = np.linalg.norm(points - b, axis=1) > 0.031
        assert away[free].max() <= WAY
    path = said(stage, "path")
    assert len(path["waypoints"]) == 3
    ideal = np.array(path["ideal"])
    assert np.minimum(off_line(ideal, a, b), off_line(ideal, b, c)).max() < 1e-6
    assert np.linalg.norm(ideal - b, axis=1).min() < 1e-6


def test_an_arc_leads_through_a_pose_to_the_next() -> None:
    stage = recorded((ARM.ready, "joint"), (meeting(0.0, 0.08, -0.08), "via"), (meeting(0.0, 0.16, 0.0), "joint"))
    with pytest.raises(InputError, match="a cubic leads through joint moves alone"):
        planned(stage, kind="cubic")
    points = way(planned(stage))
    middle, radius = HERE + [0.0, 0.08, 0.0], 0.08
    assert_allclose(np.linalg.norm(points - middle, axis=1), radius, atol=WAY)
    assert_allclose(points[:, 0], HERE[0], atol=WAY)


def test_an_arc_without_an_end_is_refused_in_words() -> None:
    stage = recorded((ARM.ready, "joint"), (meeting(0.0, 0.1, 0.0), "via"))
    with pytest.raises(InputError, match="an arc leads through 'pose 2' to the pose after it"):
        planned(stage)


def test_the_tool_keeps_the_speed_that_was_asked_for() -> None:
    stage = recorded((ARM.ready, "line"), (meeting(0.0, 0.2, -0.1), "line"))
    motion = planned(stage, linear_speed=0.05)
    step = motion.duration / 2000
    speeds = np.linalg.norm(np.diff(way(motion), axis=0), axis=1) / step
    assert 0.0499 < speeds.max() <= 0.05 * (1 + 1e-6)
    assert max(said(stage, "plots")["tool"]["linear"]) == pytest.approx(speeds.max(), rel=2e-3)


def test_where_a_line_cannot_be_followed_is_drawn_and_named() -> None:
    """From before the arm to behind it: the straight way leads through its base."""
    behind = ARM.ready.copy()
    behind[ARM.joint_names.index("shoulder")] = ARM.limits.lower[ARM.joint_names.index("shoulder")]
    behind[ARM.joint_names.index("elbow")] = 0.5
    stage = recorded((ARM.ready, "line"), (behind, "line"))
    with pytest.raises(InputError, match=r"on the way to 'pose 2' the tool follows the path for .* of .* m \(\d+ %\)"):
        planned(stage)
    path, a, b = said(stage, "path"), HERE, ARM.fk(behind)[:3, 3]
    assert off_line(np.array([path["stopped"]["position"]]), a, b)[0] < WAY
    assert path["stopped"]["words"].startswith("stops at ")
    assert path["points"] == []
    assert off_line(np.array(path["ideal"]), a, b).max() < 1e-6
    assert set(path["stopped"]["arm"]) == set(path["waypoints"][0])
    assert stage.playback is None


def test_how_the_arm_moves_is_saved_undone_and_checked() -> None:
    stage = recorded((ARM.ready, "joint"), (meeting(0.0, 0.0, -0.1), "line"))
    poses = said(stage, "program")["poses"]
    with pytest.raises(InputError, match="by must be one of 'joint', 'line', 'screw', 'via'; got 'spline'"):
        ask(stage, "move", id=poses[1]["id"], by="spline")
    planned(stage)
    assert said(stage, "program")["planned"]
    ask(stage, "move", id=poses[1]["id"], by="screw")
    assert not said(stage, "program")["planned"]
    ask(stage, "undo", ease=False)
    assert said(stage, "program")["poses"][1]["by"] == "line"
    saved = [{key: pose[key] for key in ("name", "theta", "by")} for pose in said(stage, "program")["poses"]]
    ask(stage, "poses", joints=list(ARM.joint_names), poses=saved)
    assert [pose["by"] for pose in said(stage, "program")["poses"]] == ["joint", "line"]
    with pytest.raises(InputError, match="by of the pose 'pose 1' must be one of joint"):
        ask(stage, "poses", joints=list(ARM.joint_names), poses=[{**saved[0], "by": "jump"}])
