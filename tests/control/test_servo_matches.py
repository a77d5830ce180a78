"""The compiled step of the servo against the one in NumPy: the same rates, causes and losses."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from reference.servo.step import step
from servo_drives import next_command, random_arm
from twistarm.control.servo import ServoSettings, ServoState, TwistCommand
from twistarm.control.servo.bounds import bounds_of
from twistarm.control.servo.command import held_components
from twistarm.control.servo.step import _answer

SAME = 1e-4
"""[rad/s, rad, …] What the last of some rounds may still change."""

ARMS = ("rover_arm", "so101", "scara", "rr_planar", "rover_arm_6dof", "ur5", "panda", "stanford")


@pytest.fixture(autouse=True)
def _compiled():
    if load("rover_arm").compiled is None:
        pytest.skip("no compiled core; tests/arm/test_engine.py says whether there should be one")


def same(arm, bounds, state, command, dt=0.01):
    """The compiled step's answer, once it is seen to be the other one's."""
    ours, theirs = _answer(arm, bounds, state, command, dt), step(arm, bounds, state, command, dt)
    assert ours.cause == theirs.cause
    assert ours.row == theirs.row
    assert ours.halted == theirs.halted
    assert ours.scale == pytest.approx(theirs.scale, abs=10 * SAME)
    for name in ("theta", "theta_dot", "remaining"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=SAME, err_msg=name)
    # What is lost is told at full speed: rates divided by the share of it that they are for.
    np.testing.assert_allclose(ours.lost, theirs.lost, atol=10 * SAME)
    assert (ours.held is None) == (theirs.held is None)
    assert ours.period == pytest.approx(theirs.period, rel=1e-12)
    return ours


def walk(arm, rng, steps, **settings):
    """Both steps at every state of one drive, at rest and in motion; the drive goes on from the compiled one's."""
    bounds, command = bounds_of(arm, ServoSettings(**settings)), None
    state = ServoState.at(arm, arm.random_theta(rng))
    for k in range(steps):
        if k % 10 == 0:
            command = next_command(rng, arm, command)
        ours = same(arm, bounds, state, command, dt=rng.uniform(0.005, 0.015))
        holding = command.flags if command.flags > 1 else None
        state = ServoState(ours.theta, ours.theta_dot, ours.held, holding, ours.period)


@pytest.mark.parametrize("name", ["rover_arm", pytest.param("ur5", marks=pytest.mark.slow)])
def test_the_same_where_it_stops_on_its_course(name):
    walk(load(name), np.random.default_rng(8), 40, on_unreachable="stop")


@pytest.mark.parametrize("steps", [40, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ARMS)
def test_the_same_on_arms_of_the_catalogue(name, steps):
    walk(load(name), np.random.default_rng(5), steps)


@pytest.mark.parametrize("steps", [40, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("n", range(1, 9))
def test_the_same_on_random_arms_with_limits(n, steps):
    rng = np.random.default_rng([6, n])
    walk(random_arm(rng, n), rng, steps)


@pytest.mark.parametrize("name", ["ur5", "elbow", "rr_planar", "rover_arm"])
def test_the_same_where_the_arm_is_exactly_singular(name):
    arm, rng = load(name), np.random.default_rng(7)
    bounds, state = bounds_of(arm, ServoSettings()), ServoState.at(arm, np.zeros(arm.n))
    command = None
    for _ in range(20):
        command = next_command(rng, arm, command)
        same(arm, bounds, state, command)


@pytest.mark.parametrize("hold", ["position", "orientation", [True, False, False, False, True, True]])
def test_the_same_where_held_directions_are_lost(hold):
    """Stretched out, and on its way from there."""
    arm = load("ur5")
    command = TwistCommand(np.where(held_components(hold), 0.0, 0.2), "tool", hold)
    bounds, state = bounds_of(arm, ServoSettings()), ServoState.at(arm, np.zeros(arm.n))
    for _ in range(20):
        ours = same(arm, bounds, state, command)
        state = ServoState(ours.theta, ours.theta_dot, ours.held, command.flags, ours.period)
