from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from scipy.spatial import KDTree

from arms import ARMS, assert_drawn
from twistarm import Arm
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer
from waiting import after_frames, draw, settled, until

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
    settled(other, viewer.url)  # loaded again, it keeps them
    until(other, "twistarm.parts.theory.linear.group.visible")
    assert other.evaluate(shown) == [False, False, True]
    viewer.show_frames(False)
    until(page, "!twistarm.view.node('/frames').visible")
    page.locator('input[data-joint="finger_left"]').press("End")
    until(other, "twistarm.state.frame.others.finger_left > 0.01")
    assert_drawn(other, arm)


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
