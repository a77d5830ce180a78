"""The servo under twists that are held for long: nothing shakes, and what it says of an arm at rest is steady."""

import numpy as np
import pytest
from benchmarks.servo import REVERSALS, STEADY, TURNING, case, held, judged, names, random, servo_arm, sign_changes

from twistarm.control.servo import ServoState, TwistCommand, servo_step

SLOW = pytest.mark.slow
# Twists of an arm: of every kind, from random starts, at limits, at stretched and at singular postures.
QUICK, WHOLE = 8, 160
# And whether accelerations are limited.
ARMS = [("four_joints", True), ("scara", False), ("rover_arm", False), ("so101", True), ("ur5", False), ("panda", True)]
LATER = 16.0  # Seconds: what still shakes then is a cycle, and not the end of a motion.


HELD_TWISTS = [
    *(pytest.param(name, accelerating, QUICK, None) for name, accelerating in ARMS),
    *(pytest.param(name, accelerating, WHOLE, LATER, marks=SLOW) for name in names() for accelerating in (True, False)),
]


@pytest.mark.parametrize(("name", "accelerating", "count", "later"), HELD_TWISTS)
def test_no_held_twist_ends_in_shaking(name, accelerating, count, later):
    arm, rng = servo_arm(name, accelerating), random(name, "quiet", 0)
    for number in range(count):
        drawn = case(arm, rng, number)
        command = TwistCommand(drawn.twist, drawn.frame)
        verdict = judged(*held(arm, drawn.theta, command))
        if later and (verdict.shakes or verdict.unsteady > STEADY):
            verdict = judged(*held(arm, drawn.theta, command, later))
        assert not verdict.shakes, (number, verdict, drawn)
        assert verdict.unsteady <= STEADY, (number, verdict, drawn)


def test_an_arm_with_a_limit_close_on_both_ways_out_rests():
    """Stretched, with joint 5 and joint 3 some milliradians from a limit: one way out ends at each of them."""
    arm, theta = servo_arm("elbow", False), np.array([-1.50614, 2.32529, -3.14107, -3.1413, 3.13774, -0.88804])
    assert not judged(*held(arm, theta, TwistCommand([0, -0.1, 0, 0, 0, 0], "tool"))).shakes


def holding(rng, twist, frame, hold):
    """The twist; a turn at a held position; or a random twist with four components held."""
    if hold == "position":
        axis = rng.normal(size=3)
        twist = 0.4 * np.r_[0, 0, 0, axis / np.linalg.norm(axis)]
    if hold == "mixed":
        hold = rng.permutation([True, True, False] * 2).tolist()
        twist = np.where(hold, 0.0, rng.normal(size=6)) * np.repeat([0.1, 0.4], 3)
    return TwistCommand(twist, frame, hold)


SHAKY = ("rover_arm", "rover_arm_6dof", "so101", "ur5", "panda", "slide_and_pitches")
UNEVEN = [
    *(pytest.param(name, True, None, 8, 0) for name in ("rover_arm", "so101", "slide_and_pitches")),
    # Stretched arms that turn about a held position lose its direction within a few steps.
    *(pytest.param(name, True, "position", 12, 0) for name in ("rover_arm_6dof", "ur5")),
    # Among many holds are those in which a joint at its limit takes a held direction away.
    *(
        pytest.param(name, accelerating, hold, 60, most, marks=SLOW)
        for hold, most in ((None, 0), ("position", 2), ("mixed", 2))
        for name in SHAKY
        for accelerating in (True, False)
    ),
]
"""Arms, whether accelerations are limited, what is held, how many twists, and how many of them may shake."""


@pytest.mark.parametrize(("name", "accelerating", "hold", "count", "most"), UNEVEN)
def test_held_twists_do_not_shake_at_uneven_steps(name, accelerating, hold, count, most):
    """No joint turns round again and again, at steps of 2 to 30 ms."""
    arm, rng, shaking = servo_arm(name, accelerating), random(name, "jittered", 0), 0
    for number in range(count):
        drawn = case(arm, rng, number)
        command = holding(rng, drawn.twist, drawn.frame, hold)
        state, rates, judged_from = ServoState.at(arm, drawn.theta), [], 5.0
        for dt in rng.uniform(0.002, 0.03, 560):
            state, _ = servo_step(arm, state, command, dt)
            judged_from -= dt
            if judged_from < 0.0:
                rates.append(state.theta_dot)
        shaking += sign_changes(np.array(rates), TURNING) / -judged_from >= REVERSALS
    assert shaking <= most


@pytest.mark.parametrize(
    ("name", "start", "twist"),
    [("rover_arm", "reach", [0, 0, 0.1, 0, 0, 0]), ("four_joints", [0.0, -1.05, 0.35, 0.7], [0, 0.05, 0, 0, 0, 0])],
)
def test_an_arm_held_against_its_reach_does_not_shake(name, start, twist):
    arm = servo_arm(name)
    assert not judged(*held(arm, arm.theta_from(start), TwistCommand(twist, "base"), 15.0)).shakes
