"""The kinematics that a stand-alone page is given, evaluated by matrix exponentials: the links are at arm.poses."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.linalg import expm

from twistarm import Arm, arm_from_screws, joints, load_arm
from twistarm.viewer.parts.arm_data import extra_joints
from twistarm.viewer.scene.drawing import link_path
from twistarm.viewer.scene.kinematics import kinematics
from viewer_page import matrix

TOL = 1e-9

BRANCHED = """<robot name="branched">
  <link name="root"/><link name="mast"/><link name="base_link"/><link name="upper"/><link name="rod"/>
  <link name="tool0"/><link name="left"/><link name="right"/><link name="bogie"/>
  <joint name="lift" type="prismatic"><parent link="root"/><child link="mast"/><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.5" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="mast"/><child link="base_link"/>
    <origin xyz="0 0.1 0" rpy="0 0 0.4"/><axis xyz="0 1 0"/></joint>
  <joint name="a" type="revolute"><parent link="base_link"/><child link="upper"/><origin xyz="0 0 0.3" rpy="0 0.7 0"/>
    <axis xyz="0.6 0 0.8"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="rod"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/><mimic joint="a" multiplier="-0.5" offset="0.3"/></joint>
  <joint name="c" type="prismatic"><parent link="rod"/><child link="tool0"/><origin xyz="0.2 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0.1" upper="0.6" velocity="1" effort="1"/></joint>
  <joint name="finger" type="prismatic"><parent link="tool0"/><child link="left"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/></joint>
  <joint name="follower" type="prismatic"><parent link="tool0"/><child link="right"/><axis xyz="0 -1 0"/>
    <limit lower="0" upper="0.04" velocity="1" effort="1"/><mimic joint="finger"/></joint>
  <joint name="wheel" type="continuous"><parent link="root"/><child link="bogie"/><origin xyz="0 0 -0.1"/>
    <axis xyz="0 1 0"/></joint>
</robot>"""


def placed(told: Any, coordinates: Any) -> dict[str, NDArray[np.float64]]:
    """Every node at the coordinates: theta, then the joints beside the chain."""
    moved: list[NDArray[np.float64]] = []
    for joint in told["joints"]:
        v, w = np.array(joint["screw"][:3]), np.array(joint["screw"][3:])
        xi = np.zeros((4, 4))
        xi[:3, :3], xi[:3, 3] = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]]), v
        step = expm(xi * sum(factor * coordinates[i] for i, factor in joint["terms"]))
        moved.append(step if joint["parent"] is None else moved[joint["parent"]] @ step)
    moved.append(np.eye(4))
    base = np.linalg.inv(moved[-1 if told["base"] is None else told["base"]])
    return {
        path: base @ moved[-1 if node["joint"] is None else node["joint"]] @ matrix(node["rest"])
        for path, node in told["nodes"].items()
    }


def assert_poses(arm: Arm, *, count: int = 3) -> None:
    rng = np.random.default_rng(5)
    beside = extra_joints(arm)
    told = kinematics(arm, list(beside))
    for _ in range(count):
        theta = arm.random_theta(rng)
        others = {name: float(np.clip(rng.normal(), joint.lower, joint.upper)) for name, joint in beside.items()}
        poses, nodes = arm.poses(theta, others), placed(told, [*theta, *others.values()])
        assert_allclose(nodes["/frames/tool"], poses[arm.tip], atol=TOL)
        for name in () if arm.description is None else arm.description.links:
            assert_allclose(nodes[link_path(name)], poses[name], atol=TOL, err_msg=name)


def test_of_every_arm_of_the_catalogue(catalogue_arm: Arm) -> None:
    assert_poses(catalogue_arm)


@pytest.mark.parametrize("locked", [{}, {"b": 0.4}])
def test_a_base_that_is_carried_followers_and_joints_beside_the_chain(tmp_path: Path, locked: Any) -> None:
    path = tmp_path / "branched.urdf"
    path.write_text(BRANCHED)
    for base in ("root", "base_link"):
        arm = load_arm(path, base=base, tip="tool0", locked_joints=locked)
        assert_poses(arm)
    assert {"lift", "turn", "finger", "wheel"} == set(extra_joints(arm))


def test_an_arm_of_screws_with_a_thread_and_a_ball() -> None:
    parts = [joints.helical([0, 0, 1], [0.1, 0, 0], 0.05), joints.spherical([0.3, 0, 0.1]), joints.prismatic([1, 0, 0])]
    home = np.eye(4)
    home[:3, 3] = 0.6, 0.1, 0.2
    arm = arm_from_screws(np.column_stack(parts), home)
    told = kinematics(arm, [])
    theta = np.linspace(-0.7, 0.9, arm.n)
    nodes = placed(told, theta)
    assert_allclose(nodes["/frames/tool"], arm.fk(theta), atol=TOL)
    assert set(nodes) == {"/frames/tool", *(f"/{kind}:{i}" for i in range(5) for kind in ("screws/screw", "arm/rod"))}
