"""The view from Python: configurations, trajectories, and the stand-alone page."""

from __future__ import annotations

import json
import re
import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from twistarm import Arm, arm_from_screws, joints
from twistarm.planning.joint_space import plan_joint
from twistarm.support.errors import InputError, LimitError, UnknownNameError
from twistarm.viewer import Viewer, save_html
from twistarm.viewer.protocol.messages import parse
from twistarm.viewer.stage import Stage
from viewer_page import ROUNDING, THETA, WAIT, Page, nothing, swing, visit
from viewer_page import arm as arm
from viewer_page import viewer as viewer

# Python's side ----------------------------------------------------------------------------------------


def test_the_latest_configuration_wins(viewer: Viewer) -> None:
    async def watch(page: Page) -> None:
        for i in range(5000):
            viewer.show([0.0, 0.0, i / 2**16])
        await page.until(lambda: page.latest["frame"]["theta"][2] == 4999 / 2**16)

    visit(viewer, watch)
    assert viewer.theta[2] == 4999 / 2**16


def test_a_page_that_never_reads_holds_up_nobody_and_costs_nothing(viewer: Viewer) -> None:
    host, port = "127.0.0.1", int(viewer.url.split(":")[2].split("/")[0])
    with socket.socket() as mute:
        mute.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        mute.connect((host, port))
        path = "/" + viewer.url.split("/", 3)[3] + "socket"
        mute.sendall(
            f"GET {path} HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        until(lambda: len(viewer._server.clients) == 1)
        (client,) = viewer._server.clients
        frames = 0
        while "frame" not in client._outbox:  # until the system's buffers are full
            assert frames < 50_000
            frames += 1
            viewer.show([0.0, 0.0, frames / 2**18])
            _ = viewer.theta
        for _ in range(1000):
            frames += 1
            viewer.show([0.0, 0.0, frames / 2**18])
            _ = viewer.theta
        assert len(client._outbox) <= 3
        assert visit(viewer, nothing).latest["frame"]["theta"][2] == frames / 2**18
        start = time.monotonic()
        viewer.close()
        assert time.monotonic() - start < 1.0


@pytest.mark.parametrize(
    ("theta", "reason"),
    [
        ([0, 0], r"theta must have shape \(\.\.\., 3\): yaw, pitch, slide; got \(2,\)"),
        ([0, 0, np.nan], "theta must be finite"),
        ([[0, 0, 0]], r"theta must be one configuration, shape \(3,\); got \(1, 3\)"),
        ([0, 0, 1e300], r"at most 1e\+06 in size; got 1e\+300"),
    ],
)
def test_a_bad_configuration_is_refused_at_the_door(arm: Arm, viewer: Viewer, theta: Any, reason: str) -> None:
    for door in (viewer.show, lambda bad: Viewer(arm, bad, open_browser=False)):
        with pytest.raises(InputError, match=reason):
            door(theta)
    assert_array_equal(viewer.theta, THETA)


def test_a_trajectory_plays_in_real_time_and_can_be_paused_and_sought(arm: Arm, viewer: Viewer) -> None:
    motion = swing(arm)

    async def watch(page: Page) -> None:
        viewer.play(motion, speed=0.25)  # slow: however seldom a busy machine shows a frame, some show it under way
        await page.until(lambda: page.latest.get("player", {}).get("duration") == motion.duration)
        await page.until(lambda: page.latest["frame"]["running"] and page.latest["frame"]["time"] > 0.01)
        frame = page.latest["frame"]
        assert_allclose(frame["theta"], motion(frame["time"]), atol=ROUNDING)
        await page.ask(type="pause")
        assert not page.latest["frame"]["running"]
        await page.ask(type="seek", time=1.0)
        assert_allclose(page.latest["frame"]["theta"], motion(1.0), atol=ROUNDING)
        await page.ask(type="seek", time=motion.duration - 0.01)
        await page.ask(type="play")
        await page.until(lambda: not page.latest["frame"]["running"])
        assert page.latest["frame"]["time"] == motion.duration

    visit(viewer, watch)
    assert_allclose(viewer.theta, motion(motion.duration), atol=ROUNDING)


def test_a_looping_trajectory_starts_again(arm: Arm) -> None:
    stage, motion = Stage(arm), swing(arm)
    stage.load(motion, speed=2.0, loop=True, now=100.0)
    stage.advance(100.0 + (motion.duration + 0.5) / 2)
    assert stage.running
    assert_allclose(stage.theta, motion(0.5), atol=1e-12)  # a moment that went through a division by the speed
    stage.show(np.zeros(3))
    assert not stage.running


def test_a_motion_without_length_stops_at_once(arm: Arm) -> None:
    stage = Stage(arm)
    stage.load(plan_joint(arm, [THETA, THETA], limits={"velocity": 1.0, "acceleration": 1.0}), 1.0, True, 0.0)
    stage.advance(1.0)
    assert not stage.running
    assert_allclose(stage.theta, THETA)


def test_a_trajectory_of_another_arm_is_refused(arm: Arm, viewer: Viewer, tmp_path: Path) -> None:
    other = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=["elbow"])
    motion = plan_joint(other, [[0], [1]], limits={"velocity": 1.0, "acceleration": 1.0})
    with pytest.raises(
        InputError, match="the trajectory moves elbow; small has yaw, pitch, slide: plan it for this arm"
    ):
        viewer.play(motion)
    with pytest.raises(InputError, match="plan it for this arm"):
        viewer.save_html(tmp_path / "view.html", motion)
    with pytest.raises(InputError, match="speed must be a positive number; got 0"):
        viewer.play(swing(arm), speed=0)
    assert list(tmp_path.iterdir()) == []


