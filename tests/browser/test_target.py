"""The tool dragged by its handles and told where to be, and all configurations of a target."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from arms import ARMS, DRAWN, assert_drawn
from recorded_poses import said
from twistarm import Approach, solve_ik, solve_ik_all
from twistarm.viewer import Viewer
from waiting import after_frames, idle, until

pytestmark = pytest.mark.browser


MET = 3e-6  # The solver's tolerance [m, rad], and its part that every coordinate may have.
ALONG, ABOUT = 92.0, 64.0  # Pixels from the middle of the handles to an arrow's head and to a ring.

PROJECT = """([point]) => {
  const { scene, camera, renderer } = twistarm.view.viewer;
  scene.updateMatrixWorld(true);
  const at = scene.localToWorld(new MeshCat.THREE.Vector3(...point));
  const towards = at.clone().applyMatrix4(camera.matrixWorldInverse);
  at.project(camera);
  const { left, top, width, height } = renderer.domElement.getBoundingClientRect();
  const pixel = (-towards.z * 2 * Math.tan((camera.fov * Math.PI) / 360)) / height;
  return [left + ((1 + at.x) * width) / 2, top + ((1 - at.y) * height) / 2, pixel];
}"""
"""Where a point of the base frame is on the screen [px], and the length of a pixel there [m]."""


class Desk:
    """A page, its viewer, and a hand on the mouse."""

    def __init__(self, page: Any, viewer: Viewer) -> None:
        self.page, self.viewer, self.arm = page, viewer, viewer.arm

    def reset(self, kind: str | None = None, snap: bool = False, theta: Any = None) -> None:
        """Stand at theta or ready, handles at the tool."""
        self.page.mouse.move(330, 500)
        start = np.asarray(self.arm.ready if theta is None else theta)
        self.viewer.show(start)
        until(self.page, f"{start.tolist()}.every((value, i) => value === twistarm.state.frame.theta[i])")
        self.page.get_by_label("Drag tool").set_checked(True)
        self.page.get_by_label("Snap").set_checked(snap)
        if kind is not None:
            self.page.get_by_label("Kind of target").select_option(kind)
        after_frames(self.page)

    def drawn(self) -> Any:
        """The tool's frame (4, 4) as it stands on the page."""
        return np.array(self.page.evaluate("twistarm.view.drawn('/frames/tool')")).reshape(4, 4).T

    def screen(self, point: Any) -> Any:
        """Where a point of the base frame is on the screen, and a pixel there in m."""
        return np.array(self.page.evaluate(PROJECT, [np.asarray(point).tolist()]))

    def handle(self, pixels: Any) -> Any:
        """The point of the handles so many pixels from their middle, along base axes."""
        p = self.drawn()[:3, 3]
        return p + self.screen(p)[2] * np.asarray(pixels)

    def drag(self, start: Any, end: Any, steps: int = 3, keep: bool = False) -> None:
        """With the mouse from one point of the base frame to another, past points between."""
        (x0, y0, _), (x1, y1, _) = self.screen(start), self.screen(end)
        self.page.mouse.move(x0, y0)
        self.page.mouse.down()
        for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
            self.page.mouse.move(x0 + share * (x1 - x0), y0 + share * (y1 - y0))
        if not keep:
            self.page.mouse.up()

    def answered(self) -> dict[str, Any]:
        """What every page is told of the target, once nothing more of it is to come."""
        idle(self.page)
        told = self.viewer._server.ask(lambda stage: said(stage, "target"))
        assert told["converged"] is not None
        return {**told["given"], "converged": told["converged"]}


@pytest.fixture(scope="module")
def desks(shown: Callable[..., tuple[Any, Viewer]]) -> Callable[[str], Desk]:
    return lambda name: Desk(*shown(name, (740, 560)))


@pytest.fixture
def rover(desks: Callable[[str], Desk]) -> Desk:
    return desks("rover_arm")


@pytest.fixture(params=ARMS)
def desk(request: pytest.FixtureRequest, desks: Callable[[str], Desk]) -> Desk:
    return desks(request.param)


