"""However a stream ends, the arm is brought to rest along its limits; and the faults that a stream could hide."""

from contextlib import nullcontext
from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from stream_stand_ins import PERIOD, Robot, Says, jog
from twistarm.control.servo import servo_step
from twistarm.control.stream import Ending, Measured, Metronome, Reading
from twistarm.support.errors import InputError

BRAKING = 0.4 / 2.5  # Seconds from 0.4 rad/s to rest at the elbow's 2.5 rad/s².

EXACT = 1 + 1e-6


def brakes(rover, robot):
    """Whether the arm kept its limits until the last setpoint, which has rates of 0."""
    return robot.hardest(rover) <= EXACT and not robot.rates[-1].any()


def raising(error, moment):
    def on_cycle(cycle):
        if cycle.time >= moment:
            raise error

    return on_cycle


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_ctrl_c_and_an_error_of_the_callback_end_it_once_the_arm_stands(rover, robot, stream, error):
    with nullcontext() if error is KeyboardInterrupt else pytest.raises(error):
        report = stream(on_cycle=raising(error, 101.0))
        assert (report.ending, report.ok) == (Ending.INTERRUPTED, True)
    assert brakes(rover, robot)
    assert robot.times[-1] == pytest.approx(101.0 + BRAKING, abs=3 * PERIOD)


def test_ctrl_c_again_stops_at_once(robot, clock, stream):
    sleep = clock.sleep_until

    def impatient(moment):
        if clock.now() > 101.05:
            raise KeyboardInterrupt
        sleep(moment)

    clock.sleep_until = impatient
    report = stream(on_cycle=raising(KeyboardInterrupt, 101.0))
    assert (report.ending, report.at_rest, report.ok) == (Ending.INTERRUPTED, False, False)
    assert robot.rates[-2].any()
    assert not robot.rates[-1].any()


@pytest.mark.parametrize(("device", "ending"), [("source", Ending.SOURCE_FAILED), ("feedback", Ending.FEEDBACK_FAILED)])
def test_a_device_that_fails(rover, robot, stream, device, ending):
    healthy = {"source": Says(jog(rover, elbow=-0.4)), "feedback": robot}[device]

    class Unplugged:
        def read(self, now, *state):
            if now >= 101.0:
                raise OSError("the bus is gone")
            return healthy.read(now, *state)

    report = stream(**{device: Unplugged()})
    assert (report.ending, report.reason, report.at_rest) == (ending, "OSError: the bus is gone", True)
    assert brakes(rover, robot)


def test_a_failing_sink_is_tried_until_the_arm_stands(robot, stream):
    robot.broken = lambda now: ConnectionRefusedError("nobody listens") if now >= 101.0 else None
    report = stream()
    assert (report.ending, report.at_rest, report.delivered, report.ok) == (Ending.SINK_FAILED, True, False, False)
    assert report.reason == "ConnectionRefusedError: nobody listens"
    ((failure, count),) = report.failures.items()
    assert report.reason in failure
    assert count > 10
    assert report.duration == pytest.approx(1.0 + BRAKING, abs=3 * PERIOD)


@pytest.mark.parametrize("error", [OSError("busy"), ValueError("no JSON")])
def test_a_sink_that_fails_once_hears_the_braking(rover, robot, stream, error):
    robot.broken = lambda now: error if 101.0 <= now < 101.0 + 0.5 * PERIOD else None
    with nullcontext() if isinstance(error, OSError) else pytest.raises(ValueError, match="no JSON"):
        report = stream()
        assert (report.ending, report.failures) == (Ending.SINK_FAILED, {})
    assert brakes(rover, robot)
    assert robot.times[-1] >= 101.0 + BRAKING - 2 * PERIOD


@pytest.mark.parametrize(("name", "steps"), [("theta", 1), ("theta_dot", 1), ("theta", 10**6)])
def test_a_setpoint_that_is_not_finite_is_never_sent_and_the_arm_brakes(rover, robot, stream, monkeypatch, name, steps):
    """A servo that answers NaN from its 101st step on: once, or for good, where the arm is stopped at once."""
    count = 0

    def wrong(arm, state, command, dt, *, settings, scene=None):
        nonlocal count
        count += 1
        state, output = servo_step(arm, state, command, dt, settings=settings)
        if not 101 <= count < 101 + steps:
            return state, output
        nans = {name: np.full(arm.n, np.nan)}
        return (replace(state, **nans), output) if name == "theta" else (state, replace(output, **nans))

    for module in ("streaming", "cycles"):
        monkeypatch.setattr(f"twistarm.control.stream.{module}.servo_step", wrong)
    report = stream()
    assert (report.ending, report.ok, report.at_rest) == (Ending.SERVO_FAILED, False, True)
    assert "not finite" in report.reason
    assert all(np.isfinite([setpoint.theta, setpoint.theta_dot]).all() for setpoint in robot.setpoints)
    assert not robot.rates[-1].any()
    assert (robot.hardest(rover) <= EXACT) == (steps == 1)
    if steps > 1:
        assert np.array_equal(robot.setpoints[-1].theta, robot.setpoints[-2].theta)
        assert len(report.failures) == 1


