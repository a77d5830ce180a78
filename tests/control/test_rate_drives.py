"""Velocity mode on drives that are too fast or too slow, late and coarse: what the joints really do."""

import numpy as np
import pytest

from catalogue import load
from rate_plant import driven, off_line
from stream_stand_ins import jog
from twistarm.control.servo import JogCommand, TwistCommand
from twistarm.control.stream import Ending

SPEED, WAY = 0.1, 3.0  # Of the tool [m/s]; seconds.

UP, LEFT, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0])
FREE = {"rover_arm": UP, "ur5": LEFT, "panda": DOWN}  # Where an arm can go 0.3 m from its ready configuration.


def along(direction, after=None):
    """A tool's twist for WAY seconds, then `after`."""
    command = TwistCommand(np.r_[SPEED * direction, np.zeros(3)], "base", hold="orientation")
    return lambda t: command if t < WAY else after


def into_limits(arm):
    return JogCommand(np.minimum(arm.limits.velocity, 1.0) * np.where(arm.ready > 0.0, -1.0, 1.0))


def kept(drive):
    """It went on, and what was sent kept the limits of velocity and acceleration."""
    return drive.ending is None and drive.fastest <= 1.0 + 1e-9 and drive.hardest <= 1.0 + 1e-9


def assert_straight(name, drive, most):
    off, way = off_line(load(name), drive.path, FREE[name])
    assert kept(drive)
    assert off < most
    assert way > 0.28


@pytest.mark.parametrize(("name", "delay"), [("rover_arm", 0.1), ("ur5", 0.05)])
def test_a_tool_goes_straight_and_then_stands(name, delay):
    arm = load(name)
    drive = driven(arm, arm.ready, along(FREE[name], TwistCommand(np.zeros(6), "base")), 6.0, delay=delay)
    assert_straight(name, drive, 5e-3)
    assert not drive.rates[-150:].any()  # though the encoders flicker


@pytest.mark.parametrize("name", ["rover_arm", "scara"])
def test_joints_that_are_held_into_their_limits_stop_there(name):
    arm = load(name)
    drive = driven(arm, arm.ready, lambda t: into_limits(arm), 7.0, delay=0.1)
    assert kept(drive)
    assert (drive.beyond < np.where(np.array(arm.units) == "m", 5e-3, np.radians(0.5))).all()
    assert drive.reversals(since=0.0) <= 1


def test_a_release_is_no_slower_than_without_corrections(rover):
    stood = []
    for mode in (False, True):
        drive = driven(rover, rover.ready, along(UP), 4.0, velocity_mode=mode, delay=0.1, gain=0.97)
        moving = np.abs(np.diff(drive.path, axis=0)).max(axis=1) > 1e-4  # 0.01 rad/s
        stood.append(np.flatnonzero(moving)[-1])
    assert stood[1] <= stood[0] + 1


def test_a_drive_that_does_not_move_strays_as_soon_as_by_positions(rover):
    ends = [
        driven(rover, rover.ready, lambda t: jog(rover, elbow=-0.4), 4.0, velocity_mode=mode, gain=0.0)
        for mode in (False, True)
    ]
    assert [cycle.ending for cycle in ends] == [Ending.STRAYED] * 2
    assert ends[1].seconds == pytest.approx(ends[0].seconds, abs=0.1)


def test_a_joint_that_jumps_has_strayed(rover):
    def push(t, drives):
        drives.theta[2] += 0.3 * (abs(t - 1.0) < 1e-6)

    assert driven(rover, rover.ready, along(UP), 4.0, push=push).ending is Ending.STRAYED


@pytest.mark.parametrize("gain", [0.5, 1.5])
def test_a_drive_that_is_far_off_does_not_shake(rover, gain):
    drive = driven(rover, rover.ready, lambda t: jog(rover, elbow=-0.4 * (t < WAY)), 6.0, gain=gain)
    assert drive.reversals(since=0.0) <= 2
    assert max(drive.fastest, drive.hardest) <= 1.0 + 1e-9


def test_an_arm_whose_joint_states_fail_to_come_stands_and_goes_on(rover):
    drive = driven(rover, rover.ready, lambda t: jog(rover, elbow=-0.4), 4.0, mute=lambda t: 1.0 < t < 2.0)
    assert kept(drive)
    assert not drive.rates[160:200].any()
    assert drive.rates[-1].any()


@pytest.mark.slow
@pytest.mark.parametrize("name", FREE)
@pytest.mark.parametrize("plant", [{"delay": 0.02, "every": 0.01}, {"delay": 0.1, "every": 0.02}, {"lag": 0.05}])
def test_lines_and_limits_on_many_drives(name, plant):
    arm = load(name)
    for seed in range(2):
        drive = driven(arm, arm.ready, along(FREE[name]), 4.0, seed=seed, **plant)
        assert_straight(name, drive, 5e-3)
        drive = driven(arm, arm.ready, lambda t: into_limits(arm), 8.0, seed=seed, **plant)
        assert kept(drive)
        assert (drive.beyond < np.where(np.array(arm.units) == "m", 5e-3, np.radians(0.5))).all()