@pytest.mark.smoke
def test_an_arrow_moves_the_tool_along_x_and_keeps_the_rest(desk: Desk) -> None:
    desk.reset()
    before, camera = desk.drawn(), desk.page.evaluate("twistarm.view.viewer.camera.position.toArray()")
    assert_allclose(before, desk.arm.fk(desk.arm.ready), atol=DRAWN)
    by = 0.06 if before[0, 3] < 0.5 else -0.06
    tip = desk.handle([ALONG, 0, 0])
    desk.drag(tip, tip + [by, 0, 0])
    given = desk.answered()
    assert given["converged"]
    assert given["kind"] == ("approach" if desk.arm.n == 5 else "pose")
    assert_drawn(desk.page, desk.arm)
    after = desk.drawn()
    assert_allclose(after, desk.arm.fk(desk.viewer.theta), atol=DRAWN)
    assert after[0, 3] - before[0, 3] == pytest.approx(by, abs=desk.screen(tip)[2])
    assert_allclose(after[1:3, 3], before[1:3, 3], atol=MET)
    kept = slice(2, 3) if desk.arm.n == 5 else slice(0, 3)
    assert_allclose(after[:3, kept], before[:3, kept], atol=MET)
    assert desk.page.evaluate("twistarm.view.viewer.camera.position.toArray()") == pytest.approx(camera, abs=1e-9)
    assert "✓" in desk.page.locator("#target-words").inner_text()


def test_a_ring_turns_the_tool_where_it_is(desk: Desk) -> None:
    desk.reset()
    before = desk.drawn()
    i = 1 if desk.arm.n == 5 else 2  # the rover arm has no joint that turns its tool about the base's z
    across, on = np.eye(3)[(i + 1) % 3], np.eye(3)[(i + 2) % 3]
    at = [np.cos(a) * across + np.sin(a) * on for a in np.radians([-45, -32])]
    if i == 1:
        at = [np.cos(a) * across + np.sin(a) * on for a in np.radians([30, 43])]
    desk.drag(desk.handle(ABOUT * at[0]), desk.handle(ABOUT * at[1]))
    given = desk.answered()
    assert given["converged"], desk.page.locator("#target-words").inner_text()
    after = desk.drawn()
    turn = Rotation.from_matrix(after[:3, :3] @ before[:3, :3].T).as_rotvec()
    assert_allclose(turn, np.radians(13) * np.eye(3)[i], atol=0.03)
    assert_allclose(after[:3, 3], before[:3, 3], atol=MET)
    assert_drawn(desk.page, desk.arm)


def test_the_ball_moves_the_tool_in_the_plane_of_the_screen(rover: Desk) -> None:
    rover.reset("position")
    p = rover.drawn()[:3, 3]
    x, y, pixel = rover.screen(p)
    rover.page.mouse.move(x, y)
    rover.page.mouse.down()
    rover.page.mouse.move(x - 40, y - 30, steps=3)
    rover.page.mouse.up()
    assert rover.answered()["converged"]
    after = rover.drawn()[:3, 3]
    assert_allclose(rover.screen(after)[:2], [x - 40, y - 30], atol=1)
    assert np.linalg.norm(after - p) == pytest.approx(50 * pixel, rel=0.02)
    shown = rover.page.evaluate(
        "twistarm.parts.target.gizmo.handles.filter((one) => one.group.visible).map((one) => one.name)"
    )
    assert set(shown) <= {"x", "y", "z", "free"}  # a position has no turns


def test_snap_moves_by_whole_centimetres(rover: Desk) -> None:
    rover.reset("position", snap=True)
    before = rover.drawn()[:3, 3]
    tip = rover.handle([0, 0, ALONG])
    rover.drag(tip, tip + [0, 0, 0.034])
    assert rover.answered()["converged"]
    assert_allclose(rover.drawn()[:3, 3], before + [0, 0, 0.03], atol=MET)


