"""What goes wrong around the page, and messages of two lines with the rest in one fold."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import Arm, ArmBuilder, load_arm
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from twistarm.viewer.server.watching import load_with_files
from waiting import settled, until

pytestmark = pytest.mark.browser

TOOL = np.array([[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 0.4], [0, 0, 0, 1.0]])


def small() -> Arm:
    builder = ArmBuilder("small").revolute("a", [0, 0, 1], [0, 0, 0], lower=-2.0, upper=2.0)
    return (
        builder.revolute("b", [0, 1, 0], [0, 0, 0.4], lower=-2.0, upper=2.0)
        .revolute("c", [0, 1, 0], [0.25, 0, 0.4], lower=-2.0, upper=2.0)
        .tool(TOOL)
        .build()
    )


@pytest.fixture(scope="module")
def arm() -> Arm:
    return small()


@pytest.fixture(scope="module")
def viewer(arm: Arm, browser: Any) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served


@pytest.fixture
def page(opened: Any) -> Any:
    opened.set_viewport_size({"width": 1280, "height": 720})
    opened.get_by_role("tab", name="Move").click()
    return opened


def said(page: Any) -> str:
    return str(page.locator("#error").inner_text())


def write(page: Any, label: str, text: str) -> None:
    box = page.get_by_label(label, exact=True)
    box.fill(text)
    box.press("Enter")


@pytest.mark.smoke
def test_after_a_refusal_the_page_goes_on(page: Any) -> None:
    write(page, "a, degrees", "1e9")
    until(page, "!document.getElementById('error').hidden")
    before = page.evaluate("twistarm.state.frame.theta")
    page.get_by_role("button", name="random").click()
    until(page, f"String(twistarm.state.frame.theta) !== '{','.join(map(str, before))}'")
    assert page.locator("#error").is_hidden()


def test_requests_that_add_up_do_not_replace_one_another(page: Any, viewer: Viewer) -> None:
    page.evaluate(
        """() => {
          const { act } = twistarm.panel;
          act.joint("a", 0.1); act.joint("a", 0.2); act.joint("b", 0.3); act.joint("a", 0.4);
          for (let k = 0; k < 3; k += 1) document.getElementById("record").click();
        }"""
    )
    until(page, "document.querySelectorAll('#pose-list li').length === 3")
    assert viewer.theta[:2].tolist() == [0.4, 0.3]


def test_a_hand_on_the_scrubber_is_not_pulled_along(page: Any, viewer: Viewer, arm: Arm) -> None:
    motion = plan_joint(arm, [np.zeros(3), 0.5 * np.ones(3)], limits={"velocity": 0.1, "acceleration": 1.0})
    for speed in (0.7, 0.3):
        viewer.play(motion, speed=speed)
        until(page, f"document.getElementById('speed').value === '{speed}'")
    assert page.locator("#speed option").count() == 7
    until(page, "twistarm.state.frame.running")
    box = page.locator("#scrub").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    held = page.locator("#scrub").input_value()
    until(page, "twistarm.link.underway === 0")
    viewer.play(motion, speed=0.3)  # from the start, as another page may ask for
    until(page, "twistarm.state.frame.time > 0.05 && twistarm.state.frame.time < 1")
    assert page.locator("#scrub").input_value() == held
    page.mouse.up()
    share = "twistarm.state.frame.time / twistarm.parts.player.duration"
    until(page, f"Math.abs(document.getElementById('scrub').value - {share}) < 0.01")
    viewer.show(np.zeros(3))


def test_a_process_that_has_gone_is_told_and_one_started_anew(browser: Any, arm: Arm) -> None:
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    with Viewer(arm, open_browser=False) as first:
        settled(page, first.url)
        port = int(first.url.split(":")[2].split("/")[0])
    until(page, "document.getElementById('status').textContent === 'offline'")
    slider = page.locator('input[data-joint="a"]')
    stands = slider.input_value()
    assert "does not answer" in said(page)
    slider.evaluate("(slider) => slider.focus()")
    page.keyboard.press("End")
    assert slider.input_value() == stands
    assert page.locator("#move").evaluate("(panel) => panel.inert")
    screws = page.get_by_label("Screws", exact=True)
    drawn = screws.is_checked()
    screws.click()
    assert screws.is_checked() != drawn
    assert page.evaluate("twistarm.link.pending.size") == 0
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda opened: asked.append(opened.url))
    with Viewer(arm, open_browser=False, port=port):
        until(page, "!document.getElementById('error').hidden && twistarm.link.socket.readyState === WebSocket.CLOSED")
        until(page, "document.getElementById('error').textContent.includes('Open the address that it printed')")
        tried = len(asked)
        page.wait_for_timeout(2500)  # longer than the page waits before it tries a silent process again
        assert len(asked) == tried
    page.close()
    assert errors == []


def test_a_changed_file_is_drawn_anew_and_a_broken_one_reported(browser: Any, arm: Arm, tmp_path: Path) -> None:
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    file = tmp_path / "small.urdf"
    file.write_text(arm.description.text)
    load = partial(load_arm, file)
    first, files = load_with_files(load)
    shown = "document.getElementById('notice')"
    with Viewer(first, [0.1, 0.2, 0.3], open_browser=False) as viewer:
        viewer.watch(load, files)
        settled(page, viewer.url)
        page.evaluate("twistarm.view.viewer.camera.position.x += 0.3, twistarm.view.viewer.controls.update()")
        look = (
            "[twistarm.view.viewer.camera.position, twistarm.view.viewer.camera.quaternion].map((it) => it.toArray())"
        )
        seen = page.evaluate(look)
        file.write_text(arm.description.text.replace("</robot>", ""))
        until(page, f"!{shown}.hidden && {shown}.textContent.includes('small.urdf')")
        assert page.locator("#notice").get_attribute("class") == "wrong"
        assert "not loaded again" in page.locator("#notice").inner_text()
        page.locator('input[data-joint="a"]').press("ArrowRight")  # the last one that could be loaded lives
        until(page, "twistarm.state.frame.theta[0] !== 0.1")
        viewer.show([0.1, 0.2, 0.3])
        file.write_text(arm.description.text.replace('"c"', '"elbow"'))
        until(page, f"{shown}.textContent.endsWith('loaded again') && !{shown}.classList.contains('wrong')")
        until(page, "twistarm.state.frame?.theta.length === 3 && twistarm.panel.names[2] === 'elbow'")
        assert page.evaluate("twistarm.state.frame.theta.slice(0, 2)") == [0.1, 0.2]
        for now, before in zip(page.evaluate(look), seen, strict=True):
            assert_allclose(now, before, atol=1e-12)
        page.locator('input[data-joint="elbow"]').press("Home")
        until(page, "twistarm.state.frame.theta[2] === -2")
    page.close()
    assert errors == []
