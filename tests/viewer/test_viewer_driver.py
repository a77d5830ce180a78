"""The switch Drive of a page: a servo on simulated joints inside the view, from its beginning to every end."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from twistarm import Arm, Scene, load_arm
from twistarm.arm.usual_limits import DEFAULTS
from twistarm.control.servo import ServoOutput, ServoSettings
from twistarm.control.stream import Cycle
from twistarm.support.errors import InputError
from twistarm.viewer import Viewer
from twistarm.viewer.parts.show import NO_DRIVE
from viewer_page import WAIT, Page, until, visit

SPEED = 0.05  # Of the twists that pages command here [m/s].
JOURNEY = 6 * WAIT  # Longest time in which a drive reaches its end, on a busy machine too [s].


@pytest.fixture(scope="module")
def arm() -> Arm:
    return load_arm("rover_arm_6dof")


@pytest.fixture
def viewer(arm: Arm) -> Iterator[Viewer]:
    with Viewer(arm, open_browser=False) as served:
        yield served
    assert driving() == []


def driving() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "twistarm drive"]


def switch(page: Page, on: bool) -> None:
    page.ask(type="servo", on=on)
    page.until(lambda: page.latest["drive"]["on"] == page.latest["servo"]["driven"] == on)


def push(page: Page, reached: Callable[[], bool], **command: Any) -> None:
    """A command said again every 30 ms until something is reached, to which the arm drives at its own speed."""
    end = time.monotonic() + JOURNEY
    while not reached():
        assert time.monotonic() < end
        page.ask(**command)
        time.sleep(0.03)


def still(page: Page, viewer: Viewer, stop: bool = True) -> None:
    """Stop, or say nothing more, until the arm stands."""
    if stop:
        page.ask(type="stop")
    looks: list[list[float]] = []
    while len(looks) < 4 or any(look != looks[-1] for look in looks[-4:]):
        looks.append(viewer.theta.tolist())
        time.sleep(0.1)


def away(viewer: Viewer, least: float) -> Callable[[], bool]:
    """Whether some joint has moved that far from where it is now [rad, m]."""
    start = viewer.theta
    return lambda: bool(np.abs(viewer.theta - start).max() > least)


@contextmanager
def driven(viewer: Viewer) -> Iterator[Page]:
    """A page with Drive switched on."""
    with Page(viewer) as page:
        switch(page, True)
        yield page


def test_joints_are_jogged_by_their_rates_and_silence_stops_them(viewer: Viewer, arm: Arm) -> None:
    before, rates = viewer.theta, np.zeros(arm.n)
    rates[[1, 3]] = 0.2, -0.4
    with driven(viewer) as page:
        push(page, away(viewer, 0.1), type="jog_joints", rates=rates.tolist())
        still(page, viewer, stop=False)
    moved = viewer.theta - before
    assert_allclose(moved[[0, 2, 4, 5]], 0.0, atol=1e-9)
    assert moved[3] < -0.1
    assert moved[3] == pytest.approx(-2.0 * moved[1], rel=0.1)


def test_it_stops_before_an_obstacle_and_says_which(arm: Arm) -> None:
    scene = Scene(arm)
    scene.add_box("wall", (0.02, 1.0, 1.0), arm.fk(arm.ready)[:3, 3] + [0.15, 0.0, 0.0])
    before = scene.distance(arm.ready).metres
    assert before > 0.02
    with Viewer(arm, open_browser=False, scene=scene) as viewer, driven(viewer) as page:
        push(
            page,
            lambda: "wall" in page.latest["servo"]["reason"] and page.latest["servo"]["status"].startswith("HALTED"),
            type="jog", twist=[0.1, 0, 0, 0, 0, 0], frame="base",
        )  # fmt: skip
        still(page, viewer)
        assert 0.0 < scene.distance(viewer.theta).metres < 0.5 * before


def test_it_stops_at_a_limit_and_says_which(arm: Arm) -> None:
    near = arm.ready.copy()
    joint = int(np.flatnonzero(np.isfinite(arm.limits.upper))[0])
    near[joint] = arm.limits.upper[joint] - 0.05
    rates = np.zeros(arm.n)
    rates[joint] = 0.5
    with Viewer(arm, near, open_browser=False) as viewer:
        with driven(viewer) as page:
            push(
                page, lambda: page.latest["servo"]["status"] == "HALTED_LIMIT", type="jog_joints", rates=rates.tolist()
            )
            assert page.latest["servo"]["joint"] == arm.joint_names[joint]
        assert arm.limits.upper[joint] - 0.05 < viewer.theta[joint] <= arm.limits.upper[joint]


def test_limits_that_an_arm_does_not_give_are_the_usual_ones_and_said(arm: Arm) -> None:
    bare = replace(arm, limits=arm.limits.with_({"velocity": np.inf, "acceleration": np.inf}, arm.joint_names))
    fastest = DEFAULTS["velocity"]["rad"]
    rates = [5.0 * fastest, *[0.0] * (arm.n - 1)]
    slowed = f"slowed by the velocity limit of {arm.joint_names[0]}"
    with Viewer(bare, open_browser=False) as viewer, driven(viewer) as page:
        assert page.latest["drive"]["note"].startswith("no limits given, used instead: velocity 1 rad/s for ")
        start = time.monotonic()
        push(page, lambda: page.latest["servo"]["reason"] == slowed, type="jog_joints", rates=rates)
        push(page, away(viewer, 0.3), type="jog_joints", rates=rates)
        assert viewer.theta[0] - bare.ready[0] < fastest * (time.monotonic() - start)


def test_sliding_or_stopping_is_chosen_while_it_drives(viewer: Viewer, arm: Arm) -> None:
    out = {"type": "jog", "twist": [0.0, 0.3, 0.5, 0, 0, 0], "frame": "base"}  # up and aside, out of reach in the end

    def side() -> float:
        return float(arm.poses(viewer.theta)[arm.tip][1, 3])

    with driven(viewer) as page:
        assert page.latest["drive"]["on_unreachable"] == "slide"
        page.ask(type="on_unreachable", what="stop")
        page.until(lambda: page.latest["drive"]["on_unreachable"] == "stop")
        looks: list[float] = []
        push(page, lambda: looks.append(side()) or (len(looks) > 40 and np.ptp(looks[-40:]) < 1e-4), **out)
        page.ask(type="on_unreachable", what="slide")
        push(page, lambda: side() > looks[-1] + 0.01, **out)


def test_a_servo_of_the_program_heeds_the_choice_if_it_says_so(viewer: Viewer) -> None:
    settings = viewer.servo_settings(ServoSettings(damping=0.1, on_unreachable="stop"))
    assert settings() == ServoSettings(damping=0.1, on_unreachable="stop")
    with Page(viewer) as page:
        page.until(lambda: page.latest["drive"] == NO_DRIVE | {"on_unreachable": "stop", "free": True})
        page.ask(type="on_unreachable", what="slide")
        assert settings() == ServoSettings(damping=0.1)
        viewer.show_servo(None)
        page.until(lambda: page.latest["drive"] == NO_DRIVE)
    with pytest.raises(InputError, match="settings must be a ServoSettings"):
        viewer.servo_settings("stop")  # type: ignore[arg-type]


def test_switched_off_it_comes_to_rest_and_frees_the_sliders(viewer: Viewer, arm: Arm) -> None:
    with driven(viewer) as page:
        turn = {"type": "jog_joints", "rates": [0.5, *[0.0] * (arm.n - 1)]}
        push(page, away(viewer, 0.05), **turn)
        page.ask(type="pose", name="ready", ease=False)
        assert "Drive in the Jog panel" in page.latest["error"]["message"]
        push(page, away(viewer, 0.05), **turn)
        moving = viewer.theta[0]
        switch(page, False)
        assert viewer.theta[0] - moving > 1e-3  # braked, not cut off
        assert not page.latest["servo"]["driven"]
        assert driving() == []
        left = viewer.theta
        page.ask(type="joint", name=arm.joint_names[0], value=0.25)
        assert "error" not in page.latest
        until(lambda: viewer.theta[0] == 0.25)
        assert viewer.theta[1:].tolist() == left[1:].tolist()
        page.ask(type="jog", twist=[0.1, 0, 0, 0, 0, 0], frame="base")
        assert page.latest["error"]["message"].startswith("no servo takes commands here")


def test_the_last_page_s_end_is_its_end(viewer: Viewer, arm: Arm) -> None:
    with driven(viewer) as page:
        second = page.other()
        push(second, away(viewer, 0.02), type="jog_joints", rates=[0.5, *[0.0] * (arm.n - 1)])
        second.close()
        second.until_closed()
        still(page, viewer)  # who jogged has gone: at rest
        assert len(driving()) == 1
    end = time.monotonic() + 3.0
    while driving():
        assert time.monotonic() < end
        time.sleep(0.01)
    assert not visit(viewer).latest["servo"]["driven"]


def test_the_view_s_end_leaves_no_thread(arm: Arm) -> None:
    viewer = Viewer(arm, open_browser=False)
    with driven(viewer) as page:
        push(page, away(viewer, 0.02), type="jog_joints", rates=[0.5, *[0.0] * (arm.n - 1)])
        viewer.close()
        assert driving() == []
    assert viewer.theta[0] > arm.ready[0]


def test_it_does_not_begin_where_a_servo_of_the_program_drives(viewer: Viewer, arm: Arm) -> None:
    with Page(viewer) as page:
        _ = viewer.commands
        page.ask(type="servo", on=True)
        assert "a servo of the program" in page.latest["error"]["message"]
        viewer.show_servo(None)
        viewer.show_servo(ServoOutput.stale(np.zeros(arm.n), "waiting"))  # one that pages do not command
        page.ask(type="servo", on=True)
        assert "a servo of the program" in page.latest["error"]["message"]
        assert driving() == []
        viewer.show_servo(None)
        switch(page, True)


def test_a_servo_of_the_program_takes_over(viewer: Viewer, arm: Arm) -> None:
    with driven(viewer) as page:
        _ = viewer.commands
        page.until(lambda: not page.latest["drive"]["on"])
        assert page.latest["servo"]["driven"]
        theta = arm.ready + 0.1
        viewer.show_servo(Cycle(0.0, None, theta, None, "not yet"))
        page.until(lambda: page.latest["servo"]["reason"] == "not yet")
        page.ask(type="pose", name="zero", ease=False)
        assert page.latest["error"]["message"].startswith("a servo drives")
        assert viewer.theta.tolist() == theta.tolist()
        assert driving() == []
        viewer.show_servo(None)
        page.until(lambda: not page.latest["servo"]["driven"])


def test_what_the_program_shows_goes_first_and_is_told(viewer: Viewer, arm: Arm) -> None:
    theta = arm.ready + 0.05
    with driven(viewer) as page:
        push(page, away(viewer, 0.01), type="jog", twist=[SPEED, 0, 0, 0, 0, 0], frame="base")
        viewer.show(theta)
        page.until(lambda: "error" in page.latest)
        assert "Drive was switched off" in page.latest["error"]["message"]
        page.until(lambda: not page.latest["servo"]["driven"])
    assert viewer.theta.tolist() == theta.tolist()


def test_outside_the_limits_it_does_not_begin(arm: Arm) -> None:
    theta, joint = arm.ready.copy(), int(np.flatnonzero(np.isfinite(arm.limits.upper))[0])
    theta[joint] = arm.limits.upper[joint] + 0.1
    with Viewer(arm, theta, open_browser=False) as viewer:
        with Page(viewer) as page:
            page.ask(type="servo", on=True)
            assert page.latest["error"]["message"].startswith(f"{arm.joint_names[joint]} = ")
            assert "is outside its limits" in page.latest["error"]["message"]
            assert not page.latest["drive"]["on"]
        assert driving() == []