def test_out_of_reach_the_nearest_is_shown(rover: Desk) -> None:
    rover.reset("approach")
    start = rover.viewer.theta
    tip = rover.handle([0, 0, ALONG])
    rover.drag(tip, tip + [0, 0, 0.7], steps=1)  # one step, one request: its search begins at the pose on show
    given = rover.answered()
    assert given["converged"] is False
    p, R = given["position"], Rotation.from_quat(given["xyzw"]).as_matrix()
    expected = solve_ik(rover.arm, Approach(p, R[:, 2]), start, posture="theta0")
    assert rover.page.locator("#target-words").inner_text().startswith("✕")
    theta = rover.viewer.theta
    assert_allclose(theta, expected.theta, atol=1e-6)
    assert np.linalg.norm(rover.drawn()[:3, 3] - p) == pytest.approx(expected.position_error, abs=MET)
    after_frames(rover.page)
    assert_allclose(rover.page.evaluate("twistarm.parts.target.gizmo.group.position.toArray()"), p)
    rover.page.get_by_role("button", name="Clear target").click()
    idle(rover.page)
    assert rover.page.locator("#target-words").inner_text() == ""
    assert rover.viewer.theta.tolist() == theta.tolist()


def test_escape_puts_the_arm_back(rover: Desk) -> None:
    rover.reset("approach")
    tip = rover.handle([0, 0, ALONG])
    rover.drag(tip, tip + [0, 0, 0.05], keep=True)
    assert rover.answered()["converged"]
    rover.page.keyboard.press("Escape")
    rover.page.mouse.move(600, 600)
    rover.page.mouse.up()
    idle(rover.page)
    assert rover.viewer.theta.tolist() == rover.arm.ready.tolist()
    assert rover.page.locator("#target-words").inner_text() == ""


