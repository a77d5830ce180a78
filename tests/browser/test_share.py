"""What is handed on: the stand-alone page, opened from disk, pictures, films, and the view in a notebook."""

from __future__ import annotations

import base64
import io
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from PIL import Image

from arms import assert_drawn, load
from twistarm import Arm, Trajectory, load_arm, plan_joint, save_html
from twistarm.viewer import Viewer
from urdf_text import BRANCHED
from waiting import draw, settled, until

pytestmark = pytest.mark.browser


ROUNDED = 5e-6  # Six decimals of positions and quaternions.
LARGEST_PANDA = 10e6  # Bytes: 0.85 MB are Meshcat's, the rest is triangles.

CARD = """
for (const { prototype } of [WebGLRenderingContext, WebGL2RenderingContext]) {
  const get = prototype.getParameter;
  prototype.getParameter = function (what) {
    return [this.RENDERER, 0x9246].includes(what) ? "a graphics card" : get.call(this, what);
  };
}"""
"""A page that takes software for a graphics card shows all it can; 0x9246 is UNMASKED_RENDERER_WEBGL."""


def motion_of(arm: Arm) -> Trajectory:
    return plan_joint(arm, [arm.ready, 0.8 * arm.ready], limits={"velocity": 0.5, "acceleration": 1.0})


@contextmanager
def watched_requests(page: Any) -> Iterator[None]:
    """Cut the network; nothing may be asked for but the file itself."""
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.context.set_offline(True)
    yield
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def saved(page: Any, folder: Path, press: Callable[[], None]) -> Path:
    with page.expect_download() as download:
        press()
    path = folder / download.value.suggested_filename
    download.value.save_as(path)
    return path


def image(path: Path) -> NDArray[np.int64]:
    return np.asarray(Image.open(path).convert("RGB")).astype(int)


