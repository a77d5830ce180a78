"""Commands of the pages: each page is a commander, its nonsense, its silence and its end stop the arm."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from test_viewer_messages import BAD_MESSAGES
from twistarm import ArmBuilder, plan_joint
from twistarm.control.servo import JogCommand, TwistCommand
from twistarm.viewer import Viewer
from twistarm.viewer.parts.servo_words import SILENT
from viewer_page import Page, until

ARM = (
    ArmBuilder("pair")
    .revolute("a", [0, 0, 1], [0, 0, 0.1], lower=-2, upper=2)
    .revolute("b", [0, 1, 0], [0, 0, 0.3], lower=-2, upper=2)
    .tool(np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.3], [0, 0, 0, 1.0]]))
    .build()
)

TWIST = [0.1, 0.0, -0.05, 0.0, 0.4, 0.0]

BAD_COMMANDS = [
    ({"type": "jog", "twist": TWIST}, "jog needs twist, frame; got ['twist']"),
    ({"type": "jog", "twist": [*TWIST[:5], float("nan")], "frame": "tool"}, "numbers must be finite; got NaN"),
    ({"type": "jog", "twist": [*TWIST[:5], 1e9], "frame": "tool"}, "twist[5] must be finite and at most 1e+06"),
    ({"type": "jog", "twist": TWIST, "frame": "world"}, "frame must be 'tool' or 'base'; got 'world'"),
    ({"type": "jog_joints", "rates": [0.1]}, "rates must be 2 numbers, base to tip: "),
    ({"type": "jog_joints", "rates": [1e5, 0]}, "theta_dot must be at most 10000"),
]


@pytest.fixture
def viewer() -> Iterator[Viewer]:
    with Viewer(ARM, [0.2, 0.3], open_browser=False) as served:
        yield served


def jog(page: Page, frame: str = "tool") -> None:
    page.ask(type="jog", twist=TWIST, frame=frame)


def reading(viewer: Viewer) -> Any:
    """What a servo reads from the pages now."""
    return viewer.commands.read(time.monotonic())


# commands in ------------------------------------------------------------------------------------------


def test_nothing_is_taken_before_somebody_asks_for_commands(viewer: Viewer) -> None:
    with Page(viewer) as page:
        assert page.latest["servo"] == {"type": "servo", "jog": False, "driven": False, **SILENT}
        jog(page)
        assert page.latest["error"]["message"].startswith("no servo takes commands here: start one by `twistarm servo")
    assert reading(viewer).command is None


def test_a_page_s_twist_and_its_stop_are_what_the_servo_reads(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        page.until(lambda: page.latest.get("servo", {}).get("jog", False))
        for frame in ("tool", "base"):
            jog(page, frame)
            command = reading(viewer).command
            assert isinstance(command, TwistCommand)
            assert (command.twist.tolist(), command.frame) == (TWIST, frame)
        page.ask(type="stop")
        command = reading(viewer).command
        assert isinstance(command, JogCommand)
        assert command.theta_dot.tolist() == [0, 0]
        assert "error" not in page.latest


def test_nonsense_from_a_page_that_jogs_stops_the_arm_and_says_why(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        for text, reason in [*((json.dumps({**message, "number": 8}), why) for message, why in BAD_COMMANDS),
                             *BAD_MESSAGES[:8]]:  # fmt: skip
            jog(page)
            page.send(text)
            page.until(lambda: "error" in page.latest)
            stopped = reading(viewer)
            assert reason in page.latest["error"]["message"]
            assert stopped.command is None
            assert reason in stopped.reason
        bystander = page.other()
        jog(page)  # sense again
        bystander.send("{")
        bystander.until(lambda: "error" in bystander.latest)
        assert reading(viewer).command is not None
        bystander.close()


# more than one page, and none ------------------------------------------------------------------------------


def test_two_pages_that_jog_are_two_commanders_and_the_arm_stands(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        second = page.other()
        jog(page)
        jog(second)
        both = reading(viewer)
        assert both.command is None
        assert both.reason == "two senders of a command, page 1 and page 2: stop one of them"
        time.sleep(viewer.commands.timeout + 0.05)
        jog(second)
        assert isinstance(reading(viewer).command, TwistCommand)
        second.close()


def test_a_page_that_goes_while_it_jogs_stops_the_arm(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        driver = page.other()
        jog(driver)
        assert reading(viewer).command is not None
        driver.close()
        until(lambda: reading(viewer).command is None)
        assert reading(viewer).reason == "command from page 2 refused: its page has gone"
        assert reading(viewer).age < viewer.commands.timeout


def test_a_page_that_goes_and_does_not_jog_disturbs_nobody(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        visitor, driver = page.other(), page.other()
        jog(visitor)
        visitor.ask(type="stop")
        time.sleep(viewer.commands.timeout + 0.05)
        visitor.close()
        until(lambda: len(viewer._server.clients) == 2)
        jog(driver)
        assert reading(viewer).command is not None
        driver.close()


# what pages are told -----------------------------------------------------------------------------------


def test_commands_move_nothing_on_show_and_send_no_frames(viewer: Viewer) -> None:
    _ = viewer.commands
    _ = viewer.theta  # the change is applied
    with Page(viewer) as page:
        onlooker = page.other()
        onlooker.latest.clear()
        for _ in range(50):
            jog(page)
            page.ask(type="stop")
        page.ask(type="visible", what="frames", visible=False)
        onlooker.until(lambda: bool(onlooker.latest))
        assert set(onlooker.latest) == {"visible"}
        onlooker.close()
    assert viewer.theta.tolist() == [0.2, 0.3]


def test_what_would_move_the_arm_under_the_servo_s_hands_is_refused(viewer: Viewer) -> None:
    _ = viewer.commands
    viewer.play(plan_joint(ARM, [[0, 0], [1, 1]], limits={"velocity": 1.0, "acceleration": 1.0}))
    with Page(viewer) as page:
        page.ask(type="pause")
        assert "error" not in page.latest
        held = viewer.theta
        for request in (
            {"type": "theta", "theta": [0, 0]},
            {"type": "joint", "name": "a", "value": 0.1},
            {"type": "pose", "name": "zero", "ease": False},
            {"type": "play"},
            {"type": "seek", "time": 0.1},
            {"type": "random", "ease": False},
        ):
            page.ask(**request)
            assert page.latest["error"]["message"].startswith(
                "a servo drives pair: sliders, poses and trajectories are free"
            )
        assert_array_equal(viewer.theta, held)
        page.ask(type="visible", what="screws", visible=False)
        assert "error" not in page.latest
