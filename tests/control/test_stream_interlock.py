"""Enable, stop and emergency stop: the arm comes to rest along its limits, and only who may lets it move again."""

import json
import socket

import numpy as np
import pytest

from stream_stand_ins import PERIOD, Says, jog
from twistarm.control.servo import JogCommand, PoseCommand, TwistCommand
from twistarm.control.stream import Interlock, UdpFeedback, UdpSource
from twistarm.control.stream.streaming import RELEASE_FIRST


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


class Acting:
    """A callback that acts after some cycles, by their number, and keeps all cycles."""

    def __init__(self, actions):
        self.actions, self.cycles = actions, []

    def __call__(self, cycle):
        self.cycles.append(cycle)
        self.actions.get(self.count, lambda: None)()

    @property
    def count(self):
        return len(self.cycles)


@pytest.mark.parametrize(("how", "word"), [("stop", "stopped"), ("emergency_stop", "emergency stop")])
def test_what_is_stopped_brakes_along_the_limits_and_stands_until_enabled(rover, robot, stream, how, word):
    """Half a second of motion, half a second stopped, then cleared and, a little later, enabled."""
    interlock = Interlock()
    act = Acting({50: lambda: getattr(interlock, how)("by hand"), 100: interlock.clear, 110: interlock.enable})
    source = Says(lambda now: jog(rover, elbow=-0.4) if act.count < 50 or act.count > 110 else None)
    report = stream(source, on_cycle=act, interlock=interlock, duration=1.5)
    elbow = robot.rates[:, rover.joint_names.index("elbow")]
    assert robot.hardest(rover) <= 1 + 1e-9
    assert [elbow[45:50], elbow[130:149]] == [pytest.approx(-0.4)] * 2
    assert not elbow[50 + round(0.4 / 2.5 / PERIOD) + 1 : 110].any()
    seen = act.cycles[60]
    assert (seen.interlock, seen.setpoint.interlock, seen.setpoint.output.status) == (word, word, "STALE")
    assert seen.reason == f"{word}: by hand"
    assert report.ok
    assert report.barred == pytest.approx(0.6, abs=0.011)
    assert report.interlock == "enabled"


@pytest.mark.parametrize(
    ("held", "began", "release"),
    [
        ("jog", "stopped", None),
        ("pose", "enabled", JogCommand(np.zeros(5))),
        ("jog", "enabled", TwistCommand(np.zeros(6))),
    ],
)
def test_a_held_control_moves_nothing_until_it_is_released(rover, robot, stream, began, release, held):
    """Stopped in an emergency, cleared and enabled under a constant command, which then pauses for one cycle."""
    interlock = Interlock(enabled=began == "enabled")
    g = rover.fk(rover.ready) + np.outer([0, 0, 0.05, 0], [0, 0, 0, 1])
    command = {"jog": jog(rover, elbow=-0.4), "pose": PoseCommand(g)}[held]
    act = Acting({20: interlock.emergency_stop, 70: interlock.clear, 71: interlock.enable})
    stream(Says(lambda now: release if act.count == 120 else command), interlock=interlock, on_cycle=act)
    assert robot.rates[:20].any() == (began == "enabled")
    assert not robot.rates[65:121].any()
    assert all(cycle.reason == RELEASE_FIRST for cycle in act.cycles[71:120])
    assert robot.rates[122:140].any()


def test_controls_released_while_stopped_count_at_once(rover, robot, stream):
    interlock = Interlock(enabled=False)
    act = Acting({50: interlock.enable})
    source = Says(lambda now: jog(rover, elbow=-0.4) if act.count >= 50 else None)
    report = stream(source, interlock=interlock, on_cycle=act)
    assert not robot.rates[:50].any()
    assert robot.rates[50].any()
    assert report.barred == pytest.approx(0.5)


@pytest.fixture
def send():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
        yield lambda device, message: out.sendto(json.dumps(message).encode(), device.address)


def test_an_emergency_stop_counts_whatever_came_with_it(rover, robot, stream, send):
    """In one cycle: the word, then the stick's next command, which is newer. Then enable alone, which is not enough.

    The stick is released for a cycle once it is enabled, and not before.
    """
    jogged = {"jog": {"elbow": -0.4}}
    with UdpSource(rover) as source:
        says = {
            30: [{"interlock": "emergency stop", "reason": "marshal", "number": 0}, jogged | {"number": 9}],
            60: [{"interlock": "enable"}],
            90: [{"interlock": "clear"}, {"interlock": "enable"}],
            110: [{"jog": {"elbow": 0.0}}],
        }
        count = iter(range(10_000))

        def on_cycle(cycle):
            for message in says.get(next(count), [jogged]):
                send(source, message)

        interlock = Interlock()
        report = stream(source, on_cycle=on_cycle, interlock=interlock, duration=1.5)
    assert robot.rates[29].any()
    assert not robot.rates[55:110].any()
    assert robot.rates[120:140].any()
    assert report.barred_reason == "emergency stop: marshal"
    assert source.interlock is interlock


def test_a_word_that_waited_too_long_stops_and_does_not_enable(rover, send):
    with UdpSource(rover) as source:
        source.interlock.stop()
        source.read(0.0)
        send(source, {"interlock": "enable"})
        source.read(10.0)
        assert source.interlock.word == "stopped"
        send(source, {"interlock": "emergency stop"})
        source.read(20.0)
        assert source.interlock.word == "emergency stop"


def test_a_robot_in_emergency_stop_stops_the_stream_for_good(rover, robot, stream, send):
    with UdpFeedback(rover) as feedback:

        class Reporting:
            interlock = Interlock()

            def read(self, now):
                word = "emergency stop" if 100.5 <= now < 100.6 else "enabled"
                state = {"joint_names": list(rover.joint_names), "theta": robot.theta.tolist(), "interlock": word}
                feedback.interlock = self.interlock
                send(feedback, state)
                return feedback.read(now)

        report = stream(Says(jog(rover, elbow=-0.4)), feedback=Reporting(), duration=1.5)
    assert robot.rates[40].any()
    assert not robot.rates[-50:].any()
    assert report.interlock == "emergency stop"
    assert report.barred_reason == "emergency stop: the robot is in emergency stop"
