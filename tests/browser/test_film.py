"""Films of a motion by the page: a player shows their length and the motion."""

from __future__ import annotations

import base64
import io
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from arms import load
from test_share import saved
from twistarm import Trajectory, plan_joint
from twistarm.viewer import Viewer
from waiting import draw, settled, until

pytestmark = pytest.mark.browser

PLAYED = """async (data) => {
  const film = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const player = document.createElement("video");
  player.src = URL.createObjectURL(new Blob([film], { type: "video/webm" }));
  await new Promise((done, fail) => Object.assign(player, { onloadeddata: done, onerror: () => fail(player.error) }));
  const canvas = document.createElement("canvas");
  const size = { width: player.videoWidth, height: player.videoHeight };
  Object.assign(canvas, size);
  const frames = [];
  for (const share of [0, 0.5, 0.999]) {
    player.currentTime = share * player.duration;
    await new Promise((done) => { player.onseeked = done; });
    canvas.getContext("2d").drawImage(player, 0, 0);
    frames.push(canvas.toDataURL("image/png").split(",")[1]);
  }
  return { ...size, duration: player.duration, frames };
}"""


def assert_shows(player: Any, film: bytes, motion: Trajectory, size: tuple[int, int]) -> None:
    """A player of its own tells the motion's duration, and its frames differ as an arm that moves does."""
    player.goto("about:blank")
    played = player.evaluate(PLAYED, base64.b64encode(film).decode())
    assert (played["width"], played["height"]) == size
    assert played["duration"] == pytest.approx(motion.duration, rel=0.01)
    pictures = [np.asarray(Image.open(io.BytesIO(base64.b64decode(each))).convert("RGB")) for each in played["frames"]]
    for earlier, later in pairwise(pictures):
        moved = (np.abs(earlier.astype(int) - later.astype(int)).max(axis=-1) > 30).mean()
        assert 0.005 < moved < 0.5, "a part of the view, not all of it"


@pytest.mark.smoke
def test_the_page_films_its_motion(page: Any, other: Any, tmp_path: Path) -> None:
    arm = load("rover_arm")
    motion = plan_joint(arm, [arm.ready, arm.ready + 0.1], limits={"velocity": 1.0, "acceleration": 8.0})
    with Viewer(arm, open_browser=False) as viewer:
        page.set_viewport_size({"width": 900, "height": 500})
        settled(page, viewer.url)
        page.get_by_text("Share", exact=True).click()
        film = page.get_by_role("button", name="Video")
        assert film.is_hidden(), "there is no motion"
        viewer.play(motion)
        until(page, "twistarm.state.frame.time > 0")
        page.get_by_label("Width of the picture").fill("192")
        page.get_by_label("Height of the picture").fill("108")
        camera = page.evaluate("twistarm.view.viewer.camera.zoom")
        said = page.locator("#share-said")
        film.click()
        until(page, "document.getElementById('share-said').textContent.startsWith('recording: ')")
        page.get_by_role("button", name="Cancel").click()
        until(page, "document.getElementById('share-said').textContent.startsWith('cancelled')")
        draw(page)
        assert_shows(other, saved(page, tmp_path, film.click).read_bytes(), motion, (192, 108))
        until(page, "document.getElementById('share-said').textContent === 'saved: rover_arm.webm'")
        assert viewer.theta == pytest.approx(motion(motion.duration), abs=1e-9)
        assert page.evaluate("twistarm.view.viewer.camera.zoom") == camera
        page.evaluate("delete globalThis.VideoEncoder")
        viewer.show(arm.ready)
        until(page, f"twistarm.state.frame.theta[1] === {arm.ready[1]}")
        film.click()
        until(page, "document.getElementById('share-said').classList.contains('wrong')")
        assert said.inner_text().startswith("this browser records no WebM of 192 × 108 pixels here")
        assert viewer.theta == pytest.approx(arm.ready, abs=1e-9), "it has not moved for nothing"
