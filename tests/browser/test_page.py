from __future__ import annotations

import functools
import io
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from scipy.spatial import KDTree

from twistarm import Arm, arm_from_screws, available_arms, joints, load_arm
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer import Viewer, save_html
from waiting import after_frames, draw, settled, until

pytestmark = pytest.mark.browser

DRAWN = 1e-12
"""Meshcat takes a matrix apart into position, quaternion and scale: a few roundings in double precision."""

SAMPLED = 2e-4
"""Between samples 1/30 s apart a motion of some rad/s is followed by a chord [m, and in the rotation matrix]."""

MEMBERS = (
    "scene scene_tree camera controls renderer set_camera set_3d_pane_size set_transform set_property set_dirty "
    "needs_render delete_path handle_command_bytearray capture_image"
)
"""What the page uses of Meshcat's viewer, private or not."""

ARMS = ("rover_arm", pytest.param("rover_arm_6dof", marks=pytest.mark.slow), "panda")


Opened = Callable[[], AbstractContextManager[Any]]

Shown = Callable[[str], tuple[Any, Viewer]]


@pytest.fixture(params=["rover_arm"])
def arm(request: pytest.FixtureRequest) -> Arm:
    if request.param == "panda" and "panda" not in available_arms():
        pytest.skip("example-robot-data is not installed")
    return load(request.param)


@functools.cache
def load(name: str) -> Arm:
    return load_arm(name)


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served


@pytest.fixture(scope="module")
def shown(open_page: Opened) -> Iterator[Shown]:
    """A page for each arm and its viewer, for tests that do no more than move the arm: opening one takes seconds."""
    with ExitStack() as stack:

        @functools.cache
        def of(name: str) -> tuple[Any, Viewer]:
            viewer = stack.enter_context(Viewer(load(name), open_browser=False))
            return settled(stack.enter_context(open_page()), viewer.url), viewer

        yield of


def assert_drawn(page: Any, arm: Arm, theta: Any = None, tol: float = DRAWN) -> None:
    """Every link's node, and the tool's frame, stand in the scene where arm.poses has them at what the page shows."""
    # One evaluation: a frame that arrives between two would make them tell of different moments.
    shown, links, drawn = page.evaluate(
        """() => {
          const links = twistarm.state.hello?.links ?? twistarm.data.links;
          const nodes = [...Object.values(links), "/frames/tool"];
          return [twistarm.state.frame, links, nodes.map((path) => twistarm.view.drawn(path))];
        }"""
    )
    poses = arm.poses(shown["theta"] if theta is None else theta, shown["others"])
    assert set(links) == set(arm.description.links if arm.description else ())
    for name, columns in zip([*links, arm.tip], drawn, strict=True):
        assert_allclose(np.array(columns).reshape(4, 4).T, poses[name], atol=tol, err_msg=name)


def picture(page: Any) -> np.ndarray[Any, Any]:
    """The 3D view's pixels (height, width, 3)."""
    data = page.locator("#pane").screenshot()
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)


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


def test_a_trajectory_plays_pauses_and_scrubs(page: Any, viewer: Viewer, arm: Arm) -> None:
    motion = plan_joint(arm, [arm.ready, 0.8 * arm.ready, arm.ready], limits={"velocity": 0.5, "acceleration": 1.0})
    settled(page, viewer.url)
    assert page.locator("#player").is_hidden()
    viewer.play(motion, loop=True)
    until(page, "twistarm.state.frame.running && twistarm.state.frame.time > 0.1")
    page.get_by_role("button", name="Pause").click()
    until(page, "!twistarm.state.frame.running")
    shown = page.evaluate("twistarm.state.frame")
    assert_allclose(shown["theta"], motion(shown["time"]), atol=DRAWN)
    assert_drawn(page, arm)
    page.get_by_label("Time").press("End")
    until(page, f"twistarm.state.frame.time === {motion.duration!r}")
    page.get_by_role("button", name="Play").click()
    until(page, f"twistarm.state.frame.running && twistarm.state.frame.time < {motion.duration / 2}")


