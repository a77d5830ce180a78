"""The page: every link where the arm has it, sliders, a second arm beside, and a program's own controls."""

from __future__ import annotations

import io
import runpy
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from scipy.spatial import KDTree

from arms import ARMS, assert_drawn, load
from twistarm import Arm, Scene, arm_from_screws, joints
from twistarm.arm.engine import MOST_JOINTS
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from waiting import after_frames, draw, idle, settled, until

pytestmark = pytest.mark.browser

Shown = Callable[[str], tuple[Any, Viewer]]


def picture(page: Any) -> np.ndarray[Any, Any]:
    """The 3D view's pixels (height, width, 3)."""
    data = page.locator("#pane").screenshot()
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)


@pytest.mark.smoke
@pytest.mark.parametrize("arm", ARMS, indirect=True)
def test_the_page_draws_every_link_where_the_arm_has_it(shown: Shown, arm: Arm) -> None:
    page, viewer = shown(arm.name)
    assert_drawn(page, arm)
    theta = arm.random_theta(np.random.default_rng(1))
    viewer.show(theta)
    until(page, f"twistarm.state.frame.theta[0] === {float(theta[0])!r}")
    assert_drawn(page, arm, theta)
    assert page.title() == f"{arm.name} · twistarm"
    assert page.locator("#status").inner_text() == "live"


@pytest.mark.smoke
@pytest.mark.parametrize("arm", ARMS, indirect=True)
def test_a_slider_moves_the_arm_by_mouse_and_by_keyboard(shown: Shown, arm: Arm) -> None:
    page, viewer = shown(arm.name)
    before = viewer.theta
    for i, name in enumerate(arm.joint_names[:2]):
        slider = page.locator(f'input[data-joint="{name}"]')
        box = slider.bounding_box()
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.5 * box["width"], middle)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.6 * box["width"], middle, steps=4)
        page.mouse.up()
        low, high = (float(slider.get_attribute(end)) for end in ("min", "max"))
        until(page, f"Math.abs(twistarm.state.frame.theta[{i}] - {low + 0.6 * (high - low)}) < {0.05 * (high - low)}")
        held = page.evaluate(f"twistarm.state.frame.theta[{i}]")
        slider.press("ArrowRight")
        until(page, f"twistarm.state.frame.theta[{i}] > {held}")
        assert_drawn(page, arm)
    until(page, "twistarm.panel.held === null")
    assert page.evaluate("twistarm.state.frame.theta") == viewer.theta.tolist()
    assert np.abs(viewer.theta - before)[:2].min() > 0
    assert viewer.theta[2:].tolist() == before[2:].tolist()


def test_what_a_hand_moves_is_shown_before_the_process_answers(page: Any, other: Any, viewer: Viewer, arm: Arm) -> None:
    waiting: list[Any] = []
    quiet = False

    def relay(socket: Any) -> None:
        process = socket.connect_to_server()
        process.on_message(lambda data: waiting.append((socket, data)) if quiet else socket.send(data))

    page.route_web_socket("**/socket", relay)
    for each in (page, other):
        settled(each, viewer.url)
    quiet = True
    page.get_by_role("slider", name="elbow", exact=True).press("Home")
    page.get_by_role("slider", name="finger_left", exact=True).press("End")
    theta = np.where([name == "elbow" for name in arm.joint_names], arm.limits.lower, arm.ready)
    told = [f"{value:.3f} m".replace("-", "−") for value in arm.fk(theta)[:3, 3]]
    assert [page.locator(f"#tool-{axis}").inner_text() for axis in "xyz"] == told
    assert_drawn(page, arm, theta)
    until(other, f"twistarm.state.frame.theta[2] === {theta[2]}")
    assert viewer.commands is not None  # a servo drives: what is asked from now on is refused
    page.get_by_role("slider", name="shoulder", exact=True).press("End")
    assert page.get_by_role("spinbutton", name="shoulder, degrees").input_value() == "90.0"
    quiet = False
    for socket, data in waiting:
        socket.send(data)
    for each in (page, other):
        idle(each)
        until(each, f"twistarm.state.frame.theta[1] === {theta[1]} && twistarm.state.frame.others.finger_left > 0.01")
        assert_drawn(each, arm, theta)
    assert "a servo drives" in page.locator("#error").inner_text()


