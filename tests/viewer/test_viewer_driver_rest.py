"""When a drive may end, and whether one may begin, without a loop: clocks and joints of the test's own."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from twistarm import Arm, ArmBuilder
from twistarm.control.stream import Inbox
from twistarm.support.errors import InputError
from twistarm.viewer.parts.commands import PageCommands
from twistarm.viewer.server.driver import Drive, Driver
from twistarm.viewer.stage import Stage

JOG = {"twist": [0.1, 0, 0, 0, 0, 0], "frame": "base"}


def arm() -> Arm:
    return ArmBuilder("one").revolute("a", [0, 0, 1], [0, 0, 0], lower=-3, upper=3).tool(np.eye(4)).build()


def drive(rate: float) -> Drive:
    """One whose joint moves at `rate` [rad/s], braked or not."""
    begun = Drive(Stage(arm()), Inbox(), lambda key, change: None, lambda ended: None)
    joints: Any = SimpleNamespace(theta=np.zeros(1), theta_dot=np.array([rate]))
    begun._joints = joints
    return begun


@pytest.mark.parametrize(("since", "rate", "ended"), [
    (0.0, 0.0, True), (0.0, 1e-3, False), (2.5, 1e-3, False), (3.1, 1e-3, True), (3.1, -2.0, True)
])  # fmt: skip
def test_it_ends_at_rest_or_three_seconds_after_it_was_asked_to(since: float, rate: float, ended: bool) -> None:
    braking = drive(rate)
    braking.end()
    braking.asked_at -= since
    assert braking._done() is ended


def test_asked_again_it_does_not_wait_anew_and_unasked_it_goes_on() -> None:
    braking = drive(1e-3)
    assert not braking._done()
    braking.asked_at = time.monotonic() - 3.1
    braking.end()
    assert braking._done()
    assert not drive(0.0)._done()


def test_none_begins_once_the_program_has_asked_for_commands() -> None:
    """Before the stage has heard of it: that comes by way of the loop."""
    stage = Stage(arm())
    commands = PageCommands(stage.arm)
    driver = Driver(stage, commands, lambda key, change: None)
    commands.open = True
    with pytest.raises(InputError, match="a servo of the program drives one: Drive is free once it has ended"):
        driver.switch(True)
    assert not stage.driven
    assert not driver.on
