"""Recorded poses on the page: the list, the motion through it, the player, the plots, and what is saved."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from arms import ARMS, DRAWN, assert_drawn
from twistarm import Arm, load_arm, load_trajectory
from twistarm.arm.usual_limits import with_defaults
from twistarm.description.companions.data_files import toml_content
from twistarm.planning.joint_space import plan_joint
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer import Viewer
from waiting import settled, until

pytestmark = pytest.mark.browser


POSE = '{"name": "p", "theta": [0]}'


def postures(arm: Arm, count: int) -> list[np.ndarray[Any, Any]]:
    """Inside the limits, ready the first; the others near it, so that a spline through them stays inside too."""
    rng = np.random.default_rng(5)
    return [arm.ready, *(0.8 * arm.ready + 0.2 * arm.random_theta(rng) for _ in range(count - 1))]


def open_poses(page: Any, viewer: Viewer) -> Any:
    """A settled page with the tab of poses in front."""
    settled(page, viewer.url)
    page.get_by_role("tab", name="Poses").click()
    return page


def stand(page: Any, viewer: Viewer, theta: Any) -> None:
    viewer.show(theta)
    until(page, f"String(twistarm.state.frame.theta) === String({np.asarray(theta).tolist()})")


def record(page: Any, viewer: Viewer, theta: Any, name: str = "") -> None:
    """By keyboard: the name, then Enter; as a person, wait until it is in the list."""
    stand(page, viewer, theta)
    count = page.locator("#pose-list li").count()
    box = page.get_by_label("Name of the pose to record")
    box.fill(name)
    box.press("Enter")
    until(page, f"document.querySelectorAll('#pose-list li').length === {count + 1}")


def listed(page: Any) -> list[str]:
    """The names as they stand on the page."""
    names: list[str] = page.evaluate("[...document.querySelectorAll('#pose-list .name')].map((box) => box.value)")
    return names


def until_listed(page: Any, names: list[str]) -> None:
    until(page, "[...document.querySelectorAll('#pose-list .name')].map((box) => box.value).join('|') === "
          + json.dumps("|".join(names)))  # fmt: skip


def shown(page: Any) -> dict[str, Any]:
    frame: dict[str, Any] = page.evaluate("twistarm.state.frame")
    return frame


def plan(page: Any, kind: str) -> None:
    page.get_by_label("Kind of motion").select_option(kind)
    page.get_by_role("button", name="Plan", exact=True).click()
    until(page, "document.getElementById('program-note').textContent.startsWith('Planned')")


def press_of_the_list(page: Any, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


@pytest.mark.smoke
@pytest.mark.parametrize("arm", ARMS, indirect=True)
def test_poses_are_recorded_gone_to_planned_and_played(page: Any, arm: Arm, viewer: Viewer) -> None:
    open_poses(page, viewer)
    thetas = postures(arm, 3)
    stand(page, viewer, thetas[0])
    page.get_by_role("button", name="Record", exact=True).click()
    until_listed(page, ["pose 1"])
    record(page, viewer, thetas[1], "over the box")
    record(page, viewer, thetas[2])
    assert listed(page) == ["pose 1", "over the box", "pose 3"]
    press_of_the_list(page, "Go to over the box")
    until(page, "document.querySelectorAll('#pose-list li')[1].ariaCurrent === 'true'")
    assert shown(page)["theta"] == viewer.recorded["over the box"].tolist()
    assert_array_equal(viewer.recorded["over the box"], thetas[1])

    plan(page, "s_curve")
    motion = plan_joint(arm, thetas, limits=with_defaults(arm))
    assert not shown(page)["running"]
    assert shown(page)["theta"] == thetas[0].tolist()
    assert page.evaluate("twistarm.parts.player.duration") == motion.duration
    page.get_by_label("Playback speed").select_option("0.5")
    page.get_by_role("button", name="Play").click()
    until(page, "twistarm.state.frame.time > 0.3")
    page.get_by_role("button", name="Pause").click()
    until(page, "!twistarm.state.frame.running")
    scrub(page, 0.75)
    until(page, f"Math.abs(twistarm.state.frame.time - {0.75 * motion.duration}) < {0.02 * motion.duration}")
    assert_allclose(shown(page)["theta"], motion(shown(page)["time"]), atol=DRAWN)
    assert_drawn(page, arm)


def scrub(page: Any, share: float) -> None:
    """Click on the scrubber."""
    box = page.get_by_label("Time", exact=True).bounding_box()
    page.mouse.click(box["x"] + 8 + share * (box["width"] - 16), box["y"] + box["height"] / 2)


def test_the_list_is_edited_by_keyboard_and_mouse_on_two_pages(page: Any, other: Any, arm: Arm, viewer: Viewer) -> None:
    open_poses(other, viewer)
    open_poses(page, viewer)
    for theta, name in zip(postures(arm, 4), "abcd", strict=True):
        record(page, viewer, theta, name)
    until_listed(other, ["a", "b", "c", "d"])
    box = page.get_by_label("Name of pose 4")
    box.fill("drop")
    box.press("Enter")
    until_listed(other, ["a", "b", "c", "drop"])
    box.fill("nothing")
    box.press("Escape")
    page.keyboard.press("Alt+ArrowUp")
    page.keyboard.press("Alt+ArrowUp")
    until_listed(other, ["a", "drop", "b", "c"])
    assert page.evaluate("document.activeElement.value") == "drop"  # the focus went along
    press_of_the_list(page, "Move down a")
    until_listed(other, ["drop", "a", "b", "c"])
    press_of_the_list(other, "Delete b")
    until_listed(page, ["drop", "a", "c"])
    assert list(viewer.recorded) == ["drop", "a", "c"]
    page.keyboard.press("ControlOrMeta+z")
    until_listed(other, ["drop", "a", "b", "c"])
    other.get_by_role("button", name="Undo").click()
    until_listed(page, ["a", "drop", "b", "c"])
    page.keyboard.press("ControlOrMeta+Shift+z")
    page.keyboard.press("ControlOrMeta+Shift+z")
    until_listed(other, ["drop", "a", "c"])
    # What is being typed in a row survives what another page does to the list.
    box = page.get_by_label("Name of pose 1")
    box.fill("half a na")
    page.keyboard.press("ControlOrMeta+Shift+z")  # the box's own: nothing happens to the list
    press_of_the_list(other, "Delete a")
    until(page, "document.querySelectorAll('#pose-list li').length === 2")
    assert listed(page) == ["half a na", "c"]
    page.keyboard.type("me")
    page.keyboard.press("Enter")
    until_listed(other, ["half a name", "c"])
    page.get_by_label("Round corners within").fill("0")
    plan(page, "time_optimal")
    until(other, "document.getElementById('plan-kind').value === 'time_optimal'")  # of all pages
    assert_one_player(page, other)
    assert page.evaluate("document.getElementById('error').hidden")


def assert_one_player(page: Any, other: Any) -> None:
    """Speed, loop, play and pause of one page are those of the other."""
    page.get_by_label("Playback speed").select_option("2")
    page.get_by_label("Loop").check()
    until(other, "document.getElementById('speed').value === '2' && document.getElementById('loop').checked")
    other.get_by_role("button", name="Play").click()
    page.evaluate("globalThis.seen = []; twistarm.parts.spy = { update: ({ time }) => seen.push(time) }")
    until(page, "seen.some((time, i) => time < seen[i - 1])")  # it began again
    assert page.evaluate("twistarm.state.frame.running")
    page.get_by_role("button", name="Pause").click()
    until(other, "!twistarm.state.frame.running")


def test_a_plot_is_clicked_to_seek_and_hovered_to_read(page: Any, arm: Arm, viewer: Viewer) -> None:
    open_poses(page, viewer)
    thetas = postures(arm, 3)
    for theta in thetas:
        record(page, viewer, theta)
    plan(page, "time_optimal")
    motion = plan_joint(arm, thetas, kind="time_optimal", limits=with_defaults(arm))
    velocity = page.locator(".plot").nth(1)
    box = velocity.bounding_box()
    page.mouse.click(box["x"] + 46 + 0.4 * (box["width"] - 56), box["y"] + 60)
    until(page, f"Math.abs(twistarm.state.frame.time - {0.4 * motion.duration}) < {0.01 * motion.duration}")
    time = shown(page)["time"]
    tip = page.locator("#plots .tip")
    shoulder = arm.joint_names.index("shoulder")
    rate = np.degrees(motion(time, 1)[shoulder])
    share = abs(motion(time, 1)[shoulder]) / arm.limits.velocity[shoulder]
    assert f"{rate:.1f} °/s · {100 * share:.0f} %".replace("-", "−") in tip.inner_text()
    page.get_by_label("Joints plotted").get_by_role("button", name="shoulder").click()
    page.mouse.move(0, 0)
    until(page, "document.querySelectorAll('.plot polyline').length === 4")
    assert tip.is_hidden()
    assert_read_off(velocity, motion, shoulder)


def assert_read_off(plot: Any, motion: Trajectory, joint: int) -> None:
    """What one reads off the line by two of the numbers beside it is the velocity, in degrees a second."""
    marks = plot.evaluate(
        """(svg) => [...svg.querySelectorAll("text.tick[text-anchor=end]")].map((tick) =>
             [Number(tick.textContent.replace("−", "-")), Number(tick.getAttribute("y")) - 4])"""
    )
    (low, y_low), (high, y_high) = min(marks), max(marks)
    assert high > low
    points = plot.locator("polyline").get_attribute("points").split()
    x, y = np.array([point.split(",") for point in points], dtype=float).T
    times = (x - x[0]) / (x[-1] - x[0]) * motion.duration
    values = low + (y - y_low) / (y_high - y_low) * (high - low)
    pixel = abs((high - low) / (y_high - y_low))
    assert_allclose(values, np.degrees(motion(times, 1)[:, joint]), atol=pixel)


def test_a_list_is_saved_and_loaded_and_the_motion_exported(
    page: Any, arm: Arm, viewer: Viewer, tmp_path: Path
) -> None:
    open_poses(page, viewer)
    assert page.locator("#program a[download][href]").count() == 0
    thetas = postures(arm, 3)
    for theta, name in zip(thetas, ("one", "zwei", "三"), strict=True):
        record(page, viewer, theta, name)
    moves = [page.get_by_label(f"Move to {name}") for name in ("one", "zwei", "三")]
    moves[2].select_option("screw")
    until(page, "twistarm.parts.program.poses[2].by === 'screw'")
    assert moves[0].is_disabled()
    with page.expect_download() as saving:
        press_of_the_list(page, "Save")
    assert saving.value.suggested_filename == "rover_arm_poses.json"
    path = tmp_path / "poses.json"
    saving.value.save_as(path)
    saved = json.loads(path.read_text("utf-8"))
    assert saved["joints"] == list(arm.joint_names)
    assert [(pose["name"], pose["theta"], pose["by"]) for pose in saved["poses"]] == [
        (name, theta.tolist(), by)
        for name, theta, by in zip(("one", "zwei", "三"), thetas, ("joint", "joint", "screw"), strict=True)
    ]
    press_of_the_list(page, "Delete zwei")
    until_listed(page, ["one", "三"])
    order = [2, 0, 1, 4, 3]
    poses = [{**pose, "theta": [pose["theta"][i] for i in order]} for pose in saved["poses"]]
    turned = {"joints": [arm.joint_names[i] for i in order], "poses": poses}
    path.write_text(json.dumps(turned), "utf-8")
    choose(page, path)
    until_listed(page, ["one", "zwei", "三"])
    assert_array_equal(list(viewer.recorded.values()), thetas)
    assert page.evaluate("twistarm.parts.program.poses.map(({ by }) => by)") == ["joint", "joint", "screw"]
    moves[2].select_option("joint")

    plan(page, "time_optimal")
    with page.expect_download() as exporting:
        page.get_by_role("link", name="CSV").click()
    assert exporting.value.suggested_filename == "rover_arm_motion.csv"
    exporting.value.save_as(tmp_path / "motion.csv")
    motion = plan_joint(arm, thetas, kind="time_optimal", limits=with_defaults(arm))
    assert load_trajectory(arm, tmp_path / "motion.csv").duration == motion.duration


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "poses.json is not JSON"),
        ('{"joints": ["a"], "poses": [{"name": "p", "theta": [0]}]}', "the joints a; rover_arm has slide"),
        ('{"joints": ["a"], "poses": [' + ",".join([POSE] * 3000) + "]}", "at most 57344 (56 kB)"),
        (" " * (2**20 + 1), "poses.json has 1048577 bytes"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_list_is_told_and_changes_nothing(
    shared: tuple[Any, Viewer], tmp_path: Path, text: str, reason: str
) -> None:
    page, viewer = shared
    path = tmp_path / "poses.json"
    path.write_text(text)
    choose(page, path)
    until(page, f"document.getElementById('error').textContent.includes({json.dumps(reason)})")
    assert list(viewer.recorded) == ["kept"]


@pytest.fixture(scope="module")
def shared(shown: Callable[[str], tuple[Any, Viewer]]) -> tuple[Any, Viewer]:
    """One page with one recorded pose, for tests that change nothing."""
    page, viewer = shown("rover_arm")
    record(open_poses(page, viewer), viewer, viewer.arm.ready, "kept")
    return page, viewer


def choose(page: Any, path: Path) -> None:
    with page.expect_file_chooser() as choosing:
        press_of_the_list(page, "Load")
    choosing.value.set_files(path)


def test_a_pose_is_shown_as_lines_for_arm_toml(page: Any) -> None:
    arm = load_arm("rover_arm")
    theta = [0.1, 0.2, -0.3, 0.4, 0.5]
    with Viewer(arm, theta, open_browser=False) as viewer:
        record(open_poses(page, viewer), viewer, theta, "on the rack")
        page.locator("#keep summary").click()
        page.get_by_label("Pose to keep").select_option("on the rack")
        lines = toml_content(page.locator("#keep-text").inner_text(), Path("arm.toml"))
        assert lines == {"poses": {"on the rack": arm.theta_to_dict(theta)}}
        page.get_by_label("Pose to keep").select_option("the pose on show")
        page.get_by_label("Name of the pose in arm.toml").fill("flat")
        assert page.locator("#keep-text").inner_text().startswith("[poses.flat]\n")
        page.goto("about:blank")