def test_an_arm_of_too_many_joints_to_solve_for_has_its_sliders(page: Any) -> None:
    n = MOST_JOINTS + 1
    axes = [joints.revolute([i % 2, 1 - i % 2, 0], [0, 0, 0.1 * i]) for i in range(n)]
    arm = arm_from_screws(np.hstack(axes), np.eye(4))
    with Viewer(arm, open_browser=False) as viewer:
        settled(page, viewer.url)
        assert page.get_by_label("Drag tool").is_disabled()
        assert page.get_by_role("spinbutton", name="tool x, metres").is_disabled()
        assert "sliders" in page.locator("#target-hint").inner_text()
        page.get_by_role("slider").first.press("End")
        idle(page)
        assert viewer.theta[0] > 3.0
        assert_drawn(page, arm)


@pytest.mark.smoke
def test_the_view_is_not_blank_and_shows_the_arm(page: Any, arm: Arm, viewer: Viewer) -> None:
    settled(page, viewer.url)
    draw(page)
    full = picture(page)
    assert full.std() > 10
    assert len(np.unique(full.reshape(-1, 3), axis=0)) > 500
    page.evaluate("for (const layer of ['arm', 'screws', 'frames']) twistarm.view.setVisible(layer, false)")
    after_frames(page)
    changed = (np.abs(full - picture(page)).max(axis=-1) > 8).mean()
    assert 0.02 < changed < 0.6  # the arm takes a good part of the view, and leaves the ground in sight


def test_pages_share_the_arm_and_each_has_its_own_layers(page: Any, other: Any, viewer: Viewer, arm: Arm) -> None:
    settled(page, viewer.url)
    settled(other, viewer.url)
    page.get_by_role("button", name="zero").click()
    until(other, "twistarm.state.frame.theta.every((value) => value === 0)")
    shown = "['screws', 'frames', 'collision'].map((each) => twistarm.view.node(`/${each}`).visible)"
    other.get_by_label("Screws", exact=True).uncheck()
    other.get_by_label("Collision", exact=True).check()
    other.get_by_role("tab", name="Theory").click()
    other.locator("#theory-layers").get_by_label("Linear ellipsoid").check()
    until(other, "twistarm.parts.theory.linear.group.visible")
    assert other.locator("#legend").is_hidden()
    viewer.show_frames(False)  # a program switches them on all pages
    for each in (page, other):
        until(each, "!twistarm.view.node('/frames').visible && twistarm.view.node('/arm').visible")
        assert not each.get_by_label("Frames").is_checked()
    assert page.evaluate(shown) == [True, False, False]
    assert not page.evaluate("twistarm.parts.theory.linear.group.visible")
    page.get_by_label("Frames").check()
    assert other.evaluate(shown) == [False, False, True]


def test_the_tool_s_path_is_a_line_along_its_way(shown: Shown, arm: Arm) -> None:
    page, viewer = shown(arm.name)
    motion = plan_joint(arm, [arm.ready, 0.8 * arm.ready], limits={"velocity": 0.5, "acceleration": 1.0})
    assert not page.get_by_label("Path").is_visible()
    viewer.show_path(motion)
    until(page, "twistarm.parts.path.lines.children.length === 1")
    assert page.get_by_label("Path").is_visible()
    vertices, radius = page.evaluate(
        """() => {
          const { geometry } = twistarm.parts.path.lines.children[0];
          return [[...geometry.attributes.position.array], geometry.parameters.radius];
        }"""
    )
    way = arm.fk(motion(np.linspace(0, motion.duration, 2000)))[:, :3, 3]
    off, _ = KDTree(way).query(np.reshape(vertices, (-1, 3)))
    assert_allclose(off, radius, atol=0.1 * radius)
    viewer.show_path(None)
    until(page, "twistarm.parts.path.lines.children.length === 0")


