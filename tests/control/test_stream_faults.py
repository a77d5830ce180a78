"""Faults that a stream could hide: jumps after a stall, a grid that drifts, setpoints that follow the measurement."""

from __future__ import annotations

from contextlib import nullcontext
from math import inf, nan

import numpy as np
import pytest

from stream_stand_ins import PERIOD, Robot, Says, jog
from twistarm.control.stream import Measured, Metronome, Reading
from twistarm.support.errors import InputError

LONGEST_DT = 0.1
"""Seconds of the servo's longest step where nothing else is set."""


def changes(rover, robot):
    """|change of rates| from one setpoint to the next, in what the acceleration limits allow in a period."""
    return np.abs(np.diff(robot.rates, axis=0)) / (rover.limits.acceleration * PERIOD)


# A cycle that comes late


@pytest.mark.parametrize("stall", [LONGEST_DT + PERIOD, 5.0])
def test_after_a_stall_the_rates_change_by_no_more_than_one_period_allows(rover, robot, clock, stream, stall):
    clock.late, seen = {100: stall}, []
    report = stream(duration=2.0 + stall, on_cycle=seen.append)
    at = int(np.argmax(np.diff(robot.times)))
    assert robot.times[at + 1] - robot.times[at] == pytest.approx(stall + PERIOD)
    assert np.abs(robot.rates[at]).max() == pytest.approx(0.4)
    assert changes(rover, robot).max() <= 1 + 1e-9
    assert 0.0 < np.abs(robot.rates[at + 1]).max() < 0.4  # it brakes, and not at once
    assert np.abs(robot.setpoints[at + 1].theta - robot.setpoints[at].theta).max() <= 0.4 * PERIOD
    assert any("since the last cycle (longest step 0.1 s)" in cycle.reason for cycle in seen)
    assert report.missed == pytest.approx(stall / PERIOD, abs=1)
    assert report.ok


# Rates alone: when the measurement counts again


class Creeping(Robot):
    """Moves 10 % more than it is told, and remembers where it was."""

    def write(self, setpoint):
        self.setpoints.append(setpoint)
        self.theta = self.theta + 1.1 * PERIOD * setpoint.theta_dot
        self.been = [*getattr(self, "been", []), (setpoint.time, self.theta)]


WAIT = 0.3
"""A feedback_timeout [s]."""


@pytest.mark.parametrize("begin", [0.0, 2.0])
def test_in_velocity_mode_the_setpoint_stays_put_for_a_timeout_at_rest(rover, clock, stream, begin):
    """And then it is the measured state; the wait counts anew each time the arm was let go."""

    def there_and_pause(now):
        return jog(rover, wrist_roll=0.5) if (now - 100.0) % 2.0 < 1.0 else None

    robot = Creeping(rover.ready, clock)
    stream(Says(there_and_pause), robot, duration=4.0, velocity_mode=True, feedback_timeout=WAIT)
    pause = [s for s in robot.setpoints if 101.0 + begin <= s.time < 102.0 + begin - 1e-6 and not s.theta_dot.any()]
    stood = pause[0].time
    still = [s.theta for s in pause if s.time <= stood + WAIT - PERIOD / 2]
    after = [s.theta for s in pause if s.time >= stood + WAIT + 1.5 * PERIOD]
    assert len(still) == pytest.approx(WAIT / PERIOD, abs=1)
    assert np.array_equal(still, np.tile(still[0], (len(still), 1)))
    assert len(after) > 20
    assert np.ptp(after, axis=0).max() == 0.0
    stands = next(theta for time, theta in robot.been if time >= stood + WAIT)
    assert np.array_equal(after, np.tile(stands, (len(after), 1)))
    assert not np.array_equal(after[0], still[0])  # else it would not be seen


def test_in_velocity_mode_an_arm_that_is_told_to_stand_is_not_read_back(rover, clock, stream):
    def there_and_stand(now):
        return jog(rover, wrist_roll=0.5 if now < 101.0 else 0.0)

    robot = Creeping(rover.ready, clock)
    stream(Says(there_and_stand), robot, duration=3.0, velocity_mode=True, feedback_timeout=WAIT)
    standing = [s.theta for s in robot.setpoints if s.time > 101.5]
    assert np.array_equal(standing, np.tile(standing[0], (len(standing), 1)))
    assert 1e-4 < np.abs(robot.theta - standing[0]).max() < 4e-3  # led there, and else it would not be seen


# Joint states from another time


