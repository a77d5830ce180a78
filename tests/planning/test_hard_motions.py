"""Motions that planners stumble over: inside every limit at twenty times their grid, or refused with a reason."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PPoly

from twistarm import Arm, ArmBuilder, Trajectory, available_arms, load_arm, load_motion, plan, plan_joint
from twistarm.description.companions.data_files import parse_toml
from twistarm.limits import JointLimits
from twistarm.planning.joint_space import LAWS, as_limits
from twistarm.support.errors import TwistarmError

CASES: list[dict[str, Any]] = parse_toml(Path(__file__).parent / "hard_motions.toml", "the hard motions")["case"]
LIMITS = {"velocity": 1.0, "acceleration": 2.0}


@cache
def arm_of(name: str) -> Arm:
    if name == "two":
        builder = ArmBuilder("two").prismatic("x", [1, 0, 0], lower=-1, upper=1)
        return builder.prismatic("y", [0, 1, 0], lower=-1, upper=1).tool(np.eye(4)).build()
    if name == "spun":
        tool = np.eye(4)
        tool[0, 3] = 1.0
        builder = ArmBuilder("spun").revolute("a", [0, 0, 1], [0, 0, 0]).revolute("b", [0, 0, 1], [0.5, 0, 0])
        return builder.tool(tool).build()
    return load_arm(name)


def judge(motion: Trajectory, limits: JointLimits, jerk: bool) -> None:
    """Every limit at twenty times the grid, rest at both ends and no leaps, as SciPy evaluates the polynomials."""
    if motion.duration == 0.0:
        return
    motion_of = PPoly(motion.coefficients, motion.breakpoints)
    h = np.diff(motion.breakpoints)
    t = motion.breakpoints[:-1, None] + h[:, None] * np.linspace(0.0, 1.0 - 1e-9, 21)
    theta, velocity, acceleration, jolt = (motion_of(t.ravel(), order) for order in range(4))
    assert (np.maximum(limits.lower - theta, theta - limits.upper) <= 1e-9).all()
    assert (np.abs(velocity) <= limits.velocity * (1 + 1e-6)).all()
    assert (np.abs(acceleration) <= limits.acceleration * (1 + 1e-6)).all()
    assert not jerk or (np.abs(jolt) <= limits.jerk * (1 + 1e-6)).all()
    assert (np.abs(velocity[[0, -1]]) <= 1e-6 * limits.velocity).all()
    inner = motion.breakpoints[1:-1]
    ends = motion_of(np.concatenate([t[:-1, -1]])), motion_of(inner)
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-7)


def outcome(case: dict[str, Any], make: Callable[[], Trajectory]) -> Trajectory | None:
    """The motion, or None where it is refused as the case has it."""
    if "refused" not in case:
        return make()
    with pytest.raises(TwistarmError) as caught:
        make()
    assert re.search(case["refused"], str(caught.value)), str(caught.value)
    return None


def planned(case: dict[str, Any], arm: Arm, file: Path) -> Iterator[tuple[str, Trajectory | None]]:
    limits = {**LIMITS, **case.get("limits", {})}
    if "waypoints" in case:
        for kind in case.get("kinds", LAWS):
            motion = outcome(case, lambda kind=kind: plan_joint(arm, case["waypoints"], kind=kind, limits=limits))
            assert motion is None or len(motion.times) == len(case["waypoints"])
            if motion is not None:
                np.testing.assert_allclose(motion(motion.times), case["waypoints"], rtol=0, atol=1.1e-6)
            yield kind, motion
        return
    file.write_text("[[segment]]\n" + case["segments"], "utf-8")
    segments = load_motion(file, arm).segments
    start = case.get("start", "ready" if case["arm"] in available_arms() else [0.0] * arm.n)
    for law in (*LAWS, "quintic"):
        yield law, outcome(case, lambda law=law: plan(arm, segments, start=start, kind=law, limits=limits))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"].replace(" ", "-"))
def test_a_hard_motion_keeps_its_limits_or_is_refused(case: dict[str, Any], tmp_path: Path) -> None:
    arm = arm_of(case["arm"])
    limits = as_limits(arm, {**LIMITS, **case.get("limits", {})})
    for kind, motion in planned(case, arm, tmp_path / "motion.toml"):
        if motion is not None:
            judge(motion, limits, jerk="jerk" in case.get("limits", {}) and kind in ("quintic", "s_curve"))