@pytest.mark.parametrize("rate", [-0.4, 0.0])
def test_the_last_setpoint_says_that_the_stream_has_ended(rover, robot, stream, rate):
    """Rates of 0 once more where the arm stands, braked or never moved."""
    stream(Says(jog(rover, elbow=rate)), duration=1.0)
    *_, before, last = robot.setpoints
    assert not last.theta_dot.any()
    assert not last.output.theta_dot.any()
    assert np.array_equal(last.theta, before.theta)
    assert (last.output.status, last.number) == ("STALE", before.number + 1)


# -- time ----------------------------------------------------------------------------------------------------------


def test_time_that_goes_back_brakes(robot, clock, stream):
    seen = []

    def back(cycle):
        seen.append(cycle)
        if len(seen) == 100:
            clock.time -= 30.0
            robot.heard = clock.time

    report = stream(on_cycle=back, duration=0.99 + 30.0, until=lambda: len(seen) >= 150)
    assert np.abs(seen[100].setpoint.theta_dot).max() < np.abs(seen[99].setpoint.theta_dot).max()
    assert seen[-1].setpoint.theta_dot.any()
    assert report.ending is Ending.DONE
    assert not robot.rates[-1].any()


@pytest.mark.parametrize("stall", [0.1 + PERIOD, 5.0])
def test_after_a_stall_the_rates_change_by_no_more_than_one_period_allows(rover, robot, clock, stream, stall):
    """Longer than the servo's longest step, 0.1 s."""
    clock.late = {100: stall}
    report = stream(duration=2.0 + stall)
    at = int(np.argmax(np.diff(robot.times)))
    assert robot.times[at + 1] - robot.times[at] == pytest.approx(stall + PERIOD)
    assert np.abs(robot.rates[at]).max() == pytest.approx(0.4)
    assert (np.abs(np.diff(robot.rates, axis=0)) <= rover.limits.acceleration * PERIOD * EXACT).all()
    assert 0.0 < np.abs(robot.rates[at + 1]).max() < 0.4  # it brakes, and not at once
    assert np.abs(robot.setpoints[at + 1].theta - robot.setpoints[at].theta).max() <= 0.4 * PERIOD
    assert report.missed == pytest.approx(stall / PERIOD, abs=1)
    assert report.ok


def test_an_arm_whose_joint_states_come_from_the_future_is_brought_to_rest(rover, clock, stream):
    class Set(Robot):
        """Its clock is set 1 h ahead at 100.5 s, and nothing moves it from then on."""

        def read(self, now):
            return Measured(self.theta, now if now < 100.5 else now + 3600.0)

    robot = Set(rover.ready, clock)
    robot.deaf = lambda now: now >= 100.5
    report = stream(sink=robot)
    assert robot.moving(100.0) <= 0.5 + BRAKING + 2 * PERIOD
    assert "3.6e+03 s" in report.blind_reason
    assert brakes(rover, robot)


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
    for k in range(200):
        assert metronome.tick(5.0 + (k + (0.2, 0.0, -0.2)[k % 3]) * PERIOD) == 1


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

    with pytest.raises(InputError, match="clock") if wrong is nan else nullcontext():
        assert not stream(duration=None, on_cycle=on_cycle).ok
    assert robot.rates[-2].any()
    assert not robot.rates[-1].any()


# -- rates alone, and the state that sources are given -------------------------------------------------------------


class Creeping(Robot):
    """Moves 10 % more than it is told, and remembers where it was."""

    def write(self, setpoint):
        self.setpoints.append(setpoint)
        self.theta = self.theta + 1.1 * PERIOD * setpoint.theta_dot
        self.been = [*getattr(self, "been", []), (setpoint.time, self.theta)]


WAIT = 0.3  # A feedback_timeout [s].


@pytest.mark.parametrize("begin", [101.0, 103.0])
def test_in_velocity_mode_the_setpoint_stays_put_for_a_timeout_at_rest(rover, clock, stream, begin):
    """And then it is the measured state; the wait counts anew each time the arm was let go."""

    def there_and_pause(now):
        return jog(rover, wrist_roll=0.5) if (now - 100.0) % 2.0 < 1.0 else None

    robot = Creeping(rover.ready, clock)
    stream(Says(there_and_pause), robot, duration=4.0, velocity_mode=True, feedback_timeout=WAIT)
    pause = [s for s in robot.setpoints if begin <= s.time < begin + 1.0 - 1e-6 and not s.theta_dot.any()]
    stood = pause[0].time
    still = [s.theta for s in pause if s.time <= stood + WAIT - PERIOD / 2]
    after = [s.theta for s in pause if s.time >= stood + WAIT + 1.5 * PERIOD]
    assert len(still) == pytest.approx(WAIT / PERIOD, abs=1)
    assert len(after) > 20
    assert np.ptp(still, axis=0).max() == np.ptp(after, axis=0).max() == 0.0
    assert np.array_equal(after[0], next(theta for time, theta in robot.been if time >= stood + WAIT))
    assert not np.array_equal(after[0], still[0])  # else it would not be seen


def test_in_velocity_mode_an_arm_that_is_commanded_to_rest_is_not_read_back(rover, clock, stream):
    source = Says(lambda now: jog(rover, wrist_roll=0.5 if now < 101.0 else 0.0))
    robot = Creeping(rover.ready, clock)
    stream(source, robot, duration=3.0, velocity_mode=True, feedback_timeout=WAIT)
    resting = [s.theta for s in robot.setpoints if s.time > 101.5]
    assert np.ptp(resting, axis=0).max() == 0.0
    assert 1e-4 < np.abs(robot.theta - resting[0]).max() < 4e-3  # led there, and else it would not be seen


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