def test_stage_refuses_what_it_does_not_know(arm: Arm) -> None:
    stage = Stage(arm)
    with pytest.raises(UnknownNameError, match="no joint 'elbow' in small"):
        stage.handle(parse('{"type": "joint", "name": "elbow", "value": 0}'), 0.0)
    with pytest.raises(LimitError, match="outside its limits"):
        stage.handle(parse('{"type": "joint", "name": "slide", "value": -1}'), 0.0)


# the stand-alone page ---------------------------------------------------------------------------------


def test_the_stand_alone_page_needs_nothing_from_anywhere(arm: Arm, tmp_path: Path) -> None:
    path = save_html(arm, tmp_path / "view.html", swing(arm))
    text = path.read_text(encoding="utf-8")
    assert re.search(r"""(?:src|href)=["'](?!data:)""", re.sub(r"<script.*?</script>", "", text, flags=re.S)) is None
    assert text.count("<script") == text.count("</script>") == 4
    assert "default-src 'none'" in text
    data = stored(text)
    assert data["samples"]["times"][-1] == swing(arm).duration
    assert len(data["samples"]["theta"]) == len(data["samples"]["times"])
    assert text.index('id="state">{}') < text.index('<script type="module">')


def test_names_cannot_break_out_of_the_stand_alone_page(tmp_path: Path) -> None:
    nasty = "</script><img src=x onerror=alert(1)>"
    arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4), joints=[nasty], name=nasty)
    text = save_html(arm, tmp_path / "view.html").read_text(encoding="utf-8")
    assert "<img" not in text
    assert stored(text)["arm"]["name"] == nasty


def test_a_stand_alone_page_of_the_view_shows_what_the_view_shows(viewer: Viewer, tmp_path: Path) -> None:
    viewer.show([0.3, 0.2, 0.1])
    data = stored(viewer.save_html(tmp_path / "view.html").read_text(encoding="utf-8"))
    assert data["samples"]["theta"] == [[0.3, 0.2, 0.1]]


def test_a_stand_alone_page_is_written_whole_or_not_at_all(arm: Arm, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist; create it first"):
        save_html(arm, tmp_path / "nowhere" / "view.html")
    assert list(tmp_path.iterdir()) == []


def stored(text: str) -> Any:
    match = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, flags=re.S)
    assert match is not None
    return json.loads(match[1])


def until(reached: Callable[[], bool]) -> None:
    end = time.monotonic() + WAIT
    while not reached():
        assert time.monotonic() < end
        time.sleep(0.01)