def test_an_arm_whose_joint_states_come_from_the_future_is_brought_to_rest(rover, clock, stream):
    class Set(Robot):
        """Its clock is set 1 h ahead at 100.5 s, and nothing moves it from then on."""

        def read(self, now):
            return Measured(self.theta, now if now < 100.5 else now + 3600.0)

    robot = Set(rover.ready, clock)
    robot.deaf = lambda now: now >= 100.5
    report = stream(sink=robot)
    assert robot.moving(100.0) <= 0.5 + 0.16 + 2 * PERIOD  # 0.4 rad/s at 2.5 rad/s²
    assert "from the future" in report.blind_reason
    assert changes(rover, robot).max() <= 1 + 1e-9


# The grid of time


def test_late_and_missed_ticks_do_not_shift_the_grid():
    metronome = Metronome(PERIOD)
    assert metronome.tick(5.0) == 1
    for k in range(1, 1000):
        late = (0.0, 0.3, 0.9, 0.6)[k % 4] * PERIOD
        assert metronome.tick(5.0 + k * PERIOD + late) == 1
        assert metronome.next == pytest.approx(5.0 + (k + 1) * PERIOD, abs=1e-9)
    assert metronome.tick(5.0 + 1006.4 * PERIOD) == 7
    assert metronome.next == pytest.approx(5.0 + 1007 * PERIOD, abs=1e-9)


def test_a_first_tick_that_came_late_is_made_good_by_one_in_time():
    """A timer of others, whose first call was late by 0.2 periods and whose others swing by 0.2 about their times."""
    metronome = Metronome(PERIOD, early=0.25)
    assert metronome.tick(5.0 + 0.2 * PERIOD) == 1
    assert metronome.tick(5.0 + 1.0 * PERIOD) == 1
    assert metronome.next == pytest.approx(5.0 + 2 * PERIOD, abs=1e-9)
    for k in range(2, 200):
        assert metronome.tick(5.0 + (k + (-0.2, 0.2, 0.0)[k % 3]) * PERIOD) == 1


def test_a_clock_that_always_oversleeps_loses_no_cycle(robot, clock, stream):
    clock.late = dict.fromkeys(range(1, 1000), 0.3 * PERIOD)
    report = stream(Says(None))
    assert (report.cycles, report.missed) == (200, 0)
    assert np.diff(robot.times[1:200]) == pytest.approx(PERIOD)
    assert report.late_max == pytest.approx(0.3 * PERIOD)


@pytest.mark.parametrize("wrong", [nan, inf])
def test_a_clock_that_breaks_ends_the_stream_with_rates_of_0(robot, clock, stream, wrong):
    def on_cycle(cycle):
        if cycle.time >= 101.0:
            clock.time = wrong

    with pytest.raises(InputError, match="seconds of a clock") if wrong is nan else nullcontext():
        assert not stream(duration=None, on_cycle=on_cycle).ok
    assert robot.rates[-2].any()
    assert not robot.rates[-1].any()


# What sources are given, and what is left of a deviation


def test_a_source_is_given_where_the_commanded_arm_is(rover, robot, stream):
    """None before it is known, then the state that the last setpoint led to."""
    given = []

    class Curious:
        def read(self, now, state):
            given.append((state, robot.setpoints[-1] if robot.setpoints else None))
            return Reading(jog(rover, elbow=-0.4), 0.0)

    read = robot.read
    robot.read = lambda now: read(now) if now > 100.05 else None
    stream(Curious(), duration=0.5)
    assert [state is None for state, _ in given] == [True] * 6 + [False] * (len(given) - 6)
    first, *others = given[6:]
    assert np.array_equal(first[0].theta, rover.ready)
    for state, setpoint in others:
        assert np.array_equal(state.theta, setpoint.theta)
        assert np.array_equal(state.theta_dot, setpoint.theta_dot)


# How each stream ends, and who commands


@pytest.mark.parametrize("rate", [-0.4, 0.0])
def test_the_last_setpoint_says_that_the_stream_has_ended(rover, robot, stream, rate):
    """Rates of 0 once more where the arm stands, braked or never moved."""
    stream(Says(jog(rover, elbow=rate)), duration=1.0)
    *_, before, last = robot.setpoints
    assert not last.theta_dot.any()
    assert not last.output.theta_dot.any()
    assert np.array_equal(last.theta, before.theta)
    assert last.output.explain() == "the stream has ended"
    assert last.number == before.number + 1
