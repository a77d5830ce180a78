"""Speeds of the tool along joint paths: no finite difference exceeds the greatest one."""

from __future__ import annotations

import numpy as np
import pytest

from catalogue import load
from twistarm import arm_from_screws, load_arm, rotations
from twistarm.arm.arm import Arm
from twistarm.planning.joint_path import JointPath
from twistarm.planning.stretches import greatest_tool_speeds

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
def test_no_speed_of_the_tool_exceeds_its_bound_and_some_come_near(kind, tmp_path):
    arm, rng = arms(tmp_path)[kind], np.random.default_rng(6)
    for _ in range(20):
        scale = np.array([2.0, 2.0, 2.0, 1.0])[:, None, None]
        path = JointPath(np.array([0.0, 0.2]), rng.uniform(-1.0, 1.0, (4, 1, arm.n)) * scale)
        s = np.linspace(0.0, 0.2, 2001)
        g = arm.fk(path(s))
        velocity = np.gradient(g[:, :3, 3], s, axis=0)[1:-1]
        turn = rotations.log(np.swapaxes(g[:-1, :3, :3], 1, 2) @ g[1:, :3, :3]) / s[1]
        seen = np.array([np.linalg.norm(velocity, axis=1).max(), np.linalg.norm(turn, axis=1).max()])
        greatest = np.array([each[0] for each in greatest_tool_speeds(arm, path)])
        assert (seen <= greatest * (1.0 + 1e-5)).all()
        assert (seen >= greatest * (1.0 - 1e-3)).all()
