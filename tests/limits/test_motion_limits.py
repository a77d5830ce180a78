"""Motors that are coupled keep their limits, and the joints theirs, whatever is commanded."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from test_actuators import differential
from twistarm import Actuators, InputError, JointLimits
from twistarm.limits.motion_limits import MotionLimits

DRIVES, STEPS = 12, 300

JOINTS = JointLimits.unbounded(3).with_(
    {
        "lower": [-0.3, -1.2, -np.inf],
        "upper": [0.3, 1.2, np.inf],
        "velocity": [0.3, 1.2, 2.0],
        "acceleration": [1, 4, 6],
    },
    ("slide", "pitch", "roll"),
)


def wrist() -> Actuators:
    """A slide, and a differential wrist whose motors cannot do what both joints may do at once."""
    limits = {"lower": [-100.0, -100.0, -90.0], "upper": [100.0, 100.0, 95.0], "velocity": [100.0, 90.0, 90.0]}
    limits["acceleration"] = [300.0, 400.0, 200.0]
    return differential(limits=JointLimits.unbounded(3).with_(limits, ("rail", "left", "right")))


@pytest.mark.parametrize("joints", [None, JOINTS], ids=["motors", "motors and joints"])
def test_no_limit_is_passed_on_random_drives(joints: JointLimits | None) -> None:
    """Commands that jump, steps of any length: checked on the motors' and joints' own values."""
    motors = wrist()
    kept = motors.motion_limits(joints)
    passed = dict.fromkeys(("velocity", "acceleration", "position"), 0.0)
    held = set()
    for seed in range(DRIVES):
        rng = np.random.default_rng(seed)
        theta, theta_dot, command = np.zeros((3, 3))
        for _ in range(STEPS):
            dt = rng.uniform(0.002, 0.03)
            if rng.random() < 0.05:
                command = rng.normal(size=3) * [0.4, 2.0, 2.0] * rng.choice([0.3, 1.0, 3.0])
            allowed = kept.within(theta, command, theta_dot, dt)
            change, theta_dot = allowed.theta_dot - theta_dot, allowed.theta_dot
            theta = theta + dt * theta_dot
            held.add((allowed.by, allowed.limit))
            for limits, x, x_dot, x_change in [
                (motors.limits, motors.to_motor(theta), motors.G @ theta_dot, motors.G @ change),
                (joints or JointLimits.unbounded(3), theta, theta_dot, change),
            ]:
                worst = {
                    "velocity": (np.abs(x_dot) / limits.velocity).max() - 1.0,
                    "acceleration": (np.abs(x_change) / limits.acceleration).max() / dt - 1.0,
                    "position": np.maximum(x - limits.upper, limits.lower - x).max(),
                }
                passed = {name: max(passed[name], worst[name]) for name in passed}
    assert max(passed.values()) < 1e-9
    assert {("left", "position"), ("right", "velocity"), ("rail", "position"), (None, None)} <= held
    assert joints is None or ("pitch", "position") in held


def test_from_every_place_there_is_a_way_back() -> None:
    """At a limit, commanded inward: the motor moves in the first step."""
    kept = wrist().motion_limits(JOINTS)
    for theta, command in [([0.25, 0.0, 0.0], [-0.1, 0, 0]), ([-0.3, 0, 0], [0.1, 0, 0]), ([0, 1.2, 0], [0, -1.0, 0])]:
        allowed = kept.within(np.array(theta), np.array(command), np.zeros(3), 0.01)
        assert allowed.theta_dot @ np.array(command) > 0
    outward = kept.within(np.array([0.25, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]), np.zeros(3), 0.01)
    assert outward.theta_dot.tolist() == [0.0, 0.0, 0.0]
    assert (outward.by, outward.limit) == ("rail", "position")
    # Beyond a limit, by a description that has changed: back, and no farther.
    beyond = kept.within(np.array([0.28, 0.0, 0.0]), np.array([-0.1, 0.0, 0.0]), np.zeros(3), 0.01)
    assert beyond.theta_dot[0] < 0
    assert kept.within(np.array([0.28, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]), np.zeros(3), 0.01).theta_dot[0] == 0


def test_a_twist_is_slowed_as_a_whole() -> None:
    """In a steady motion, the direction is the commanded one."""
    kept = wrist().motion_limits(JOINTS)
    command, theta_dot = np.array([0.1, 2.0, 1.0]), np.zeros(3)
    for _ in range(200):
        theta_dot = kept.within(np.zeros(3), command, theta_dot, 0.01).theta_dot
    assert np.allclose(theta_dot, 0.5 * command)  # 180 rad/s of the left motor, which may 90
    slower = kept.within(np.zeros(3), 0.4 * command, 0.4 * command, 0.01)
    assert slower.theta_dot.tolist() == (0.4 * command).tolist()
    assert (slower.by, slower.limit) == (None, None)


def test_it_brakes_no_earlier_than_it_must() -> None:
    """One motor alone: toward its limit at the speed v with v dt + v² / (2 a) = distance."""
    kept = wrist().motion_limits()
    dt, theta, theta_dot = 0.01, np.array([0.0, 0.0, 0.0]), np.zeros(3)
    fastest = 0.0
    for _ in range(400):
        theta_dot = kept.within(theta, np.array([9.0, 0.0, 0.0]), theta_dot, dt).theta_dot
        distance = 0.25 - theta[0]
        bound = 0.75 * (np.sqrt(dt**2 + 2 * distance / 0.75) - dt)
        assert theta_dot[0] <= min(0.25, bound) + 1e-12
        fastest = max(fastest, theta_dot[0])
        theta = theta + dt * theta_dot
    assert fastest == pytest.approx(0.25)
    assert theta[0] == pytest.approx(0.25, abs=1e-3)


def test_rows_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="must have the same rows, not 0"):
        MotionLimits(("a",), np.ones((2, 1)), np.zeros(1), JointLimits.unbounded(1))
    with pytest.raises(InputError, match="must have the same rows, not 0"):
        MotionLimits((), np.ones((0, 1)), np.zeros(0), JointLimits.unbounded(0))
    with pytest.raises(InputError, match="joints must be the limits of 3 joints \\('slide', 'pitch', 'roll'\\)"):
        wrist().motion_limits(JointLimits.unbounded(2))


def test_it_survives_pickling() -> None:
    kept = wrist().motion_limits(JOINTS)
    given = np.zeros(3), np.array([0.0, 9.0, 9.0]), np.zeros(3), 0.01
    assert pickle.loads(pickle.dumps(kept)).within(*given).theta_dot.tolist() == kept.within(*given).theta_dot.tolist()
