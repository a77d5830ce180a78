"""Simulated joints follow as drives do, never beyond their limits, and the same calls give the same motion."""

import numpy as np
import pytest

from stream_stand_ins import answer
from twistarm.control.stream import Setpoint, SimulatedJoints
from twistarm.support.errors import InputError


def setpoint(theta, theta_dot=0.0, time=0.0):
    theta = np.asarray(theta, dtype=float)
    rates = np.broadcast_to(theta_dot, theta.shape).astype(float)
    return Setpoint(0, time, theta, rates, answer(rates))


def history(joints, seconds, dt=0.001):
    """(theta, theta_dot) every dt."""
    rows = []
    for _ in range(round(seconds / dt)):
        joints.step(dt)
        rows.append((joints.theta, joints.theta_dot))
    return np.array([row[0] for row in rows]), np.array([row[1] for row in rows])


def test_a_far_goal_is_reached_fast_and_without_overshoot(rover, clock):
    joints = SimulatedJoints(rover, rover.ready, velocity=1.0, acceleration=4.0, clock=clock)
    goal = rover.ready + [0.0, 0.0, 0.0, 0.0, 1.0]
    joints.write(setpoint(goal))
    theta, theta_dot = history(joints, 2.0)
    # Trapezoid: 1 rad at 1 rad/s with 4 rad/s² takes 1/1 + 1/4 s; the last millimetres take a few of 1/40 s.
    there = 0.001 * (1 + np.argmax(np.abs(theta[:, 4] - goal[4]) < 1e-3))
    assert 1.25 - 0.03 < there < 1.25 + 0.2
    assert np.abs(theta_dot).max() <= 1.0 + 1e-12
    assert np.abs(np.diff(theta_dot, axis=0)).max() <= 4.0 * 0.001 + 1e-12
    assert (theta[:, 4] - goal[4]).max() < 1e-3
    assert np.allclose(theta[-1], goal, atol=1e-6)


def test_nothing_moves_before_the_latency_is_over(rover, clock):
    joints = SimulatedJoints(rover, rover.ready, latency=0.05, clock=clock)
    joints.write(setpoint(rover.ready + 0.1))
    joints.step(0.05)
    assert np.array_equal(joints.theta, rover.ready)
    joints.step(0.005)
    assert (joints.theta > rover.ready).all()


def test_joints_stop_at_their_hard_stops(rover, clock):
    joints = SimulatedJoints(rover, rover.ready, clock=clock)
    joints.write(setpoint(rover.limits.upper + 1.0))
    theta, _ = history(joints, 3.0, 0.01)
    assert (theta <= rover.limits.upper).all()
    bounded = np.isfinite(rover.limits.upper)
    assert np.array_equal(theta[-1][bounded], rover.limits.upper[bounded])
    assert not joints.theta_dot[bounded].any()


def test_without_setpoints_the_drives_hold_for_an_hour_that_costs_nothing(rover, clock):
    joints = SimulatedJoints(rover, rover.ready, clock=clock)
    joints.step(3600.0)
    joints.write(setpoint(rover.ready, [0.0, 0.0, 0.0, 0.0, 1.0]))
    joints.step(3600.0)
    assert np.allclose(joints.theta, rover.ready, atol=1e-6)
    assert not joints.theta_dot.any()


@pytest.mark.parametrize(
    "options", [{"latency": -0.1}, {"latency": np.nan}, {"velocity": 0.0}, {"acceleration": [1.0]}, {"theta": [0.0]}]
)
def test_what_cannot_be(rover, options):
    with pytest.raises(InputError, match=next(iter(options))):
        SimulatedJoints(rover, **{"theta": rover.ready, **options})


def test_a_latency_in_milliseconds_is_noticed(rover, clock):
    joints = SimulatedJoints(rover, rover.ready, latency=50.0, clock=clock)
    for _ in range(10_000):
        joints.write(setpoint(rover.ready))
    with pytest.raises(InputError, match="latency is in seconds"):
        joints.write(setpoint(rover.ready))
