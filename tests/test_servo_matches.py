"""The compiled step of the servo against the readable one: the same rates, causes and losses."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from servo_drives import next_command, random_arm
from twistarm.servo import ServoSettings, ServoState, readable, resolved_rates
from twistarm.servo.bounds import bounds_of
from twistarm.servo.step import _answer

SAME, SAME_WHERE_DAMPED = 1e-9, 1e-5
"""[rad/s, rad, …] Where a direction is damped, how much hangs on a finite difference: 2e-6 was seen there."""

ARMS = ("rover_arm", "so101", "scara", "rr_planar", "rover_arm_6dof", "ur5", "panda", "stanford")


@pytest.fixture(autouse=True)
def _compiled():
    if load("rover_arm").compiled is None:
        pytest.skip("no compiled core; tests/test_engine.py says whether there should be one")


@pytest.fixture(autouse=True)
def damped(monkeypatch):
    """Whether the readable step has damped a direction since this was last cleared."""
    seen, gain = [], resolved_rates._gain

    def recorded(task, J, along, share, before):
        seen.extend([True] * (along.aside or along.sigma < task.below))
        return gain(task, J, along, share, before)

    monkeypatch.setattr(resolved_rates, "_gain", recorded)
    return seen


def same(arm, bounds, state, command, damped):
    """The compiled step's answer, once it is seen to be the readable one's."""
    damped.clear()
    ours, theirs = _answer(arm, bounds, state, command, 0.01), readable.step(arm, bounds, state, command, 0.01)
    close = SAME_WHERE_DAMPED if damped else SAME
    assert ours.cause == theirs.cause
    assert ours.row == theirs.row
    assert ours.halted == theirs.halted
    assert ours.scale == pytest.approx(theirs.scale, abs=10 * close)
    for name in ("theta", "theta_dot", "remaining"):
        np.testing.assert_allclose(getattr(ours, name), getattr(theirs, name), atol=close, err_msg=name)
    # What is lost is told at full speed: rates divided by the share of it that they are for.
    np.testing.assert_allclose(ours.lost, theirs.lost, atol=10 * close)
    assert (ours.held is None) == (theirs.held is None)
    return ours


def walk(arm, rng, steps, damped):
    """Both steps at every state of one drive, at rest and in motion; the drive goes on from the compiled one's."""
    bounds, command = bounds_of(arm, ServoSettings()), None
    state = ServoState.at(arm, arm.random_theta(rng))
    for k in range(steps):
        if k % 10 == 0:
            command = next_command(rng, arm, command)
        ours = same(arm, bounds, state, command, damped)
        holding = command.flags if command.flags > 1 else None
        state = ServoState(ours.theta, ours.theta_dot, ours.held, holding)


@pytest.mark.parametrize("name", ARMS)
def test_the_same_on_arms_of_the_catalogue(name, damped):
    walk(load(name), np.random.default_rng(5), 120, damped)


@pytest.mark.parametrize("n", range(1, 9))
def test_the_same_on_random_arms_with_limits(n, damped):
    rng = np.random.default_rng([6, n])
    walk(random_arm(rng, n), rng, 120, damped)


@pytest.mark.parametrize("name", ["ur5", "elbow", "rr_planar", "rover_arm"])
def test_the_same_where_the_arm_is_exactly_singular(name, damped):
    arm, rng = load(name), np.random.default_rng(7)
    bounds, state = bounds_of(arm, ServoSettings()), ServoState.at(arm, np.zeros(arm.n))
    command = None
    for _ in range(20):
        command = next_command(rng, arm, command)
        same(arm, bounds, state, command, damped)
