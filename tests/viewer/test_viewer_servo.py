"""A servo on the pages: what it says, what is refused while it drives, and the loop with a page at its head."""

from __future__ import annotations

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from test_viewer_jog import ARM, TWIST, jog
from test_viewer_jog import viewer as viewer
from twistarm.control.servo import AnyCommand, JogCommand, ServoOutput, ServoStatus, TwistCommand
from twistarm.control.stream import Cycle, Inbox, Reading, Setpoint, SimulatedJoints, StreamReport, run
from twistarm.viewer import Viewer
from twistarm.viewer.parts.servo_words import SILENT, servo_words
from viewer_page import Page


def answer(status: ServoStatus, joint: str | None, reason: str) -> ServoOutput:
    return replace(ServoOutput.stale(np.zeros(2), reason), status=status, joint=joint)


def cycle(reading: Reading, output: ServoOutput | None, reason: str = "") -> Cycle:
    setpoint = None if output is None else Setpoint(0, 0.0, np.zeros(2), np.zeros(2), output)
    return Cycle(0.0, reading, None if output is None else np.array([0.1, -0.1]), setpoint, reason)


def test_a_servo_that_nobody_on_the_page_commands_and_its_end(viewer: Viewer) -> None:
    viewer.show_servo(cycle(Reading(None, np.inf, "none"), None, "no joint state has arrived"))
    with Page(viewer) as page:
        page.until(lambda: page.latest["servo"]["reason"] == "no joint state has arrived")
        assert not page.latest["servo"]["jog"]
        assert page.latest["servo"]["driven"]
        page.ask(type="pose", name="zero", ease=False)
        assert page.latest["error"]["message"].startswith("a servo drives pair")
        _ = viewer.commands
        page.until(lambda: page.latest["servo"]["jog"])
        viewer.show_servo(None)
        page.until(lambda: not page.latest["servo"]["jog"])
        assert not page.latest["servo"]["driven"]
        assert page.latest["servo"]["reason"] == ""
        jog(page)
        assert page.latest["error"]["message"].startswith("no servo takes commands here")
        page.ask(type="pose", name="zero", ease=False)
        assert "error" not in page.latest
    assert viewer.theta.tolist() == [0, 0]


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
    inbox, stale = Inbox(), answer(ServoStatus.STALE, None, "why")
    for each in said:
        if isinstance(each, str):
            inbox.refuse("page 1", each, 1.0)
        else:
            inbox.put("page 1", each, 1.0)
    reading = inbox.read(4.0)
    spoken = {"status": "STALE", "joint": None, "reason": "why", "share": None}
    assert servo_words(cycle(reading, stale, reading.reason)) == (SILENT if idle else spoken)
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
    output = replace(answer(ServoStatus.OK, None, "moving"), scale=scale, lost_share=lost)
    assert servo_words(cycle(Reading(command, 0.0), output))["share"] == share


def test_setpoints_that_nobody_hears_go_before_what_the_servo_says() -> None:
    lost = replace(cycle(Reading(TwistCommand(TWIST), 0.0), answer(ServoStatus.OK, None, "")), delivered=False)
    words = servo_words(replace(lost, reason="nobody listens at 127.0.0.1:5005"))
    assert words == {**SILENT, "reason": "nobody listens at 127.0.0.1:5005"}


def test_a_stop_says_nothing_of_two_commanders() -> None:
    inbox, stale = Inbox(), answer(ServoStatus.STALE, None, "why")
    inbox.put("page 1", TwistCommand(TWIST), 1.0)
    inbox.put("page 2", STOP, 1.01)
    reading = inbox.read(1.02)
    assert servo_words(cycle(reading, stale, reading.reason))["status"] == "STALE"


def test_a_page_drives_the_simulated_joints_and_its_silence_stops_them(viewer: Viewer) -> None:
    arm = replace(ARM, limits=ARM.limits.with_({"velocity": 1.0, "acceleration": 3.0}, ARM.joint_names))
    simulated = SimulatedJoints(arm, [0.2, 0.3])
    reports: list[StreamReport] = []
    spans: list[float] = []  # how long the page commanded

    silent = threading.Event()

    def loop() -> None:
        def rest() -> bool:
            return silent.is_set() and not simulated.theta_dot.any()

        show = viewer.show_servo
        reports.append(run(arm, viewer.commands, simulated, simulated, duration=20.0, until=rest, on_cycle=show))

    thread = threading.Thread(target=loop)
    with Page(viewer) as page:
        thread.start()
        start = time.monotonic()
        for _ in range(20):
            page.ask(type="jog", twist=[0, 0, 0, 0, 0.5, 0], frame="tool")  # joint b turns about the tool's y
            time.sleep(0.03)
        spans.append(time.monotonic() - start)
        silent.set()
        page.until(lambda: page.latest["servo"]["status"] == "OK")
        assert "error" not in page.latest
    thread.join()
    (report,) = reports
    moved = simulated.theta - [0.2, 0.3]
    assert abs(moved[0]) < 1e-6
    assert 0.2 < moved[1] < 0.5 * (spans[0] + viewer.commands.timeout) + 0.1  # at 0.5 rad/s, and 0.04 rad to stop
    assert not simulated.theta_dot.any()
    assert report.ok
    assert viewer.theta[1] == pytest.approx(simulated.theta[1], abs=1e-3)


def test_a_loop_at_any_rate_is_shown_at_most_60_times_a_second(viewer: Viewer) -> None:
    shown: list[float] = []
    publish = viewer._server.publish
    viewer._server.publish = lambda: (shown.append(time.monotonic()), publish())[1]  # type: ignore[func-returns-value,method-assign]
    start = time.monotonic()
    for i in range(600):
        viewer.show([i / 1000, 0.0])
        viewer.show_servo(answer(ServoStatus.OK, None, str(i)))
        time.sleep(0.001)
    took = time.monotonic() - start
    assert len(shown) <= 61 * took + 2
    assert viewer.theta[0] == 0.599  # the last is never lost
    assert viewer._server.ask(lambda stage: stage.servo()["reason"]) == "599"


def test_what_was_posted_last_is_there_after_closing() -> None:
    viewer = Viewer(ARM, open_browser=False)
    for i in range(10):
        viewer.show([i / 10, 0.0])
    viewer.close()
    assert viewer.theta[0] == 0.9
