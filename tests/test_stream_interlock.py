"""Enable, stop and emergency stop: the arm comes to rest along its limits, and only who may lets it move again."""

from __future__ import annotations

import numpy as np
import pytest

from stream_stand_ins import PERIOD
from stream_stand_ins import clock as clock
from stream_stand_ins import robot as robot
from stream_stand_ins import stream as stream
from twistarm.errors import InputError
from twistarm.stream import Interlock


def test_an_emergency_stop_is_latched_until_cleared_and_enabled():
    interlock = Interlock()
    assert (interlock.word, interlock.reason, interlock.allows_motion) == ("enabled", "", True)
    interlock.emergency_stop("the mushroom\nbutton")
    interlock.emergency_stop("again")
    interlock.stop("later")
    assert not interlock.enable()
    assert (interlock.word, interlock.allows_motion) == ("emergency stop", False)
    assert interlock.reason.startswith("the mushroom")
    assert "\n" not in interlock.reason
    interlock.clear()
    assert (interlock.word, interlock.allows_motion) == ("stopped", False)
    assert interlock.enable()
    interlock.clear()
    assert interlock.allows_motion
    assert not Interlock(enabled=False).allows_motion


@pytest.mark.parametrize("how", ["stop", "emergency_stop"])
def test_what_is_stopped_brakes_along_the_limits_and_stands_until_enabled(rover, robot, stream, how):
    """Half a second of motion, half a second stopped, then cleared and, a little later, enabled."""
    interlock, seen = Interlock(), []
    at = {50: lambda: getattr(interlock, how)("by hand"), 100: interlock.clear, 110: interlock.enable}

    def on_cycle(cycle):
        seen.append(cycle)
        at.get(len(seen), lambda: None)()

    report = stream(on_cycle=on_cycle, interlock=interlock, duration=1.5)
    elbow = robot.rates[:, rover.joint_names.index("elbow")]
    assert elbow[45:50] == pytest.approx(-0.4)
    assert abs(np.diff(elbow)).max() <= 2.5 * PERIOD * (1 + 1e-9)
    assert not elbow[50 + round(0.4 / 2.5 / PERIOD) + 1 : 110].any()
    assert elbow[130:149] == pytest.approx(-0.4)
    word = {"stop": "stopped", "emergency_stop": "emergency stop"}[how]
    assert (seen[60].interlock, seen[60].setpoint.interlock) == (word, word)
    assert seen[60].reason == f"{word}: by hand"
    assert seen[60].setpoint.output.status.name == "STALE"
    assert report.ok
    assert report.barred == pytest.approx(0.6, abs=0.011)
    assert report.interlock == "enabled"
    assert "was not allowed to move for 0.6" in report.explain()


def test_an_arm_that_is_not_enabled_never_moves(robot, stream):
    report = stream(interlock=Interlock(enabled=False))
    assert not robot.rates.any()
    assert report.barred_reason == "stopped: it waits to be enabled"


def test_what_is_no_interlock_is_refused(stream):
    with pytest.raises(InputError, match="interlock must be"):
        stream(interlock=True)
