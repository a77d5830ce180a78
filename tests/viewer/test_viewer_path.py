"""The way of the tool, as it is drawn: through the right points, live and on the stand-alone page."""

from __future__ import annotations

import json

import numpy as np
import pytest

from twistarm import ArmBuilder, Viewer, plan_joint
from twistarm.support.errors import InputError
from twistarm.viewer.parts.tool_path import MOST_POINTS, tool_path

HOME = np.array([[1, 0, 0, 0.3], [0, 1, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1.0]])
ARM = ArmBuilder("turner").revolute("a", [0, 0, 1], [0, 0, 0.1]).tool(HOME).build()
MOTION = plan_joint(ARM, [[0.0], [np.pi / 2]], limits={"velocity": 1.0, "acceleration": 2.0})


def test_a_turn_draws_its_arc_from_end_to_end() -> None:
    drawn = tool_path(ARM, MOTION)
    points = np.array(drawn["points"])
    np.testing.assert_allclose(np.linalg.norm(points[:, :2], axis=1), 0.3, atol=2e-6)
    np.testing.assert_allclose(points[[0, -1]], [[0.3, 0, 0.4], [0, 0.3, 0.4]], atol=1e-4)
    assert len(points) <= MOST_POINTS
    assert 0 < drawn["radius"] < 0.01


def test_configurations_in_their_order() -> None:
    drawn = tool_path(ARM, [[0.0], [np.pi], [np.pi], [np.pi / 2]])
    np.testing.assert_allclose(drawn["points"], [[0.3, 0, 0.4], [-0.3, 0, 0.4], [0, 0.3, 0.4]], atol=1e-6)


def test_a_long_way_is_drawn_by_400_points_and_ends_where_it_ends() -> None:
    """Evenly along an arc of 3 rad: steps of 2 mm, whose chords are 2 µm from the arc."""
    points = np.array(tool_path(ARM, np.linspace(0, 3, 5000)[:, None])["points"])
    assert len(points) == 400
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    np.testing.assert_allclose(steps, 0.3 * 3 / 399, rtol=5e-2)  # 12 or 13 of the 4999 steps
    np.testing.assert_allclose(points[-1], [0.3 * np.cos(3), 0.3 * np.sin(3), 0.4], atol=1e-6)
    moving = np.array(tool_path(ARM, MOTION)["points"])
    assert 350 < len(moving) <= 400  # some steps beside rest are too short to be seen
    assert np.linalg.norm(np.diff(moving, axis=0), axis=1).max() < 2 * 0.3 * np.pi / 2 / 399  # twice the mean speed


def test_a_tool_that_stays_draws_nothing() -> None:
    still = ArmBuilder("still").revolute("a", [0, 0, 1], HOME[:3, 3]).tool(HOME).build()
    assert tool_path(still, [[0.0], [1.0], [2.0]])["points"] == []
    assert tool_path(ARM, [[0.5]])["points"] == []


@pytest.mark.parametrize(
    ("motion", "message"),
    [
        ([0.1], "motion must be a Trajectory or configurations (k, 1); got shape (1,)"),
        (np.zeros((0, 1)), "motion must be a Trajectory or configurations (k, 1); got shape (0, 1)"),
        ([[0.1, 0.2]], "motion must have shape (..., 1): a; got (1, 2)"),
        ([[np.nan]], "motion must be finite"),
        ([[0.0], [1e9]], "theta must be at most 1e+06 in size"),
        ("up", "motion must be an array of real numbers"),
    ],
)
def test_what_is_no_motion(motion: object, message: str) -> None:
    with pytest.raises(InputError) as caught:
        tool_path(ARM, motion)  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_the_view_draws_it_and_takes_it_away() -> None:
    with Viewer(ARM, open_browser=False) as viewer:
        viewer.show_path(MOTION)
        way = viewer._server.ask(lambda stage: stage.path)
        assert way == {"type": "path", **tool_path(ARM, MOTION)}
        assert json.loads(viewer._server.ask(lambda stage: viewer._server.state())["path"]) == way
        viewer.show_path(None)
        assert viewer._server.ask(lambda stage: stage.path)["points"] == []