def test_buttons_switches_and_a_second_page(page: Any, other: Any, viewer: Viewer, arm: Arm) -> None:
    settled(page, viewer.url)
    settled(other, viewer.url)
    page.get_by_role("button", name="zero").click()
    until(other, "twistarm.state.frame.theta.every((value) => value === 0)")
    other.get_by_label("Screws", exact=True).uncheck()
    until(page, "!twistarm.view.node('/screws').visible")
    assert page.locator("#legend").is_hidden()
    viewer.show_frames(False)
    until(page, "!twistarm.view.node('/frames').visible && twistarm.view.node('/arm').visible")
    assert not page.get_by_label("Frames").is_checked()
    page.locator('input[data-joint="finger_left"]').press("End")
    until(other, "twistarm.state.frame.others.finger_left > 0.01")
    assert_drawn(other, arm)


def test_the_tool_and_the_joints_are_written_out(shown: Shown, arm: Arm) -> None:
    page, viewer = shown(arm.name)
    viewer.show([0.25, 0.1, 0.2, 0.3, np.pi / 2])
    until(page, "twistarm.state.frame.theta[0] === 0.25")
    row = page.locator(".joint", has=page.locator('input[data-joint="slide"]'))
    assert row.get_by_role("spinbutton", name="slide, metres").input_value() == "0.250"
    row = page.locator(".joint", has=page.locator('input[data-joint="wrist_roll"]'))
    assert row.get_by_role("spinbutton", name="wrist_roll, degrees").input_value() == "90.0"
    x = arm.fk([0.25, 0.1, 0.2, 0.3, np.pi / 2])[0, 3]
    assert page.locator("#tool-x").inner_text() == f"{x:.3f} m".replace("-", "−")


def test_the_panel_of_seven_joints_needs_no_scrolling(page: Any) -> None:
    screws = np.hstack([joints.revolute([0, 1, 0], [0.1 * i, 0, 0]) for i in range(7)])
    name = "<b>a_rather_long_name_of_a_joint_of_an_arm</b>"
    arm = arm_from_screws(screws, np.eye(4), joints=[name, *(f"joint{i}" for i in range(6))])
    with Viewer(arm, open_browser=False) as viewer:
        settled(page, viewer.url)
        assert page.evaluate("panel.scrollHeight <= panel.clientHeight && panel.scrollWidth <= panel.clientWidth")
        assert page.locator(".joint .name").first.get_attribute("title") == name
        page.evaluate("twistarm.panel.act.joint('nobody', 0)")
        until(page, "!document.getElementById('error').hidden")
        assert "no joint 'nobody' in arm" in page.locator("#error").inner_text()
    until(page, "document.getElementById('status').textContent === 'offline'")


def test_what_the_page_uses_of_meshcat_is_there(page: Any) -> None:
    arm = arm_from_screws(joints.revolute([0, 0, 1], [0, 0, 0]), np.eye(4))
    with Viewer(arm, open_browser=False) as viewer:
        settled(page, viewer.url)
        missing = page.evaluate("names => names.filter((name) => !(name in twistarm.view.viewer))", MEMBERS.split())
        assert missing == []
        assert page.evaluate("MeshCat.THREE.REVISION") == "132"
        assert page.evaluate("twistarm.view.drawn('/frames/tool')") == np.eye(4).ravel().tolist()


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


@pytest.mark.slow
def test_a_stand_alone_page_plays_from_disk_without_a_network(page: Any, arm: Arm, tmp_path: Path) -> None:
    motion = plan_joint(arm, [arm.ready, 0.8 * arm.ready], limits={"velocity": 0.5, "acceleration": 1.0})
    path = save_html(arm, tmp_path / "view.html", motion)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.context.set_offline(True)
    page.goto(path.as_uri())
    until(page, "globalThis.twistarm?.state.frame?.time > 0.1")
    page.get_by_label("Time").press("ArrowLeft")
    assert page.evaluate("twistarm.state.frame.running") is False
    shown = page.evaluate("twistarm.state.frame.time")
    assert_drawn(page, arm, motion(shown), tol=SAMPLED)
    page.get_by_role("button", name="Play").click()
    until(page, f"twistarm.state.frame.time === {motion.duration!r} && !twistarm.state.frame.running")
    assert_drawn(page, arm, motion(motion.duration), tol=1e-5)
    page.get_by_label("Screws", exact=True).uncheck()
    assert page.evaluate("twistarm.view.node('/screws').visible") is False
    page.get_by_label("Path", exact=True).uncheck()
    assert page.evaluate("twistarm.view.node('/path').visible") is False
    draw(page)
    assert picture(page).std() > 10
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []
