"""Tolerances of lines, and the configurations that follow a curve."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from ik_targets import pinocchio_fk
from twistarm import (
    Approach,
    Arm,
    ArmBuilder,
    JointMove,
    LineMove,
    NotConvergedError,
    PathError,
    Pose,
    Position,
    TolerancedPose,
    Trajectory,
    load_arm,
    load_motion,
    plan,
    plan_joint,
    rotations,
)
from twistarm.cli.application import run
from twistarm.ik.targets import target_for
from twistarm.planning import configurations as finding
from twistarm.planning.configurations import errors_and_rows

RATES = {"velocity": 1.0, "acceleration": 3.0}
DOWN = np.array([0.0, 0.0, -1.0])


def rounded_arm(by: float) -> Arm:
    """Yaw, three pitches and a roll, of which one pitch axis is off by an angle [rad], as CAD programs export them."""
    builder = ArmBuilder("rounded").revolute("yaw", [0, 0, 1], [0, 0, 0], lower=-2, upper=2)
    builder = builder.revolute("shoulder", [0, 1, 0], [0, 0, 0.1], lower=-2, upper=2)
    builder = builder.revolute("elbow", [by, 1, 0], [0, 0, 0.4], lower=-2.5, upper=2.5)
    builder = builder.revolute("wrist", [0, 1, 0], [0.3, 0, 0.4], lower=-2.5, upper=2.5)
    builder = builder.revolute("roll", [1, 0, 0], [0.35, 0, 0.4], lower=-3, upper=3)
    g = np.eye(4)
    g[:3, 3] = [0.4, 0.0, 0.4]
    g[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # the tool's z axis is the roll's
    return builder.tool(g).build()


def off(arm: Arm, motion: Trajectory, begin: float, goal: np.ndarray, direction: np.ndarray) -> tuple[float, float]:
    """How far the tool is from the line to the goal [m], and its z axis from the direction [rad], by Pinocchio."""
    g = np.array([pinocchio_fk(arm, theta) for theta in motion(np.linspace(begin, motion.duration, 300))])
    p, way = g[:, :3, 3], goal - g[0, :3, 3]
    s = np.clip((p - p[0]) @ way / (way @ way), 0.0, 1.0)
    beside = np.linalg.norm(p - p[0] - s[:, None] * way, axis=1)
    return float(beside.max()), float(np.linalg.norm(np.cross(g[:, :3, 2], direction), axis=1).max())


@pytest.mark.parametrize("by", [5e-6, 5e-5, 5e-4])
def test_a_line_that_is_missed_by_the_rounding_of_an_axis_is_planned_within_tolerances(by: float) -> None:
    arm, goal = rounded_arm(by), np.array([0.25, 0.12, 0.15])
    tour = [JointMove(Approach([0.3, -0.1, 0.12], DOWN)), LineMove(Approach(goal, DOWN))]
    if by > 5e-5:  # more than the usual tolerance
        with pytest.raises((PathError, NotConvergedError)):
            plan(arm, tour, limits=RATES)
    else:
        motion = plan(arm, tour, limits=RATES)
        beside, turned = off(arm, motion, motion.times[1], goal, DOWN)
        assert beside <= 1.5e-4
        assert turned <= np.radians(0.05)
    motion = plan(arm, tour, limits=RATES, orientation_tol=2 * by)
    beside, turned = off(arm, motion, motion.times[1], goal, DOWN)
    assert beside <= 1e-4
    assert turned <= max(2 * by, np.radians(0.05))
    assert np.abs(np.diff(motion(np.linspace(0, motion.duration, 500)), axis=0)).max() < 0.05  # and without a leap
    h = [JointMove(move.to, orientation_tol=2 * by) for move in tour]
    assert plan_joint(arm, [move.to for move in tour], limits=RATES, orientation_tol=2 * by).duration > 0
    assert plan(arm, [h[0], LineMove(tour[1].to, orientation_tol=2 * by)], limits=RATES).duration == motion.duration


def test_a_line_that_ends_beyond_the_reach_is_followed_within_a_wider_tolerance() -> None:
    """Two links of 1 m come no nearer than 2 mm to a goal at 2.002 m."""
    builder = ArmBuilder("two").revolute("a", [0, 0, 1], [0, 0, 0], lower=-3, upper=3)
    g = np.eye(4)
    g[0, 3] = 2.0
    arm = builder.revolute("b", [0, 0, 1], [1, 0, 0], lower=-3, upper=3).tool(g).build()
    goal = np.array([2.002 * np.cos(0.3), 2.002 * np.sin(0.3), 0.0])
    with pytest.raises(PathError) as refused:
        plan(arm, LineMove(Position(goal)), start=[0.3, 0.8], limits=RATES, position_tol=4e-4)
    assert refused.value.reason == "out of reach"
    assert 0.9 < refused.value.share < 1.0
    motion = plan(arm, LineMove(Position(goal)), start=[0.3, 0.8], limits=RATES, position_tol=3e-3)
    end = pinocchio_fk(arm, motion(motion.duration))[:3, 3]
    assert 2e-3 * (1 - 1e-9) <= np.linalg.norm(end - goal) <= 3e-3


def test_tolerances_stand_in_a_motion_file_and_on_the_command_line(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arm = load_arm("rover_arm", limits=RATES)
    file = here / "m.toml"
    text = "degrees = true\nposition_tol = 0.01\n[[segment]]\nline = {{ xyz = {} }}\norientation_tol = 2\n"
    far = (arm.fk(arm.ready)[:3, 3] + [0.05, 0.0, 0.0]).tolist()
    file.write_text(text.format(far), "utf-8")
    read = load_motion(file, arm)
    assert read.position_tol == 0.01
    assert read.segments[0].orientation_tol == pytest.approx(np.radians(2))
    how = ["--line", "--xyz", " ".join(map(str, far)), "--acceleration", "3", "--velocity", "1", "--json"]
    assert run(["plan", "rover_arm", *how, "--position-tol", "0.02"]) == 0
    end = json.loads(capsys.readouterr().out)["waypoints"][-1]
    assert np.linalg.norm(pinocchio_fk(arm, np.array(end))[:3, 3] - far) <= 0.02
    assert run(["plan", "rover_arm", *how, "--position-tol", "-1"]) == 2
    assert run(["plan", "rover_arm", "--to", "zero", "--orientation-tol", "1"]) == 2


ARM = load_arm("rover_arm", limits={"acceleration": 3.0})


def likes(g: np.ndarray) -> list:
    return [
        Pose(g),
        Position(g[:3, 3]),
        Approach(g[:3, 3], g[:3, :3] @ [0.6, 0.0, 0.8], [0.6, 0.0, 0.8]),
        TolerancedPose(g, np.zeros(6)),
        TolerancedPose(g, np.zeros(6), frame="base"),
    ]


@pytest.mark.parametrize("name", ["rover_arm", "rover_arm_6dof"])
def test_rows_are_the_derivatives_of_errors(name):
    arm = load_arm(name)
    rng = np.random.default_rng(3)
    for theta in rng.uniform(-0.5, 0.5, (5, arm.n)):
        g = arm.fk(theta)
        for like in likes(g):

            def errors(at: np.ndarray, like=like, g=g) -> np.ndarray:
                return errors_and_rows(like, g[None], arm.fk(at)[None], arm.body_jacobian(at)[None])[0][0]

            rows = errors_and_rows(like, g[None], g[None], arm.body_jacobian(theta)[None])[1][0]
            step = 1e-6 * np.eye(arm.n)
            differences = [(errors(theta + h) - errors(theta - h)) / 2e-6 for h in step]
            np.testing.assert_allclose(rows, np.transpose(differences), atol=1e-7)


def test_errors_of_a_task_away_from_its_target_are_what_exceeds_the_tolerances():
    theta = ARM.ready
    g = ARM.fk(theta)
    off = g.copy()
    off[:3, 3] += [0.02, 0.0, -0.005]
    off[:3, :3] = rotations.exp([0.0, 0.0, 0.3]) @ g[:3, :3]
    task = TolerancedPose(g, [0.005, 0.0, 0.01, np.inf, np.inf, 0.1], frame="base")
    e, J = errors_and_rows(task, g[None], off[None], ARM.body_jacobian(theta)[None])
    np.testing.assert_allclose(e[0], [0.015, 0.0, 0.0, 0.0, 0.0, 0.2], atol=1e-12)
    assert [bool(row.any()) for row in J[0]] == [True, True, False, False, False, True]


@pytest.mark.parametrize(("name", "kind"), [("rover_arm", "approach"), ("panda", "pose"), ("ur5", "approach")])
def test_branches_of_an_arm_that_is_left_free_meet_the_target_in_many_postures(name: str, kind: str) -> None:
    arm = load(name)
    g = arm.fk(arm.random_theta(22))
    like = Pose(g) if kind == "pose" else target_for(arm, Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis))
    found = finding.branches(arm, like, arm.ready)
    assert len(found) > 10
    assert (np.diff(np.linalg.norm(found - arm.ready, axis=1)) >= 0).all()
    assert arm.limits.contains(found).all()
    assert max(np.abs(found - found[0]).max(axis=1)) > 1.0
    for theta in found[::7]:
        reached = pinocchio_fk(arm, theta)
        assert like.position_error(reached) <= 1e-8
        assert like.orientation_error(reached) <= 1e-8