def pink(pixels: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Where screws of revolute joints are drawn, and nothing else."""
    red, green, blue = np.moveaxis(pixels, -1, 0)
    return (red > 180) & (green < 90) & (blue > 100)


def test_the_saved_page_stands_as_it_stood_and_outlasts_a_reload(page: Any, tmp_path: Path) -> None:
    (tmp_path / "branched.urdf").write_text(BRANCHED)
    arm = load_arm(tmp_path / "branched.urdf", base="base_link", tip="tool0")
    look = "(({ position, target, zoom }) => [...position, ...target, zoom])(twistarm.view.remembered())"
    with Viewer(arm, open_browser=False) as viewer:
        settled(page, viewer.url)
        viewer.play(motion_of(arm))
        until(page, "!document.querySelector('#player').hidden && !document.querySelector('#plots').hidden")
        page.evaluate(
            """() => {
              const { camera, controls } = twistarm.view.viewer;
              controls.dispatchEvent({ type: "start" }); // a hand
              camera.position.x += 0.3;
              controls.update();
            }"""
        )
        page.get_by_role("tab", name="Theory").click()
        joint = page.get_by_label("Joint whose screw and columns are drawn")
        until(page, "document.getElementById('theory-joint').length === 3")
        joint.select_option(label="c")
        page.get_by_text("View", exact=True).click()
        page.get_by_label("Radians", exact=True).check()
        stood = page.evaluate(look), joint.input_value()
        page.get_by_text("Share", exact=True).click()
        path = saved(page, tmp_path, page.get_by_role("button", name="Stand-alone page").click)
    with watched_requests(page):
        page.goto(path.as_uri())
        until(page, "document.body.dataset.drawn === ''")
        assert_allclose(page.evaluate(look), stood[0], atol=1e-6)
        assert joint.input_value() == stood[1]
        assert page.get_by_label("Radians", exact=True).is_checked()
        assert page.get_by_role("tabpanel", name="Theory").is_visible()
        page.get_by_role("tab", name="Move").click()
        page.locator('input[data-joint="c"]').press("End")
        page.locator('input[data-joint="turn"]').press("ArrowRight")  # carries the base
        page.get_by_label("a, radians", exact=True).fill("-0.4")
        page.keyboard.press("Enter")
        assert_drawn(page, arm, [-0.4, 0.6])
        page.get_by_label("c, metres").fill("0.7")
        page.keyboard.press("Enter")
        until(page, "!document.getElementById('error').hidden")
        page.get_by_role("tab", name="Poses").click()
        page.get_by_role("button", name="Record", exact=True).click()
        page.get_by_role("button", name="Go to pose 1").wait_for()
        page.reload()
        until(page, "document.body.dataset.drawn === ''")
        assert page.get_by_role("button", name="Go to pose 1").is_visible(), "in the panel that was open"
        assert_drawn(page, arm, [-0.4, 0.6])
        python = ("button", "Plan"), ("button", "Stand-alone page"), ("checkbox", "Collision"), ("checkbox", "Reach")
        for role, name in python:
            control = page.get_by_role(role, name=name, include_hidden=True)
            assert control.is_disabled()
            assert control.get_attribute("title") == "Needs Python: run twistarm view"


def test_a_browser_that_cannot_run_it_is_told_which_can(browser: Any, tmp_path: Path) -> None:
    page = browser.new_page()
    page.add_init_script("delete globalThis.WebAssembly")
    page.goto(save_html(load("rover_arm"), tmp_path / "arm.html").as_uri())
    until(page, "!document.getElementById('error').hidden")
    assert "Firefox 121" in page.get_by_role("alert").inner_text()
    page.close()


def test_the_stand_alone_page_of_an_arm_with_meshes(page: Any, tmp_path: Path) -> None:
    arm = load("panda")
    page.set_viewport_size({"width": 800, "height": 480})
    with Viewer(arm, 0.9 * arm.ready, open_browser=False) as viewer:
        path = viewer.save_html(tmp_path / "arm.html")
    assert path.stat().st_size < LARGEST_PANDA
    with watched_requests(page):
        page.goto(path.as_uri())
        until(page, "document.body.dataset.drawn === ''")
        assert_drawn(page, arm, 0.9 * arm.ready, tol=ROUNDED)
        triangles = "twistarm.view.viewer.renderer.info.render.triangles"
        until(page, f"{triangles} > 10000")


def test_a_picture_has_the_size_asked_for_and_shows_what_is_seen(page: Any, tmp_path: Path) -> None:
    page.add_init_script(CARD)
    with Viewer(load("rover_arm"), open_browser=False) as viewer:
        viewer.show_frames(False)  # a rod of the tool's frame lies on the last screw
        settled(page, viewer.url)
        before = page.evaluate("[twistarm.view.viewer.camera.zoom, twistarm.view.viewer.camera.aspect]")
        draw(page)
        page.evaluate("document.getElementById('cube').hidden = true")
        page.evaluate("twistarm.view.handles.group.visible = false")  # a picture is without them
        draw(page)
        seen = np.asarray(Image.open(io.BytesIO(page.locator("#pane").screenshot())).convert("RGB")).astype(int)
        page.evaluate("twistarm.view.handles.group.visible = true")
        page.get_by_text("Share", exact=True).click()
        button = page.get_by_role("button", name="Picture")
        own = image(saved(page, tmp_path, button.click))
        assert own.shape == seen.shape == (720, 960, 3)
        # Below the switches and the legend both are the same view, up to how edges are smoothed.
        assert (np.abs(own - seen)[60:].max(axis=-1) < 12).mean() > 0.995
        page.get_by_label("Width of the picture").fill("2500")
        page.get_by_label("Height of the picture").fill("300")
        wide = image(saved(page, tmp_path, lambda: page.keyboard.press("Enter")))
        assert wide.shape == (300, 2500, 3)
        (rows, columns), (at_home, across) = np.nonzero(pink(wide)), np.nonzero(pink(own))
        # The same field of view from top to bottom, the arm in the middle: pieces are put together without a shift.
        assert_allclose(np.ptp(rows) / 300, np.ptp(at_home) / 720, atol=0.01)
        assert_allclose((columns.mean() - 1250) / 300, (across.mean() - 480) / 720, atol=0.01)
        assert page.evaluate("[twistarm.view.viewer.camera.zoom, twistarm.view.viewer.camera.aspect]") == before


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """By a server of its own, as a notebook's, under the name localhost."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=folder)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://localhost:{server.server_port}"
        server.shutdown()


def test_a_local_notebook_frames_the_live_page_and_the_static_one(page: Any, tmp_path: Path) -> None:
    arm = load("rover_arm")
    with Viewer(arm, open_browser=False) as viewer, served(tmp_path) as address:
        frames = viewer._repr_html_() + viewer.inline(300, static=True).html
        head = "<!DOCTYPE html><meta charset='utf-8'><link rel='icon' href='data:,'><title>notebook</title>"
        (tmp_path / "notebook.html").write_text(head + frames, "utf-8")
        page.goto(f"{address}/notebook.html")
        live, static = (page.locator("iframe").nth(i).element_handle().content_frame() for i in (0, 1))
        until(live, "globalThis.twistarm?.state.fitted")
        until(static, "document.body?.dataset.drawn === ''")
        assert_drawn(live, arm, arm.ready)
        assert_drawn(static, arm, arm.ready, tol=ROUNDED)
        live.get_by_role("button", name="zero").click()
        until(live, "twistarm.state.frame.theta.every((x) => x === 0)")
        assert_allclose(viewer.theta, 0.0)
        assert static.evaluate("origin") == "null", "it reaches nothing of the notebook"


CANCELLED = """(() => {
  const [film, said] = ["save-film", "share-note"].map((id) => document.getElementById(id));
  return film.textContent === "Cancel" && said.textContent.startsWith("recording: ") && (film.click(), true);
})()"""
"""The film is cancelled at once, for it may soon be done."""

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
    const presented = new Promise((done) => { player.requestVideoFrameCallback(done); setTimeout(done, 3000); });
    player.currentTime = share * player.duration;
    await Promise.all([presented, new Promise((done) => { player.onseeked = done; })]);
    const context = canvas.getContext("2d");
    do { // a busy browser tells of the seek before it has the frame
      await new Promise((done) => { setTimeout(done, 50); });
      context.drawImage(player, 0, 0);
    } while (!context.getImageData(0, 0, 1, 1).data.slice(0, 3).some(Boolean));
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
        said = page.locator("#share-note")
        film.click()
        until(page, CANCELLED)
        until(page, "document.getElementById('share-note').textContent.startsWith('Cancelled')")
        draw(page)
        assert_shows(other, saved(page, tmp_path, film.click).read_bytes(), motion, (192, 108))
        until(page, "document.getElementById('share-note').textContent === 'Saved: rover_arm.webm'")
        assert viewer.theta == pytest.approx(motion(motion.duration), abs=1e-9)
        assert page.evaluate("twistarm.view.viewer.camera.zoom") == camera
        page.evaluate("delete globalThis.VideoEncoder")
        viewer.show(arm.ready)
        until(page, f"twistarm.state.frame.theta[1] === {arm.ready[1]}")
        film.click()
        until(page, "document.getElementById('share-note').classList.contains('wrong')")
        assert "192 × 108 pixels" in said.inner_text()
        assert viewer.theta == pytest.approx(arm.ready, abs=1e-9), "it has not moved for nothing"
