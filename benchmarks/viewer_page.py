"""Pages for the benchmark of the view: as a program, and in a headless Chromium if there is one."""

from __future__ import annotations

import json
import statistics
import time
from typing import Any

from tornado.websocket import websocket_connect

from twistarm.support.errors import TwistarmError
from twistarm.viewer.files.screenshot import find_browser

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")

PICTURE = """() => new Promise((next) => requestAnimationFrame(() => requestAnimationFrame(() => {
  twistarm.view.viewer.renderer.getContext().readPixels(0, 0, 1, 1, 6408, 5121, new Uint8Array(4));
  next();
})))"""
"""Until a picture is drawn, by a processor too: a pixel of it is read."""

FOLLOWED = """async (k) => {
  const begin = performance.now();
  const before = twistarm.state.frame;
  %s
  while (twistarm.state.frame === before) await new Promise((next) => setTimeout(next, 0));
  await new Promise((next) => requestAnimationFrame(next));
  return performance.now() - begin;
}"""
"""ms until the picture after the frame that has what was asked for."""

SLIDER = FOLLOWED % "twistarm.panel.act.joint(twistarm.state.hello.arm.joints[1].name, 0.3 + 0.01 * (k % 10));"

DRAG = (
    FOLLOWED
    % """const { target } = twistarm.parts;
  globalThis.held ??= target.tool.position.clone();
  const position = held.clone();
  position.z += 0.002 * (k % 10) - 0.01;
  if (k === 0) target.begin();
  target.move({ position, quaternion: target.tool.quaternion.clone() });"""
)
"""What the gizmo says when the pointer has moved one of its arrows."""

REPEATS = 30


def received(message: str | bytes | None) -> dict[str, Any]:
    """A message of the process; {} for something to draw."""
    if message is None:
        raise RuntimeError("the socket was closed")
    return {} if isinstance(message, bytes) else dict(json.loads(message))


async def open_page(url: str, whole: bool = True) -> tuple[Any, int]:
    """A socket that has received a frame, and the whole scene on request; and the number of its objects."""
    connection = await websocket_connect(url.replace("http", "ws", 1) + "socket")
    objects, left, framed = 0, None, False
    while not framed or (whole and left != 0):
        message = await connection.read_message()
        objects += isinstance(message, bytes)
        told = received(message)
        framed = framed or told.get("type") == "frame"
        left = told["left"] if told.get("type") == "scene" else left
    return connection, objects


def in_chromium(url: str, began: float) -> dict[str, float]:
    """s from `began` until the arm is drawn, with an open browser; ms from a slider and a drag to the picture.

    {} where there is no browser or no playwright.
    """
    try:
        from playwright.sync_api import sync_playwright

        path = find_browser()
    except (ImportError, TwistarmError):
        return {}
    with sync_playwright() as playwright:
        opening = time.perf_counter()
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        opening = time.perf_counter() - opening
        page.goto(url)
        while not page.evaluate("Boolean(globalThis.twistarm?.state.fitted)"):
            time.sleep(0.01)
        page.evaluate(PICTURE)
        live = time.perf_counter() - began - opening
        slider, drag = ([page.evaluate(each, k) for k in range(REPEATS)] for each in (SLIDER, DRAG))
        browser.close()
    return {
        "in Chromium, page live": live,
        "slider to drawn in Chromium": statistics.median(slider),
        "drag to drawn in Chromium": statistics.median(drag),
    }
