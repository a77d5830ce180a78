"""The view from Python: configurations, trajectories, the stand-alone page, and frames in a notebook."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from twistarm import Arm, arm_from_screws, joints
from twistarm.planning.joint_space import plan_joint
from twistarm.support.errors import InputError
from twistarm.viewer import Viewer, save_html
from twistarm.viewer.stage import Stage
from viewer_page import THETA, stored, swing


@pytest.mark.parametrize(
    ("theta", "reason"),
    [
        ([0, 0], r"theta .*yaw, pitch, slide.*\(2,\)"),
        ([0, 0, np.nan], "theta"),
        ([[0, 0, 0]], r"theta .*\(1, 3\)"),
        ([0, 0, 1e300], r"1e\+300"),
    ],
)
def test_a_bad_configuration_is_refused_at_the_door(arm: Arm, viewer: Viewer, theta: Any, reason: str) -> None:
    for door in (viewer.show, lambda bad: Viewer(arm, bad, open_browser=False)):
        with pytest.raises(InputError, match=reason):
            door(theta)
    assert_array_equal(viewer.theta, THETA)


def test_a_motion_without_length_stops_at_once(arm: Arm) -> None:
    stage = Stage(arm)
    stage.load(plan_joint(arm, [THETA, THETA], limits={"velocity": 1.0, "acceleration": 1.0}), loop=True).play(0.0)
    stage.advance(1.0)
    assert not stage.running
    assert_allclose(stage.theta, THETA)


def test_a_trajectory_of_another_arm_is_refused(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    other = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=["elbow"])
    motion = plan_joint(other, [[0], [1]], limits={"velocity": 1.0, "acceleration": 1.0})
    with pytest.raises(InputError, match="elbow.*yaw, pitch, slide"):
        viewer.play(motion)
    with pytest.raises(InputError, match="elbow"):
        viewer.save_html(tmp_path / "view.html", motion)
    with pytest.raises(InputError, match="speed"):
        viewer.play(swing(arm), speed=0)
    assert list(tmp_path.iterdir()) == []


def test_the_stand_alone_page_needs_nothing_from_anywhere(arm: Arm, tmp_path: Path) -> None:
    path = save_html(arm, tmp_path / "view.html", trajectory=swing(arm))
    text = path.read_text(encoding="utf-8")
    assert re.search(r"""(?:src|href)=["'](?!data:)""", re.sub(r"<script.*?</script>", "", text, flags=re.S)) is None
    assert text.count("<script") == text.count("</script>") == 5
    assert "default-src 'none'" in text
    assert text.index('id="state">{}') < text.index('<script type="module">')
    with pytest.raises(InputError, match="does not exist"):
        save_html(arm, tmp_path / "nowhere" / "view.html")
    assert list(tmp_path.iterdir()) == [path]


class Frames(HTMLParser):
    """The attributes of each iframe, unescaped; nothing else may stand in what a notebook is given."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.found: list[dict[str, str | None]] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag == "iframe"
        self.found.append(dict(attrs))

    def handle_data(self, data: str) -> None:
        pytest.fail(f"text beside the frame: {data[:80]}")


def frame(shown: Any) -> dict[str, str]:
    (only,) = Frames(shown._repr_html_()).found
    return {name: value or "" for name, value in only.items()}


def test_a_viewer_as_the_last_line_of_a_cell_is_its_live_page(viewer: Viewer) -> None:
    assert frame(viewer) == frame(viewer.inline())
    shown = frame(viewer.inline(height=300))
    assert shown["src"] == viewer.url
    assert shown["height"] == "300"
    assert shown["title"] == "small · twistarm"
    assert {word.strip() for word in shown["allow"].split(";")} == {"clipboard-write", "gamepad", "fullscreen"}


def test_a_static_frame_holds_the_page_of_what_is_on_show_and_is_shut_in(viewer: Viewer) -> None:
    shown = frame(viewer.inline(static=True))
    assert set(shown["sandbox"].split()) == {"allow-scripts", "allow-downloads"}
    assert viewer.url.split("/")[3] not in shown["srcdoc"], "the token is not handed on"
    assert stored(shown["srcdoc"])["frame"]["theta"] == list(THETA)


@pytest.mark.parametrize("static", [False, True])
def test_no_name_breaks_out_of_the_frame(static: bool) -> None:
    nasty = '"></iframe><script>hacked()</script>'
    other = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=[nasty], name=nasty)
    with Viewer(other, open_browser=False) as view:
        assert frame(view.inline(static=static))["title"] == f"{nasty} · twistarm"