def test_a_pose_is_typed_and_roll_and_yaw_stay_while_the_pitch_passes_90_degrees(desks: Callable[[str], Desk]) -> None:
    """The read-outs lie over the boxes. SciPy tells the rotation."""
    desk = desks("rover_arm_6dof")
    desk.reset("pose")
    z = round(desk.drawn()[2, 3] - 0.04, 6)
    typed: dict[str, float] = {"roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    moves = [("roll", 20), ("pitch", 90), ("yaw", 30), ("z", z), *(("pitch", value) for value in (80, 90, 100, 75))]
    for k, (name, value) in enumerate(moves):
        box = desk.page.get_by_role("spinbutton", name=f"tool {name}, {'metres' if name == 'z' else 'degrees'}")
        box.fill(str(value))
        box.press("Enter")
        typed[name] = value
        desk.answered()
        if k < 3:
            continue
        words = [f"{typed[angle]:.1f}°" for angle in ("roll", "pitch", "yaw")]
        assert [desk.page.locator(f"#tool-{angle}").text_content() for angle in ("roll", "pitch", "yaw")] == words
        angles = [typed["roll"], typed["pitch"], typed["yaw"]]
        expected = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
        assert_allclose(desk.arm.fk(desk.viewer.theta)[:3, :3], expected, atol=1e-5)
        assert desk.drawn()[2, 3] == pytest.approx(z, abs=1e-5)


def test_a_servo_takes_the_handles_away(rover: Desk) -> None:
    rover.reset()
    shown = "twistarm.parts.target.gizmo.group.visible"
    until(rover.page, shown)
    assert rover.viewer.commands is not None
    until(rover.page, f"!{shown} && document.getElementById('drag-tool').disabled")
    assert rover.page.get_by_role("spinbutton", name="tool x, metres").is_disabled()
    rover.viewer.show_servo(None)
    until(rover.page, shown)


# Of the rover arm's two configurations for where its tool points here, the other is outside the limits.
START = np.radians([0.0, 29.64, -111.9, -97.74, 0.0]).tolist()

GHOSTS = """twistarm.parts.solutions.arms.map(({ group, parts }) =>
  group.children.length === parts.length && parts.length > 0)"""


@pytest.mark.smoke
def test_all_configurations_are_stepped_through_and_drawn(rover: Desk) -> None:
    page, viewer, arm = rover.page, rover.viewer, rover.arm
    flips = solve_ik_all(arm, Approach([0.8, 0.1, 0.7], direction=[1, 0, 0]))
    assert (len(flips), len(flips.outside)) == (2, 0)
    rover.reset("approach", theta=flips[0])
    page.get_by_role("button", name="All configurations").click()
    until(page, "twistarm.parts.solutions.at === 0")
    place = page.locator("#solution-place")
    assert place.inner_text() == "1 of 2"
    words = page.locator("#solutions-words").inner_text()
    assert "2 configurations" in words
    assert "wrist_roll" in words
    assert page.evaluate(GHOSTS) == [True], "the other one"
    page.get_by_role("button", name="Next configuration").click()
    until(page, "document.getElementById('solution-place').textContent === '2 of 2'")
    until(page, f"Math.abs(twistarm.state.frame.theta[2] - {flips[1][2]}) < 1e-9")
    assert_allclose(viewer.theta, flips[1], atol=1e-9)
    page.keyboard.press("n")
    until(page, "document.getElementById('solution-place').textContent === '1 of 2'")
    page.get_by_label("Ghosts").set_checked(False)
    assert page.evaluate(GHOSTS) == []
    page.get_by_role("button", name="Done").click()
    until(page, "document.getElementById('solutions').hidden")

    # One beyond the limits: drawn, and the arm stays.
    viewer.show(START)
    until(page, f"twistarm.state.frame.theta[1] === {START[1]}")
    page.get_by_label("Ghosts").evaluate("(box) => box.checked = true")
    page.locator("#pane").click(position={"x": 20, "y": 500})
    page.keyboard.press("n")
    until(page, "twistarm.parts.solutions.at === 0")
    page.keyboard.press("p")
    until(page, "twistarm.parts.solutions.at === 1")
    assert page.locator("#solution-words").inner_text().startswith("outside the limits: ")
    assert page.evaluate(GHOSTS) == [True]
    assert np.abs(viewer.theta - START).max() < 1e-6
    viewer.show(arm.ready)
    until(page, "document.getElementById('solutions').hidden")


def test_an_orientation_is_shown_and_typed_in_three_ways(rover: Desk) -> None:
    page = rover.page
    rover.reset("pose", theta=np.array([0.0, 0.4, -0.9, 0.3, 0.6]))
    R = rover.drawn()[:3, :3]
    way = page.get_by_label("Orientation in numbers")
    way.select_option("quaternion")
    shown = [float(page.locator(f"#tool-{name}").inner_text().replace("−", "-")) for name in ("qx", "qy", "qz", "qw")]
    expected = Rotation.from_matrix(R).as_quat()
    assert_allclose(shown, expected * np.sign(expected @ shown), atol=6e-4)
    wanted = Rotation.from_euler("ZYX", [0.2, 0.5, 0.3])
    for name, value in zip(("qx", "qy", "qz", "qw"), 3 * wanted.as_quat(), strict=True):  # of any length
        box = page.get_by_label(f"tool {name}", exact=True)
        box.fill(f"{value:.9f}")
        box.press("Enter")
        given = rover.answered()
    assert np.linalg.norm(given["xyzw"]) == pytest.approx(1.0, abs=1e-12)
    assert (Rotation.from_quat(given["xyzw"]) * wanted.inv()).magnitude() < 1e-8
    way.select_option("axis")
    for name, value in {"axis x": 0, "axis y": 2, "axis z": 0, "angle": "270 deg"}.items():
        box = page.get_by_label(f"tool {name}" + (", degrees" if name == "angle" else ""), exact=True)
        box.fill(str(value))
        box.press("Enter")
        given = rover.answered()
    assert (Rotation.from_quat(given["xyzw"]) * Rotation.from_rotvec([0, 1.5 * np.pi, 0]).inv()).magnitude() < 1e-8
    assert page.get_by_label("tool angle, degrees").input_value() == "270.0"
    way.select_option("rpy")
