"""However a stream ends, the arm is brought to rest along its limits, and it is said why."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from stream_stand_ins import PERIOD, Says, jog
from twistarm.control.servo import servo_step
from twistarm.control.stream import Ending, Reading

BRAKING = 0.4 / 2.5
"""Seconds from 0.4 rad/s to rest at the elbow's 2.5 rad/s²."""


def at_rest_along_the_limits(rover, robot, began):
    """Whether the arm braked from `began` [s] on within its limits, until the last setpoint had rates of 0."""
    elbow = robot.rates[robot.times >= began - 1e-9, rover.joint_names.index("elbow")]
    return abs(np.diff(elbow)).max() <= 2.5 * PERIOD * (1 + 1e-9) and not robot.rates[-1].any()


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
    assert at_rest_along_the_limits(rover, robot, 101.0)
    assert robot.times[-1] == pytest.approx(101.0 + BRAKING, abs=3 * PERIOD)


def test_ctrl_c_again_stops_at_once(robot, clock, stream):
    sleep = clock.sleep_until

    def impatient(moment):
        if clock.now() > 101.05:
            raise KeyboardInterrupt
        sleep(moment)

    clock.sleep_until = impatient
    report = stream(on_cycle=raising(KeyboardInterrupt, 101.0))
    assert report.ending is Ending.INTERRUPTED
    assert not report.at_rest
    assert not report.ok
    assert "stopped at once" in report.explain()
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
    assert at_rest_along_the_limits(rover, robot, 101.0)


def test_a_failing_sink_is_tried_until_the_arm_stands(robot, stream):
    robot.broken = lambda now: ConnectionRefusedError("nobody listens") if now >= 101.0 else None
    report = stream()
    assert report.ending is Ending.SINK_FAILED
    assert report.reason == "ConnectionRefusedError: nobody listens"
    assert report.at_rest
    assert not report.ok
    (failure,) = report.failures
    assert failure == "the sink failed: ConnectionRefusedError: nobody listens"
    assert report.failures[failure] > 10
    assert report.duration == pytest.approx(1.0 + BRAKING, abs=3 * PERIOD)
    assert "the sink failed" in report.explain()
    assert report.explain().endswith("at the end: commanded to rest; the last setpoint did not get through")


@pytest.mark.parametrize("error", [OSError("busy"), ValueError("no JSON")])
def test_a_sink_that_fails_once_hears_the_braking(rover, robot, stream, error):
    robot.broken = lambda now: error if 101.0 <= now < 101.0 + 0.5 * PERIOD else None
    if isinstance(error, OSError):
        report = stream()
        assert (report.ending, report.failures) == (Ending.SINK_FAILED, {})
    else:
        with pytest.raises(ValueError, match="no JSON"):
            stream()
    assert at_rest_along_the_limits(rover, robot, 101.0 + PERIOD)
    assert robot.times[-1] >= 101.0 + BRAKING - 2 * PERIOD


class Wrong:
    """The servo, that says NaN from its `first` step on, for so many steps."""

    def __init__(self, monkeypatch, first, steps, name):
        self.count, self.first, self.steps, self.name = 0, first, steps, name
        for module in ("streaming", "cycles"):
            monkeypatch.setattr(f"twistarm.control.stream.{module}.servo_step", self)

    def __call__(self, arm, state, command, dt, *, settings, scene=None):
        self.count += 1
        state, output = servo_step(arm, state, command, dt, settings=settings)
        if not self.first <= self.count < self.first + self.steps:
            return state, output
        nans = {self.name: np.full(arm.n, np.nan)}
        return (replace(state, **nans), output) if self.name == "theta" else (state, replace(output, **nans))


@pytest.mark.parametrize("name", ["theta", "theta_dot"])
def test_a_setpoint_that_is_not_finite_is_never_sent_and_the_arm_brakes(rover, robot, stream, monkeypatch, name):
    Wrong(monkeypatch, 101, 1, name)
    report = stream()
    assert (report.ending, report.ok) == (Ending.SERVO_FAILED, False)
    assert "not finite" in report.reason
    assert all(np.isfinite([setpoint.theta, setpoint.theta_dot]).all() for setpoint in robot.setpoints)
    assert at_rest_along_the_limits(rover, robot, 101.0)
    assert report.at_rest


def test_a_servo_that_says_nothing_else_stops_the_arm_at_once(rover, robot, stream, monkeypatch):
    Wrong(monkeypatch, 101, 10**6, "theta")
    report = stream()
    assert report.ending is Ending.SERVO_FAILED
    assert robot.rates[-2].any()
    assert not robot.rates[-1].any()
    assert np.array_equal(robot.setpoints[-1].theta, robot.setpoints[-2].theta)
    (failure,) = report.failures
    assert failure.startswith("the servo failed, and the arm was stopped at once: its setpoint is not finite")


def test_time_that_goes_back_brakes(rover, robot, clock, stream):
    seen = []

    def back(cycle):
        seen.append(cycle)
        if len(seen) == 100:
            clock.time -= 30.0
            robot.heard = clock.time

    report = stream(on_cycle=back, duration=0.99 + 30.0, until=lambda: len(seen) >= 150)
    assert seen[100].reason == "time went back"
    assert np.abs(seen[100].setpoint.theta_dot).max() < np.abs(seen[99].setpoint.theta_dot).max()
    assert seen[-1].setpoint.theta_dot.any()
    assert report.ending is Ending.DONE
    assert not robot.rates[-1].any()


@pytest.mark.parametrize("age", [np.nan, -1.0, np.inf])
def test_an_age_that_cannot_be_is_too_old(rover, robot, stream, age):
    class Ageless:
        def read(self, now, state):
            return Reading(jog(rover, elbow=-0.4), age)

    stream(Ageless(), duration=0.2)
    assert not robot.rates.any()
