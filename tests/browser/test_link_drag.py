"""Links taken hold of with the mouse: what a drag does to the arm, and what a click selects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from test_target import PROJECT
from twistarm import Arm
from twistarm.viewer import Viewer
from waiting import after_frames, until

pytestmark = pytest.mark.browser

UNDER = """([clientX, clientY]) => {
  const found = twistarm.parts.linkNames.at({ clientX, clientY });
  return twistarm.view.viewer.scene.worldToLocal(found.point).toArray();
}"""
"""The point of the arm under the pointer, in base axes."""

NAME = "([clientX, clientY]) => twistarm.parts.linkNames.at({ clientX, clientY }).words"

CAMERA = "twistarm.view.viewer.camera.position.toArray()"


@pytest.fixture
def desk(shown: Callable[[str], tuple[Any, Viewer]]) -> Callable[[str], tuple[Any, Viewer]]:
    """The page of an arm at its ready configuration, without the tool's handles, seen as at first."""

    def at_rest(name: str) -> tuple[Any, Viewer]:
        page, viewer = shown(name)
        viewer.show(viewer.arm.ready)
        page.get_by_label("Drag tool").uncheck()
        page.mouse.move(330, 700)
        until(page, f"twistarm.state.frame.theta.every((value, i) => value === {viewer.arm.ready.tolist()}[i])")
        page.evaluate("twistarm.view.fit()")
        after_frames(page)
        return page, viewer

    return at_rest


class Held:
    """A link at the ready configuration, and the point of it that is seen where its joint and the next are in line."""

    def __init__(self, page: Any, arm: Arm, link: str, following: str, joint: str) -> None:
        self.page, self.arm, self.link, self.i = page, arm, link, arm.joint_names.index(joint)
        poses = arm.poses(arm.ready)
        self.aim = self.screen((poses[link][:3, 3] + poses[following][:3, 3]) / 2)
        self.point = page.evaluate(UNDER, self.aim)

    def screen(self, point: Any) -> list[float]:
        x, y, _ = self.page.evaluate(PROJECT, [np.asarray(point).tolist()])
        return [x, y]

    def moved(self, by: float) -> Any:
        """Where on the screen the joint carries the point, by rad or m from the ready configuration."""
        theta = self.arm.ready + by * np.eye(self.arm.n)[self.i]
        before, after = self.arm.poses(self.arm.ready)[self.link], self.arm.poses(theta)[self.link]
        return self.screen((after @ np.linalg.solve(before, [*self.point, 1.0]))[:3])

    def drag(self, *amounts: float) -> None:
        """Take hold of it, and carry it past what each amount of the joint is on the screen."""
        self.page.mouse.move(*self.aim)
        self.page.mouse.down()
        for by in amounts:
            self.page.mouse.move(*self.moved(by))

    def drop(self) -> None:
        self.page.mouse.up()
        until(self.page, "twistarm.link.underway === 0 && twistarm.panel.held === null")


UR5 = ("ur5", "forearm_link", "wrist_1_link", "elbow_joint")


@pytest.mark.parametrize(
    ("name", "link", "following", "joint", "by"),
    [
        pytest.param("rover_arm", "forearm", "wrist", "elbow", -0.4, marks=pytest.mark.smoke),
        ("rover_arm", "carriage", "upper_arm", "slide", 0.08),
        (*UR5, -0.4),
    ],
)
def test_a_dragged_link_follows_the_pointer_by_its_joint_alone(
    desk: Callable[[str], tuple[Any, Viewer]], name: str, link: str, following: str, joint: str, by: float
) -> None:
    page, viewer = desk(name)
    held = Held(page, viewer.arm, link, following, joint)
    page.mouse.move(*held.aim)
    until(page, "!document.getElementById('link-name').hidden")
    assert page.locator("#link-name").inner_text() == f"{link} · {joint}"
    camera = page.evaluate(CAMERA)
    held.drag(0.3 * by, 0.7 * by, by)
    held.drop()
    assert_allclose(viewer.theta - viewer.arm.ready, by * np.eye(viewer.arm.n)[held.i], atol=2e-3)
    assert page.evaluate(CAMERA) == camera


def test_a_drag_ends_at_the_limit_and_escape_takes_it_back(desk: Callable[[str], tuple[Any, Viewer]]) -> None:
    page, viewer = desk("ur5")
    held = Held(page, viewer.arm, *UR5[1:])
    held.drag(*np.arange(0.3, 4.0, 0.3))  # beyond half a turn, and 2.3 rad beyond the limit
    until(page, f"twistarm.state.frame.theta[2] === {viewer.arm.limits.upper[2]}")
    page.keyboard.press("Escape")
    held.drop()
    assert_allclose(viewer.theta, viewer.arm.ready, atol=1e-12)


def test_a_click_selects_the_joint_and_the_base_and_the_background_turn_the_view(
    desk: Callable[[str], tuple[Any, Viewer]],
) -> None:
    page, viewer = desk("ur5")
    held = Held(page, viewer.arm, *UR5[1:])
    page.mouse.click(*held.aim)
    row = page.locator('.joint[aria-current="true"]')
    assert row.get_attribute("aria-label") == "elbow_joint"
    assert page.evaluate("twistarm.highlight.node === twistarm.view.node('/screws/screw:2')")
    page.keyboard.press("Escape")
    assert row.count() == 0
    page.get_by_role("tab", name="Theory").click()
    until(page, "twistarm.parts.theory.numbers !== null")
    page.mouse.click(*held.aim)
    shown = page.get_by_role("table", name="Spatial").locator(".chosen").all_inner_texts()
    J = viewer.arm.spatial_jacobian(viewer.arm.ready)
    assert_allclose([float(text.replace("−", "-")) for text in shown], J[:, 2], atol=6e-4)
    page.get_by_role("tab", name="Move").click()
    base = held.screen([0.05, -0.05, 0.015])
    assert page.evaluate(NAME, base) == "base_link"  # no joint
    for start in (base, [400.0, 650.0]):
        before = page.evaluate(CAMERA)
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(start[0] + 30, start[1])
        page.mouse.up()
        assert not np.allclose(page.evaluate(CAMERA), before)
    assert_allclose(viewer.theta, viewer.arm.ready)
