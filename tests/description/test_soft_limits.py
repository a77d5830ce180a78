"""Soft limits of a safety_controller: kept by everything that moves the arm, by the rule of MoveIt's joint model."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from servo_drives import driven
from twistarm import Arm, Position, crosscheck, load_arm, plan_joint, solve_ik
from twistarm.control.servo import JogCommand, ServoState
from twistarm.support.errors import TwistarmError
from urdf_text import joint, robot, two_joints, write

SOFT = '<safety_controller {} k_position="100" k_velocity="40"/>'


def arm_with(folder: Path, given: str, **changes: str) -> Arm:
    return load_arm(write(folder, two_joints(inside=SOFT.format(given), **changes)))


def as_moveit(soft: tuple[float, float]) -> tuple[float, float]:
    """jointBoundsFromURDF of moveit_core, for a joint of -1 … 1."""
    return max(soft[0], -1.0), min(soft[1], 1.0)


RANGES = {
    'soft_lower_limit="-0.5" soft_upper_limit="0.6"': as_moveit((-0.5, 0.6)),
    'soft_lower_limit="-3" soft_upper_limit="0.6"': as_moveit((-3, 0.6)),
    'soft_lower_limit="-0.5"': as_moveit((-0.5, 0)),
    'soft_lower_limit="0" soft_upper_limit="0"': (-1.0, 1.0),
    "": (-1.0, 1.0),
    'soft_lower_limit="2" soft_upper_limit="3"': (-1.0, 1.0),
}


@pytest.mark.parametrize("given", RANGES)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_the_narrower_of_soft_and_hard_limits_counts(given: str, kind: str, tmp_path: Path) -> None:
    arm = arm_with(tmp_path, given, kind=kind)
    assert (arm.limits.lower[0], arm.limits.upper[0]) == RANGES[given]
    assert (arm.limits.lower[1], arm.limits.upper[1]) == (-1.0, 1.0)
    told = [one.what for one in arm.findings if one.code == "soft-limits"]
    assert len(told) == (RANGES[given] != (-1.0, 1.0))
    assert ("soft-limits-unusable" in [one.code for one in arm.findings]) == ('"2" soft_upper_limit="3"' in given)
    assert crosscheck(arm, 5).ok  # Pinocchio as written knows the hard ones


def test_a_continuous_joint_keeps_none(tmp_path: Path) -> None:
    arm = arm_with(tmp_path, 'soft_lower_limit="-0.5" soft_upper_limit="0.5"', kind="continuous")
    assert np.isinf(arm.limits.upper[0])


def test_ik_plan_and_servo_stay_inside(tmp_path: Path) -> None:
    axis = '<axis xyz="0 1 0"/>'
    soft = SOFT.format('soft_lower_limit="-0.4" soft_upper_limit="0.5"')
    text = robot(joint("a", "base_link", "upper", inside=axis + soft), joint("b", "upper", "tool0", inside=axis))
    arm, free = load_arm(write(tmp_path, text)), load_arm(write(tmp_path, text.replace(soft, ""), "free.urdf"))
    beyond = free.fk(np.array([0.9, 0.3]))[:3, 3]
    assert solve_ik(free, Position(beyond)).converged
    found = solve_ik(arm, Position(beyond))
    assert not found.converged
    assert -0.4 <= found.theta[0] <= 0.5
    with pytest.raises(TwistarmError, match="limits"):
        plan_joint(arm, [np.zeros(2), np.array([0.8, 0.0])], limits={"acceleration": 2.0})
    for speed, end in ((1.0, 0.5), (-1.0, -0.4)):
        state, _ = driven(arm, ServoState.at(arm, np.zeros(2)), JogCommand([speed, 0.0]), 400)
        assert state.theta[0] == pytest.approx(end, abs=1e-3)
        assert -0.4 <= state.theta[0] <= 0.5
