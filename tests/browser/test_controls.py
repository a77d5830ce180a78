"""A program's own controls and drawings on the page."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = pytest.mark.browser


@pytest.mark.smoke
def test_a_slider_a_button_a_text_and_a_box(page: Any, viewer: Viewer) -> None:
    settled(page, viewer.url)
    assert page.locator("#controls").is_hidden()
    values: list[float] = []
    text = viewer.text("last", "nothing")
    slider = viewer.slider(
        "weight", 0.0, 10.0, lambda value: (values.append(value), setattr(text, "value", f"{value:g}"))
    )
    viewer.button("Fail", lambda: 1 / 0)
    until(page, "document.getElementById('controls').hidden === false")
    box = page.get_by_role("slider", name="weight", exact=True).bounding_box()
    y = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 9, y)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, y, steps=5)
    page.mouse.up()
    end = time.monotonic() + 10.0
    while not (values and values[-1] == slider.value and 4.5 < slider.value < 5.5) and time.monotonic() < end:
        page.wait_for_timeout(20)
    assert 4.5 < values[-1] < 5.5
    until(page, f"document.getElementById('controls').textContent.includes('{values[-1]:g}')")
    slider.value = 8.0
    until(page, "document.querySelector('#controls input[type=range]').valueAsNumber === 8")
    page.get_by_role("spinbutton", name="weight").fill("2.5")
    page.keyboard.press("Enter")
    until(page, "document.getElementById('controls').textContent.includes('last 2.5')")
    assert values[-1] == 2.5
    page.get_by_role("button", name="Fail").click()
    until(page, "document.getElementById('controls').textContent.includes('ZeroDivisionError')")
    until(page, "twistarm.link.underway === 0")

    count = "traverse(({ isMesh }) => { n += isMesh ? 1 : 0; })"
    parts = f"(() => {{ let n = 0; twistarm.view.node('/drawn').{count}; return n; }})()"
    viewer.draw.box("crate", [0.1, 0.2, 0.3])
    until(page, f"{parts} === 1")
    viewer.draw.box("crate", [0.3, 0.2, 0.3])
    until(page, f"{parts} === 1 && twistarm.view.node('/drawn/name:crate/<object>').geometry.parameters.width === 0.3")
    viewer.draw.text("crate", "a crate", [0, 0, 0.3])
    until(page, f"{parts} === 0 && document.getElementById('drawn-text').textContent === 'a crate'")
    viewer.draw.points("none", np.empty((0, 3)))
    viewer.draw.line("one", [[1, 1, 1]])
    viewer.draw.remove("crate")
    until(page, "document.getElementById('drawn-text').textContent === ''")
    page.get_by_role("button", name="Fit view").click()
    assert all(map(np.isfinite, page.evaluate("twistarm.view.viewer.camera.position.toArray()")))
