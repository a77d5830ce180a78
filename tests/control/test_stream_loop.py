"""The loop on a clock that the tests move: it starts where the arm is, watches, and leaves the arm at rest."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from stream_stand_ins import PERIOD, FakeClock, Robot, Says, jog
from twistarm import plan_joint
from twistarm.control.servo import ServoSettings, TwistCommand
from twistarm.control.stream import (
    Cycle,
    Ending,
    FollowOptions,
    Inbox,
    Measured,
    Metronome,
    Reading,
    Streaming,
    come_to_rest,
    follow,
)
from twistarm.support.errors import InputError

EXACT = 1 + 1e-6


def test_a_jog_goes_on_for_the_time_and_ends_at_rest(rover, clock, robot, stream):
    report = stream()
    assert report.ending is Ending.DURATION
    assert report.ok
    assert report.cycles == 200
    assert report.missed == 0
    assert report.late_max == pytest.approx(0.0, abs=1e-9)
    elbow = rover.joint_names.index("elbow")
    # Up to 0.4 rad/s at 2.5 rad/s², then steady, then down again.
    assert robot.rates[:, elbow].min() == pytest.approx(-0.4)
    assert np.argmax(robot.rates[:, elbow] < -0.4 + 1e-9) + 1 == pytest.approx(0.4 / 2.5 / PERIOD, abs=1)
    assert robot.hardest(rover) <= EXACT
    assert not robot.rates[-1].any()
    assert robot.theta[elbow] - rover.ready[elbow] == pytest.approx(-0.4 * 2.0, abs=0.4 * PERIOD)


@pytest.mark.parametrize("late", [0.004, 0.03, 0.3])
def test_no_step_is_over_more_time_than_passed_however_late_its_cycle(rover, clock, robot, stream, late):
    clock.late = dict.fromkeys(range(180, 400), late)  # the last of the motion, and the way to rest
    report = stream()
    assert robot.hardest(rover) <= EXACT
    assert np.abs(robot.rates).max() == pytest.approx(0.4)
    assert not robot.rates[-1].any()
    assert report.at_rest


@pytest.mark.parametrize("moment", [99.99, 100.05, 1e6])
def test_a_stream_comes_to_rest_on_another_clock(rover, clock, robot, moment):
    """As after a simulation: its time may stand still."""
    streaming = Streaming(rover, Says(jog(rover, elbow=-0.4)), robot, robot)
    for _ in range(20):
        clock.time += PERIOD
        streaming.cycle(clock.now())
    assert np.abs(robot.rates[-1]).max() > 0.1
    system, metronome = FakeClock(moment, {1: 0.0004, 2: 0.03, 4: 0.2}), Metronome(PERIOD)
    metronome.tick(system.now())
    streaming.change_clock(system.now())
    begin = len(robot.setpoints) - 1
    assert come_to_rest(streaming, metronome, system)
    rates, times = robot.rates[begin:], np.array([moment, *robot.times[begin + 1 :]])
    assert not rates[-1].any()
    assert (np.abs(np.diff(rates, axis=0)) <= np.outer(np.diff(times), rover.limits.acceleration) * EXACT).all()


UNUSABLE = {
    "none": (lambda now: None, "no joint state"),
    "too few": (lambda now: Measured([0.0] * 4, now), "shape"),
    "too many": (lambda now: Measured([[0.0] * 5], now), "[[0.0, 0.0, 0.0, 0.0, 0.0]]"),
    "NaN": (lambda now: Measured([np.nan] * 5, now), "finite"),
    "far off": (lambda now: Measured([1e5] * 5, now), "100000.0"),
    "words": (lambda now: Measured(["x"] * 5, now), "numbers"),
    "another clock's": (lambda now: Measured([0.0] * 5, now + 0.25), "0.25 s"),
}


@pytest.mark.parametrize("case", UNUSABLE)
def test_without_a_joint_state_that_can_be_used_nothing_is_ever_sent(robot, stream, case):
    answer, why = UNUSABLE[case]
    report = stream(feedback=SimpleNamespace(read=answer), duration=0.1)
    assert robot.setpoints == []
    assert report.waited == pytest.approx(0.1)
    assert not report.ok
    assert why in report.blind_reason
    assert ("no joint state" in report.explain()) == (case == "none")


def test_a_silent_command_source_stops_the_arm_within_its_timeout(rover, clock, robot, stream):
    inbox, began = Inbox(0.2), clock.now()

    def operate(cycle):
        if cycle.time - began <= 1.0:
            inbox.put("operator", jog(rover, elbow=-0.4), cycle.time)

    cycles: list[Cycle] = []
    report = stream(inbox, on_cycle=lambda cycle: (operate(cycle), cycles.append(cycle)))
    braking = 0.4 / 2.5
    assert robot.moving(began) <= 1.0 + 0.2 + braking + 2 * PERIOD
    assert robot.hardest(rover) <= EXACT
    assert cycles[-1].setpoint.output.status == "STALE"
    assert "0.99 s old" in cycles[-1].reason
    assert report.uncommanded == pytest.approx(0.8, abs=2 * PERIOD)


@pytest.mark.parametrize("age", [np.nan, -1.0, np.inf, None])
def test_a_source_that_keeps_an_old_command_is_watched_too(rover, robot, stream, age):
    """None: since the start. Another age that cannot be is too old from there on."""
    source = SimpleNamespace(read=lambda now, state: Reading(jog(rover, elbow=-0.4), age or now - 100.0))
    stream(source, command_timeout=0.5)
    assert robot.rates.any() == (age is None)
    assert robot.moving(100.0) <= 0.5 + 0.16 + 2 * PERIOD


def test_an_old_joint_state_stops_the_arm_until_a_fresh_one(rover, clock, robot, stream):
    robot.mute = lambda now: 100.5 < now < 101.2
    seen: list[Cycle] = []
    report = stream(on_cycle=seen.append)
    resting = [cycle for cycle in seen if 100.5 + 0.2 + 0.16 + 2 * PERIOD < cycle.time < 101.2]
    assert len(resting) > 20
    assert not any(cycle.setpoint.theta_dot.any() for cycle in resting)
    assert seen[-1].setpoint.output.status == "OK"
    assert seen[-1].setpoint.theta_dot.any()
    assert robot.hardest(rover) <= EXACT
    assert report.blind == pytest.approx(0.5, abs=3 * PERIOD)
    assert report.ok


def test_a_feedback_that_loses_the_joint_state_does_not_say_that_none_arrived(robot, stream):
    feedback = SimpleNamespace(read=lambda now: robot.read(now) if now < 100.5 else None)
    report = stream(feedback=feedback, duration=1.0)
    assert report.blind == pytest.approx(0.5, abs=2 * PERIOD)
    assert "arrived" not in report.blind_reason


@pytest.mark.parametrize("moved", [[0.0, 0.18, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.5]])
def test_a_robot_that_was_off_is_commanded_from_where_it_is(rover, clock, robot, stream, moved):
    """Off for 1.5 s, and back, within the tolerance or not: no setpoint asks it to jump back."""
    robot.mute = robot.deaf = lambda now: 100.5 < now < 102.0

    def move(cycle):
        if 101.0 < cycle.time < 101.015:
            robot.theta = robot.theta + moved

    seen: list[Cycle] = []
    report = stream(duration=3.0, on_cycle=lambda cycle: (move(cycle), seen.append(cycle)))
    back = next(cycle for cycle in seen if cycle.time > 101.0 and cycle.theta is not None)
    assert back.time == pytest.approx(102.0, abs=2 * PERIOD)
    np.testing.assert_allclose(back.setpoint.theta, back.theta, atol=2.5 * PERIOD**2)
    assert robot.hardest(rover) <= EXACT
    assert report.ok


@pytest.mark.parametrize("moved", [0.1, 0.0])
@pytest.mark.parametrize("idle", [None, TwistCommand(np.zeros(6))])
def test_a_motion_begins_where_others_have_moved_the_resting_arm(rover, robot, stream, moved, idle):
    """It hangs 0.05 rad below its setpoint, which is no motion. Another program may move it; then the elbow moves."""
    robot.deaf, seen = lambda now: now < 101.0, []

    def on_cycle(cycle):
        seen.append(cycle)
        if cycle.time < 100.995:
            robot.theta = rover.ready - 0.05 + moved * np.eye(5)[1] * (cycle.time > 100.8)

    source = Says(lambda now: jog(rover, elbow=-0.4) if now >= 101.0 else idle)
    report = stream(source, duration=1.5, on_cycle=on_cycle)
    begin = next(cycle for cycle in seen if cycle.time >= 101.0)
    start = begin.theta if moved else rover.ready
    np.testing.assert_allclose(begin.setpoint.theta, start, atol=2.5 * PERIOD**2)
    assert robot.hardest(rover) <= EXACT
    assert report.ok


@pytest.mark.parametrize(("factor", "in_degrees"), [(180.0 / np.pi, True), (4000.0, False), (1.1, False)])
def test_an_arm_that_starts_beyond_its_limits_is_not_driven(rover, clock, robot, stream, factor, in_degrees):
    """Joint states in degrees, in counts or a little too large, in `run` and on the way to a motion."""
    turns = np.array(rover.units) == "rad"
    robot.theta = np.where(turns, 1.5 * factor, 0.0)
    motion = plan_joint(rover, [rover.ready, rover.ready + 0.1])
    options = FollowOptions(approach=True, tolerance=0.05)
    for report in (stream(tolerance=0.05), follow(rover, motion, robot, robot, options, clock=clock).stream):
        assert report.ending is Ending.BEYOND_LIMITS
        assert ("degrees" in report.reason) is in_degrees
        assert "no joint state" not in report.explain()
        assert not report.ok
    assert robot.setpoints == []


def test_what_is_heard_while_the_loop_waits_for_its_turn_counts(rover, robot, stream):
    """A feedback and a source whose threads stamp what they hear after the loop has read its clock."""
    source = SimpleNamespace(read=lambda now, state: Reading(jog(rover, elbow=-0.4), -0.05))
    report = stream(source, feedback=SimpleNamespace(read=lambda now: Measured(robot.theta, now + 0.05)))
    assert report.blind == report.uncommanded == report.waited == 0.0


def test_an_arm_that_does_not_follow_ends_the_stream(rover, clock, robot, stream):
    robot.deaf = lambda now: now > 100.5
    report = stream(duration=10.0)
    assert report.ending is Ending.STRAYED
    assert not report.ok
    assert "elbow is 0.2" in report.reason
    # 0.2 rad at 0.4 rad/s, and the window within which lagging behind is none.
    assert report.duration < 0.5 + 0.5 + 2 * 0.2 + 0.16 + 0.05
    assert robot.hardest(rover) <= EXACT
    assert not robot.rates[-1].any()


def test_an_arm_that_lags_behind_by_less_than_the_timeout_does_not_stray(rover, clock, stream):
    class Late(Robot):
        def read(self, now):
            past = [s.theta for s in self.setpoints if s.time <= now - 0.15]
            return Measured(past[-1] if past else rover.ready, now)

    robot = Late(rover.ready, clock)
    report = stream(Says(jog(rover, wrist_roll=3.0)), robot, robot, duration=1.0, tolerance=0.05)
    assert report.ending is Ending.DURATION


@pytest.mark.parametrize("gaps", [False, True])
def test_the_measurement_never_reaches_the_setpoints(rover, robot, stream, gaps):
    """They are integrated, not read back, also after joint states that fail to come for less than the timeout.

    An arm that hangs a little below where it is told to be would sink a little each time.
    """

    class Noisy:
        rng = np.random.default_rng(1)

        def read(self, now):
            measured = robot.read(now)
            return Measured(measured.theta - 0.05 + self.rng.normal(scale=1e-3, size=5), measured.time)

    robot.mute = lambda now: gaps and (now - 100.0) % 0.25 > 0.15
    stream(Says(TwistCommand(np.zeros(6), "base")), feedback=Noisy())
    thetas = np.array([setpoint.theta for setpoint in robot.setpoints])
    assert np.abs(thetas - thetas[0]).max() < 1e-12


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("rate", value) for value in (0.0, -1.0, np.nan, np.inf, 9.0)),
        *((name, 0.0) for name in ("duration", "command_timeout", "feedback_timeout", "tolerance")),
        ("interlock", True),
        *(("settings", value) for value in ("stop", lambda: "stop", lambda now: ServoSettings(), Says)),
    ],
)
def test_options_that_cannot_be(stream, name, value):
    with pytest.raises(InputError, match=f"{name} must be"):
        stream(**{name: value})


def test_settings_may_change_while_it_runs(rover, clock, robot, stream):
    free, narrow = ServoSettings(), ServoSettings(position_margin=1.5)  # leaves the middle of each joint's range
    elbow, change = rover.joint_names.index("elbow"), clock.now() + 1.0
    stream(Says(jog(rover, elbow=0.4)), settings=lambda: free if clock.now() < change else narrow)
    rates = robot.rates[:, elbow]
    assert rates[robot.times < change].max() == pytest.approx(0.4)
    assert not rates[robot.times > change + 0.5].any()  # it brakes at 2.5 rad/s²


def test_broken_settings_end_the_stream_with_the_arm_at_rest(clock, robot, stream):
    change = clock.now() + 1.0
    report = stream(settings=lambda: ServoSettings() if clock.now() < change else None)
    assert robot.rates.any()
    assert (report.ending, report.at_rest) == (Ending.SERVO_FAILED, True)
    assert "settings" in report.reason
    assert not robot.rates[-1].any()
