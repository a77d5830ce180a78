"""Pages for the benchmark of the view: as a program, and in a headless Chromium where there is one."""

from __future__ import annotations

import json
import statistics
import time
from typing import Any

from tornado.websocket import websocket_connect

from twistarm.errors import TwistarmError
from twistarm.viewer.browsers import find_browser

FLAGS = ("--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")

DRAWN = """async (k) => {
  const name = twistarm.state.hello.arm.joints[1].name;
  const begin = performance.now();
  const before = twistarm.state.frame;
  twistarm.panel.act.joint(name, 0.3 + 0.01 * (k % 10));
  while (twistarm.state.frame === before) await new Promise((next) => setTimeout(next, 0));
  await new Promise((next) => requestAnimationFrame(next));
  return performance.now() - begin;
}"""
"""ms from a joint's new value to the picture after the frame that has it."""


def received(message: str | bytes | None) -> dict[str, Any]:
    """A message of the process; {} for something to draw."""
    if message is None:
        raise RuntimeError("the socket was closed")
    return {} if isinstance(message, bytes) else dict(json.loads(message))


async def open_page(url: str) -> tuple[Any, int]:
    """A socket that has been told the whole scene and a frame, and how many objects that were."""
    connection = await websocket_connect(url.replace("http", "ws", 1) + "socket")
    objects, left, framed = 0, None, False
    while left is None or left > 0 or not framed:
        message = await connection.read_message()
        objects += isinstance(message, bytes)
        told = received(message)
        framed = framed or told.get("type") == "frame"
        left = told["left"] if told.get("type") == "scene" else left
    return connection, objects


def in_chromium(url: str, began: float) -> dict[str, float]:
    """s from `began` until the arm stands on the page, with a browser that was open; ms from a slider to the picture.

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
        live = time.perf_counter() - began - opening
        times = [page.evaluate(DRAWN, k) for k in range(60)]
        browser.close()
    return {"in Chromium, page live": live, "slider to drawn in Chromium": statistics.median(times)}
