"""Driving from the page alone: the switch, buttons held by mouse and keyboard in each of the axes."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from arms import ARMS
from test_jog import HIDE
from twistarm import Arm
from twistarm.viewer import Viewer
from waiting import until

pytestmark = pytest.mark.browser

WAY = 0.015  # How far a button is held [m]: a few frames.
TURN = 0.06  # [rad]

CAMERA = """() => {
  const { viewer } = twistarm.view;
  viewer.camera.updateMatrixWorld();
  return viewer.camera.matrixWorld.elements;
}"""

# Base axes from Meshcat's world, in which y is up: its scene is turned by −90° about x.
FROM_MESHCAT = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])


class Bench:
    """A page with Drive switched on, and the view behind it; small."""

    def __init__(self, page: Any, viewer: Viewer) -> None:
        self.page, self.viewer, self.arm = page, viewer, viewer.arm
        self.page.get_by_role("tab", name="Jog").click()

    def drive(self, theta: Any) -> Any:
        """The page, with the arm at theta and Drive just switched on."""
        self.viewer.show(theta)
        until(self.page, "!document.getElementById('drive').checked && !document.getElementById('drive').disabled")
        self.page.get_by_role("switch", name="Drive").click()
        until(self.page, "twistarm.jog.accepts && document.getElementById('drive').checked")
        self.page.get_by_role("radio", name="base").click()
        return self.page

    def standing(self) -> NDArray[np.float64]:
        """Where the arm on the page stands once it does, in the process too."""
        until(self.page, "twistarm.jog.timer === null")
        end, looks = time.monotonic() + 10, [np.zeros(0)]
        while len(looks) < 4 or any(not np.array_equal(look, looks[-1]) for look in looks[-4:]):
            assert time.monotonic() < end
            looks += [self.viewer.theta, np.array(self.page.evaluate("twistarm.state.frame.theta"))]
            time.sleep(0.1)
        return looks[-1]

    def held(self, name: str, frame: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Press a button by mouse until the tool has moved enough; theta before and after."""
        before, end = self.standing(), time.monotonic() + 15
        button(self.page, name, frame).hover()
        self.page.mouse.down()
        while True:
            assert time.monotonic() < end
            way, turn = moved(self.arm, before, self.page.evaluate("twistarm.state.frame.theta"))
            if np.linalg.norm(way) > WAY or np.linalg.norm(turn) > TURN:
                break
            time.sleep(0.02)
        self.page.mouse.up()
        return before, self.standing()


Benches = Callable[[str], Bench]


@pytest.fixture(scope="module")
def benches(shown: Callable[..., tuple[Any, Viewer]]) -> Benches:
    return lambda name: Bench(*shown(name, (480, 640)))


def button(page: Any, name: str, frame: str) -> Any:
    return page.get_by_role("button", name=f"{name}, {frame} axes", exact=True)


def moved(arm: Arm, before: Any, after: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far the tool went, and turned (rotation vector of a small angle), in base axes."""
    g, h = arm.poses(before)[arm.tip], arm.poses(after)[arm.tip]
    R = h[:3, :3] @ g[:3, :3].T
    return h[:3, 3] - g[:3, 3], np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2


def axes_of_view(page: Any) -> NDArray[np.float64]:
    """Right, up and towards the viewer as columns, in base axes."""
    columns = np.array(page.evaluate(CAMERA)).reshape(4, 4).T
    view: NDArray[np.float64] = FROM_MESHCAT @ columns[:3, :3]
    return view


def along(actual: Any, expected: Any) -> None:
    assert_allclose(actual / np.linalg.norm(actual), expected, atol=0.02)


@pytest.mark.smoke
@pytest.mark.parametrize("name", ARMS)
def test_a_button_held_by_mouse_moves_the_tool_along_its_axis(benches: Benches, name: str) -> None:
    bench = benches(name)
    arm, page = bench.arm, bench.drive(bench.arm.ready)
    before, after = bench.held("Move −z", "base")
    along(moved(arm, before, after)[0], [0, 0, -1])

    page.get_by_role("radio", name="tool").click()
    before, after = bench.held("Move +x", "tool")
    along(moved(arm, before, after)[0], arm.poses(before)[arm.tip][:3, 0])

    page.get_by_role("radio", name="view").click()
    page.evaluate("() => { twistarm.view.viewer.camera.position.x += 0.4; twistarm.view.viewer.controls.update(); }")
    view = axes_of_view(page)
    before, after = bench.held("Move up", "view")
    along(moved(arm, before, after)[0], view[:, 1])
    if arm.n > 5:  # five joints cannot turn about any axis and keep the tool where it is
        before, after = bench.held("Turn ↺", "view")
        way, turn = moved(arm, before, after)
        along(turn, view[:, 2])
        assert np.linalg.norm(way) < 3e-3


def test_buttons_by_keyboard_and_whatever_ends_a_press(benches: Benches) -> None:
    bench = benches("rover_arm")
    arm, page = bench.arm, bench.drive(bench.arm.ready)
    page.get_by_role("button", name="Faster").click()
    until(page, "document.getElementById('jog-pace').textContent === '0.175 m/s, 40°/s'")

    before = bench.standing()
    button(page, "Move −z", "base").focus()
    page.keyboard.down("Space")
    until(page, f"twistarm.state.frame.tool.position[2] < {arm.poses(before)[arm.tip][2, 3] - WAY}")
    page.keyboard.up("Space")
    along(moved(arm, before, bench.standing())[0], [0, 0, -1])

    before = bench.standing()
    page.get_by_role("button", name="+ wrist_roll", exact=True).focus()
    page.keyboard.down("Enter")
    until(page, f"twistarm.state.frame.theta[4] > {before[4] + TURN}")
    page.keyboard.press("Tab")  # the focus goes on: the key's release would not be seen here
    after = bench.standing()
    page.keyboard.up("Enter")
    assert_allclose(after[:4], before[:4], atol=1e-6)

    button(page, "Move +z", "base").hover()
    for event, end in (
        ("dispatchEvent(new Event('blur'))", "dispatchEvent(new Event('focus'))"),
        (f"({HIDE})(true)", f"({HIDE})(false)"),
    ):
        page.mouse.down()
        until(page, "twistarm.jog.timer !== null")
        page.evaluate(event)
        assert page.evaluate("twistarm.jog.timer") is None
        page.evaluate(end)
        time.sleep(0.1)
        assert page.evaluate("twistarm.jog.timer") is None  # still pressed, and to be pressed anew
        page.mouse.up()


def test_what_happens_where_the_arm_cannot_follow_is_chosen_there(benches: Benches) -> None:
    bench = benches("rover_arm")
    page = bench.drive(bench.arm.ready)
    slide, stop = (page.get_by_role("radio", name=name, exact=True) for name in ("slide along", "stop"))
    page.get_by_text("At limits: slide along").click()
    assert slide.is_checked()
    stop.click()
    until(page, "document.querySelector('#jog-unreachable [value=stop]').checked")
    assert bench.viewer._server.commands.on_unreachable == "stop"
    page.get_by_role("switch", name="Drive").click()
    until(page, "!twistarm.jog.accepts && !document.getElementById('drive').checked")
