"""Commands of the pages to a servo, what it says on the pages, and the loop with a page at its head."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import schema_samples as samples
from test_viewer_messages import BAD_MESSAGES
from twistarm import ArmBuilder, plan_joint
from twistarm.control.servo import AnyCommand, JogCommand, ServoOutput, ServoReason, TwistCommand
from twistarm.control.stream import Cycle, Inbox, Reading, Setpoint
from twistarm.viewer import Viewer
from twistarm.viewer.parts.show import NO_REPORT
from twistarm.viewer.server.driver import servo_words
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
    ({"type": "jog", "twist": TWIST}, "'frame'"),
    ({"type": "jog", "twist": [*TWIST[:5], float("nan")], "frame": "tool"}, "NaN"),
    ({"type": "jog", "twist": [*TWIST[:5], 1e9], "frame": "tool"}, "twist[5]"),
    ({"type": "jog", "twist": TWIST, "frame": "world"}, "'world'"),
    ({"type": "jog_joints", "rates": [0.1]}, "rates"),
    ({"type": "jog_joints", "rates": [1e5, 0]}, "theta_dot"),
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


def test_nothing_is_taken_before_somebody_asks_for_commands(viewer: Viewer) -> None:
    with Page(viewer) as page:
        assert page.latest["servo"] == {"type": "servo", "jog": False, "driven": False, **NO_REPORT}
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
                             *BAD_MESSAGES[:5]]:  # fmt: skip
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


def test_two_pages_that_jog_are_two_commanders_and_the_arm_stands(viewer: Viewer) -> None:
    _ = viewer.commands
    with Page(viewer) as page:
        second = page.other()
        jog(page)
        jog(second)
        both = reading(viewer)
        assert both.command is None
        assert "page 1 and page 2" in both.reason
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
        assert "page 2" in reading(viewer).reason
        assert reading(viewer).age < viewer.commands.timeout


def test_what_would_move_the_arm_under_the_servo_s_hands_is_refused(viewer: Viewer) -> None:
    _ = viewer.commands
    viewer.play(plan_joint(ARM, [[0, 0], [1, 1]], limits={"velocity": 1.0, "acceleration": 1.0}))
    with Page(viewer) as page:
        page.ask(type="pause")
        assert "error" not in page.latest
        held = viewer.theta
        page.ask(type="joint", name="a", value=0.1)
        assert page.latest["error"]["message"].startswith("a servo drives pair")
        for kind in ("theta", "pose", "random", "play", "seek", "go", "plan", "target", "solutions", "solution"):
            page.ask(**samples.request(kind))
            assert page.latest["error"]["message"].startswith("a servo drives pair")
        assert_array_equal(viewer.theta, held)
        page.ask(type="needs", collision=False, reach=False)
        assert "error" not in page.latest


def answer(reason: ServoReason, joint: str | None, why: str) -> ServoOutput:
    return replace(ServoOutput.stale(np.zeros(2), why), reason=reason, joint=joint)


def cycle(reading: Reading, output: ServoOutput | None, reason: str = "") -> Cycle:
    setpoint = None if output is None else Setpoint(0, 0.0, np.zeros(2), np.zeros(2), output)
    return Cycle(0.0, reading, None if output is None else np.array([0.1, -0.1]), setpoint, reason)


STOP = JogCommand([0.0, 0.0])


@pytest.mark.parametrize(
    ("said", "idle"),
    [
        ([], True),  # nobody ever commanded
        ([TwistCommand(TWIST)], False),  # cut off in the middle of a motion
        ([TwistCommand(TWIST), STOP], True),
        ([STOP, TwistCommand(TWIST)], False),
        ([TwistCommand(TWIST), STOP, "nonsense"], False),
    ],
)
def test_silence_is_trouble_only_in_the_middle_of_a_motion(said: list[AnyCommand | str], idle: bool) -> None:
    """Read first when all of it is old: a loop that stalls may miss a stop, and still it is one."""
    inbox, stale = Inbox(), answer(ServoReason.STALE, None, "why")
    for each in said:
        if isinstance(each, str):
            inbox.refuse("page 1", each, 1.0)
        else:
            inbox.put("page 1", each, 1.0)
    reading = inbox.read(4.0)
    spoken = {"status": "STALE", "joint": None, "reason": "why", "share": None}
    assert servo_words(cycle(reading, stale, reading.reason)) == (NO_REPORT if idle else spoken)
    assert servo_words(cycle(reading, stale, "the last joint state is 1 s old")) == spoken


@pytest.mark.parametrize(
    ("command", "scale", "lost", "share"),
    [
        (TwistCommand(TWIST), 1.0, 0.0, 1.0),
        (TwistCommand(TWIST), 0.6, 0.3, 0.42),  # 60 % of the 70 % that can be reached
        (TwistCommand(TWIST), 1.0, 1.5, 0.0),
        (TwistCommand([0.0] * 6), 0.0, 0.0, None),
        (STOP, 0.0, 0.0, None),
        (None, 1.0, 0.0, None),
    ],
)
def test_how_much_of_a_command_is_done(
    command: AnyCommand | None, scale: float, lost: float, share: float | None
) -> None:
    output = replace(answer(ServoReason.MOVING, None, "moving"), scale=scale, lost_share=lost)
    assert servo_words(cycle(Reading(command, 0.0), output))["share"] == share