def second(page: Any, arm: Arm) -> tuple[list[float], Any]:
    """Theta of the second arm by its sliders, and where its base is; its links are at its poses."""
    rows = page.get_by_role("region", name="Second arm").get_by_role("slider").all()
    values = {row.get_attribute("data-joint"): float(row.input_value()) for row in rows}
    theta = [values.pop(name) for name in arm.joint_names]
    poses = arm.poses(theta, values)
    links = [name for name in poses if arm.description and name in arm.description.links]
    paths = ["/beside", *(f"/beside/arm/link:{name}" for name in links)]
    drawn = page.evaluate("(paths) => paths.map((path) => twistarm.view.drawn(path))", paths)
    root, *each = (np.reshape(columns, (4, 4)).T for columns in drawn)
    for name, g in zip(links, each, strict=True):
        assert_allclose(g, root @ poses[name], atol=1e-9, err_msg=name)
    return theta, root


@pytest.mark.smoke
def test_a_second_arm_follows_by_name_or_has_its_own_joints(page: Any) -> None:
    arm, other = load("rover_arm"), load("rover_arm_6dof")
    with Viewer(arm, open_browser=False, beside=other) as viewer:
        settled(page, viewer.url)
        theta = arm.ready + [0.1, 0.2, -0.1, 0.3, 0.4]
        viewer.show(theta)
        until(page, f"twistarm.state.frame.theta[0] === {theta[0]}")
        shared = set(arm.joint_names) & set(other.joint_names)
        assert shared
        x, base = second(page, other)
        expected = other.ready.copy()
        for name, value in zip(arm.joint_names, theta, strict=True):
            if name in other.joint_names:
                i = other.joint_names.index(name)
                expected[i] = np.clip(value, other.limits.lower[i], other.limits.upper[i])
        assert_allclose(x, expected, atol=1e-12)
        assert_allclose(base, np.eye(4))
        ghost = "twistarm.view.node('/beside').getObjectByProperty('isMesh', true).material.opacity"
        assert page.evaluate(ghost) < 0.5

        page.get_by_label("Side by side").check()
        assert page.evaluate(ghost) == 1
        assert second(page, other)[1][1, 3] > 0.3

        page.get_by_label("Follow the first").uncheck()
        i = next(i for i, name in enumerate(other.joint_names) if name in shared and np.isfinite(other.limits.lower[i]))
        moved = other.joint_names[i]
        row = page.get_by_role("region", name="Second arm").get_by_role("slider", name=moved, exact=True)
        row.focus()
        page.keyboard.press("Home")
        assert second(page, other)[0][i] == pytest.approx(other.limits.lower[i])
        assert viewer.theta == pytest.approx(theta, abs=1e-12), "the first stays"
        viewer.show(arm.ready)
        until(page, f"twistarm.state.frame.theta[0] === {arm.ready[0]}")
        assert second(page, other)[0][i] == pytest.approx(other.limits.lower[i])


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


def test_the_pictures_of_readme_and_docs_show_controls_that_the_page_has(page: Any, arm: Arm) -> None:
    """Where it fails, `make pictures` draws them anew."""
    docs = Path(__file__).parents[2] / "docs"
    pictures = runpy.run_path(str(docs / "draw_pictures.py"))
    scene = Scene(arm)
    scene.add_box("table", (0.4, 1.0, 0.04), (0.8, 0.0, 0.35))
    with Viewer(arm, scene=scene, open_browser=False) as viewer:
        settled(page, viewer.url)
        page.click("#tab-program")
        page.click("#record")
        page.get_by_role("button", name="Delete pose 1").wait_for()
        page.click("#tab-scene")
        page.get_by_role("button", name="Remove table").wait_for()
        there = pictures["controls"](page)
        page.goto("about:blank")
    for name in ("view.png", "pictures/theory.png", "pictures/free_move.png", "pictures/in_the_table.png"):
        drawn = pictures["controls_in"](docs / name)
        assert len(drawn) > 20, name
        assert drawn <= there, name
