"""Bounds between check points: no finite difference along any joint path, no speed of the tool exceeds them."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from twistarm import Position, TolerancedPose, arm_from_screws, load_arm, rotations
from twistarm.arm.arm import Arm
from twistarm.ik.targets import Pose
from twistarm.planning.cartesian.curves import line, screw
from twistarm.planning.cartesian.moving_target import MovingTarget
from twistarm.planning.cartesian.tool_derivatives import ToolDerivatives, deviation_bend, greatest_tool_speeds
from twistarm.planning.joint_path import JointPath

MIMIC = """<robot name="lift"><link name="base_link"/><link name="one"/><link name="two"/><link name="tool"/>
<joint name="lift" type="prismatic"><parent link="base_link"/><child link="one"/><axis xyz="0 0 1"/>
<limit lower="0" upper="3" velocity="1" effort="1"/></joint>
<joint name="turn" type="continuous"><parent link="one"/><child link="two"/><axis xyz="0 1 0"/></joint>
<joint name="fold" type="revolute"><parent link="two"/><child link="tool"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" velocity="1" effort="1"/><mimic joint="turn" multiplier="3"/></joint>
</robot>"""
"""One coordinate turns two links, the second three times as far, on a slide that goes beyond the arm's reach."""


def arms(folder) -> dict[str, Arm]:
    file = folder / "lift.urdf"
    file.write_text(MIMIC)
    helix = np.array([[0.1, 0.0, 0.2, 0.0, 0.0, 1.0], [0.0, 0.3, 0.4, 0.0, 1.0, 0.0]]).T
    home = np.eye(4)
    home[0, 3] = 0.5
    return {
        "mimic": load_arm(file, tip="tool"),
        "helical": arm_from_screws(helix, home, name="helical"),
        "rover": load("rover_arm"),
        "stanford": load("stanford"),
    }


@pytest.mark.parametrize("kind", ["mimic", "helical", "rover", "stanford"])
def test_no_second_difference_exceeds_the_bound(kind, tmp_path):
    arm = arms(tmp_path)[kind]
    rng = np.random.default_rng(4)
    for _ in range(20):
        path = JointPath(
            np.array([0.0, 1.0]), rng.uniform(-1.0, 1.0, (4, 1, arm.n)) * [[[3.0]], [[3.0]], [[2.0]], [[1.0]]]
        )
        g0, twist = arm.fk(path(0.0)), rng.uniform(-1.0, 1.0, 6)
        g1 = g0.copy()
        g1[:3, 3] += twist[:3]
        g1[:3, :3] = rotations.exp(twist[3:]) @ g0[:3, :3]
        for curve in (line(g0, g1), screw(g0, twist)):
            for like in (Pose(g0), Position(g0[:3, 3]), TolerancedPose(g0, [0.0, 0.0, np.inf, 0.0, 0.0, np.inf])):
                position, rotation = seconds(arm, MovingTarget(curve, like), path)
                bound = deviation_bend(arm, MovingTarget(curve, like), path)[0]
                assert position <= bound[0] * (1.0 + 1e-4)
                assert rotation <= bound[1] * (1.0 + 1e-4) or isinstance(like, Position)


@pytest.mark.parametrize("kind", ["mimic", "helical", "rover", "stanford"])
def test_no_speed_of_the_tool_exceeds_its_bound_and_some_come_near(kind, tmp_path):
    arm, rng = arms(tmp_path)[kind], np.random.default_rng(6)
    limits = arm.limits.with_({"velocity": 3.0}, arm.joint_names)
    for _ in range(20):
        scale = np.array([2.0, 2.0, 2.0, 1.0])[:, None, None]
        path = JointPath(np.array([0.0, 0.2]), rng.uniform(-1.0, 1.0, (4, 1, arm.n)) * scale)
        s = np.linspace(0.0, 0.2, 2001)
        g = arm.fk(path(s))
        velocity = np.gradient(g[:, :3, 3], s, axis=0)[1:-1]
        turn = rotations.log(np.swapaxes(g[:-1, :3, :3], 1, 2) @ g[1:, :3, :3]) / s[1]
        seen = np.array([np.linalg.norm(velocity, axis=1).max(), np.linalg.norm(turn, axis=1).max()])
        bound = np.array([each[0] for each in greatest_tool_speeds(arm, path, limits, 1e-3, 1e-3)])
        assert (seen <= bound * (1.0 + 1e-5)).all()
        assert (seen >= bound * (1.0 - 1e-3)).all()
        jerk = np.diff(g[::40, :3, 3], 3, axis=0) / s[40] ** 3
        assert np.linalg.norm(jerk, axis=1).max() <= ToolDerivatives.along(arm, path).jerk[0] * (1.0 + 1e-3)
        world = (g[:-1, :3, :3] @ turn[..., None])[::40, :, 0]
        turn_jerk = np.linalg.norm(np.diff(world, 2, axis=0), axis=1).max() / s[40] ** 2
        assert turn_jerk <= ToolDerivatives.along(arm, path).turn_jerk[0] * (1.0 + 1e-3)


def seconds(arm: Arm, moving: MovingTarget, path: JointPath) -> tuple[float, float]:
    """The greatest second differences of p − p_c, along the axes of a TolerancedPose, and of the chord of R_cᵀ R."""
    step = 1e-3
    s = np.arange(0.0, 1.0 + step / 2, step)
    g, ideal = arm.fk(path(s)), moving.curve(s)
    apart = g[:, :3, 3] - ideal[:, :3, 3]
    axes = np.swapaxes(ideal[:, :3, :3], 1, 2)
    if isinstance(moving.like, TolerancedPose):
        apart = (axes @ apart[..., None])[..., 0]
    E = axes @ g[:, :3, :3] / np.sqrt(2.0)  # the Frobenius norm of E − 1 is 2 √2 sin(angle / 2)
    position, rotation = (np.diff(each, 2, axis=0).reshape(len(s) - 2, -1) / step**2 for each in (apart, E))
    return float(np.linalg.norm(position, axis=1).max()), float(np.linalg.norm(rotation, axis=1).max())
