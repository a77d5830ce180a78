"""What objects show of themselves: a line or three at a prompt."""

from __future__ import annotations

import numpy as np

from catalogue import load
from twistarm import (
    Arm,
    Pose,
    Position,
    ServoState,
    Trajectory,
    arm_from_screws,
    plan_joint,
    screws,
    servo_step,
    solve_ik,
    solve_ik_batch,
)

LONGEST = 240  # three lines of a terminal of 80 columns


def printed() -> list[object]:
    """One of whatever a person prints."""
    arm = load("panda")
    theta, motion = arm.ready, plan(arm)
    targets = [Pose(arm.fk(theta)), Position([9, 0, 0])]
    answers = [solve_ik(arm, targets[1]), solve_ik_batch(arm, targets), arm.manipulability(theta), motion.sample(0.1)]
    state = ServoState.at(arm, theta)
    output = servo_step(arm, state, [0.1, 0, 0, 0, 0, 0], 0.01)[1]
    return [arm, arm.limits, arm.coupling, arm.description, motion, state, output, *targets, *answers]


def plan(arm: Arm) -> Trajectory:
    return plan_joint(arm, [arm.ready, arm.ready], limits={"velocity": 1.0, "acceleration": 1.0})


def test_every_object_fits_three_lines_of_a_terminal() -> None:
    for thing in printed():
        text = repr(thing)
        assert text.startswith(type(thing).__name__), text
        assert "\n" not in text, text
        assert len(text) <= LONGEST, f"{len(text)}: {text}"


def test_numbers_have_four_digits() -> None:
    assert repr(Position([1.23456789, 1e-17, -2])) == "Position(p=[1.235, 0, -2])"
    assert "pitch=0," in repr(screws.to_screw([0.4, 0, 4.6e-23, 0, 0, 1])), "a number alone, as those in a row"
    g = screws.exp([0.5, 0, 0, 0, 0, 0]) @ screws.exp([0, 0, 0, 0, 0, np.pi / 3])
    assert repr(Pose(g)) == "Pose(g=at [0.5, 0, 0] turned 60°)"


def test_long_arms_are_told_in_brief() -> None:
    arm = arm_from_screws(np.tile([[0.0], [0], [0], [0], [0], [1]], (1, 32)), np.eye(4), name="long")
    for thing in (arm, arm.limits, plan(arm)):
        assert len(repr(thing)) <= LONGEST
