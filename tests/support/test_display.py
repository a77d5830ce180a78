"""What objects show of themselves: a line or three at a prompt."""

from __future__ import annotations

import numpy as np

from catalogue import load
from twistarm import (
    Actuators,
    Approach,
    Arm,
    JogCommand,
    Pose,
    PoseCommand,
    Position,
    ServoState,
    TolerancedPose,
    Trajectory,
    TwistCommand,
    arm_from_screws,
    crosscheck,
    plan_joint,
    screws,
    servo_step,
    solve_ik,
    solve_ik_batch,
)
from twistarm.calibration import Measurements

LONGEST = 240  # three lines of a terminal of 80 columns


def printed() -> list[object]:
    """One of whatever a person prints."""
    arm = load("panda")
    theta, g = arm.ready, arm.fk(arm.ready)
    motion = plan(arm)
    state, output = servo_step(arm, ServoState.at(arm, theta), [0.1, 0, 0, 0, 0, 0], 0.01)
    check = crosscheck(arm, 2)
    motors = Actuators(arm.joint_names, arm.joint_names, 50 * np.eye(7), np.zeros(7), ("tick",) * 7, 4096 * np.ones(7))
    targets = [Pose(g), Position([1, 0, 0]), Approach([1, 0, 0], [0, 0, 1]), TolerancedPose(g, [0] * 6)]
    commands = [TwistCommand([0.1, 0, 0, 0, 0, 0]), JogCommand(theta), PoseCommand(g)]
    answers = [solve_ik(arm, targets[1]), solve_ik(arm, Position([9, 0, 0])), solve_ik_batch(arm, targets)]
    parts = [arm.limits, arm.coupling, arm.proof, arm.description, arm.manipulability(theta), motion.sample(0.1)]
    log = Measurements(np.zeros((9, 2)), np.zeros((9, 3)))
    screw = screws.to_screw([0.1, 0, 0, 0, 0, 1])
    shown = [arm, motion, state, output, check, check.comparisons[0], motors, log, screw]
    return [*shown, *targets, *commands, *answers, *parts]


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
    g = screws.exp([0.5, 0, 0, 0, 0, 0]) @ screws.exp([0, 0, 0, 0, 0, np.pi / 3])
    assert repr(Pose(g)) == "Pose(g=at [0.5, 0, 0] turned 60°)"


def test_long_arms_are_told_in_brief() -> None:
    arm = arm_from_screws(np.tile([[0.0], [0], [0], [0], [0], [1]], (1, 32)), np.eye(4), name="long")
    for thing in (arm, arm.limits, plan(arm)):
        assert len(repr(thing)) <= LONGEST
