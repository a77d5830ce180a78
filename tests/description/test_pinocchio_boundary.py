"""What plain Pinocchio refuses without a cause, or gets silently wrong, and what the user gets here instead.

Each test shows Pinocchio's side on the file as it is, then ours, judged by a reading of the XML that shares no code
with either. What is refused by name stands in test_urdf.py.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from fuzz import reader
from twistarm import Arm, crosscheck, load_arm
from twistarm.support.errors import DescriptionError
from urdf_text import joint, robot, two_joints, write

GENERIC = "The XML stream does not contain a valid URDF model."


def pinocchio_refuses(path: Path) -> bool:
    """With the one sentence that names neither joint nor cause."""
    with pytest.raises(ValueError, match=GENERIC):
        pinocchio.buildModelFromXML(path.read_text("utf-8"))
    return True


def right(arm: Arm, path: Path, seed: int = 0) -> bool:
    """The cross-check holds, and the tool stands where the second reading puts it."""
    assert crosscheck(arm, 5).require().ok
    robot = reader.parsed(path.read_bytes())
    postures = arm.random_theta(np.random.default_rng(seed), 5)
    expected = [reader.pose(robot, arm.theta_to_dict(theta), arm.base, arm.tip) for theta in postures]
    return np.allclose(arm.fk(postures), expected, atol=1e-12)


UNLIMITED = {
    "no limit at all": ("", [-np.inf, np.inf, np.inf, np.inf], "no <limit>; unbounded both ways"),
    "no velocity": (
        '<limit lower="-1" upper="1" effort="3"/>',
        [-1, 1, np.inf, 3],
        "velocity limit absent or 0 on a: counts as missing",
    ),
    "no effort": (
        '<limit lower="-1" upper="1" velocity="2"/>',
        [-1, 1, 2, np.inf],
        "effort limit absent or 0 on a: counts as missing",
    ),
    "infinite bounds": ('<limit lower="-inf" upper="inf" velocity="2" effort="3"/>', [-np.inf, np.inf, 2, 3], ""),
}


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize("case", UNLIMITED)
def test_limits_that_pinocchio_refuses_are_read_as_meant(case: str, kind: str, tmp_path: Path) -> None:
    limit, expected, said = UNLIMITED[case]
    text = two_joints(kind=kind).replace('<limit lower="-1" upper="1" velocity="2" effort="3"/>', limit, 1)
    path = write(tmp_path, text)
    assert pinocchio_refuses(path)
    arm = load_arm(path)
    limits = arm.limits
    assert [limits.lower[0], limits.upper[0], limits.velocity[0], limits.effort[0]] == expected
    assert said in " ".join(map(str, arm.findings))
    assert right(arm, path)


NO_NUMBERS = ("pi/2", "1,57", "", "1_000", "\u0661")


@pytest.mark.parametrize("number", NO_NUMBERS)
@pytest.mark.parametrize("name", ["lower", "effort"])
def test_a_limit_that_is_no_number_is_named(name: str, number: str, tmp_path: Path) -> None:
    given = {"lower": "-1", "upper": "1", "velocity": "1", "effort": "1"} | {name: number}
    limit = " ".join(f'{attribute}="{value}"' for attribute, value in given.items())
    path = write(tmp_path, two_joints(inside=f"<limit {limit}/>"))
    assert pinocchio_refuses(path)
    with pytest.raises(DescriptionError, match="arm.urdf:2: joint 'a': ") as refused:
        load_arm(path)
    assert name in str(refused.value)
    assert repr(number) in str(refused.value)
    assert GENERIC not in str(refused.value)


INERTIAL = (
    '<inertial><origin xyz="1 0 0"/><mass value="{}"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def with_inertial(folder: Path, inertial: str) -> Path:
    """Two joints, the first about y, its link with a body 1 m in front of the axis."""
    text = two_joints(inside='<axis xyz="0 1 0"/>')
    return write(folder, text.replace('<link name="upper"/>', f'<link name="upper">{inertial}</link>'))


NO_MASSES = ("1kg", "", "1_0", "1 1")


@pytest.mark.parametrize("mass", NO_MASSES)
def test_a_mass_that_is_no_number_weighs_nothing_and_is_said(mass: str, tmp_path: Path) -> None:
    path = with_inertial(tmp_path, INERTIAL.format(mass))
    assert pinocchio.buildModelFromUrdf(str(path)).inertias[1].mass == 0.0
    arm = load_arm(path)
    assert [finding.code for finding in arm.findings] == ["inertial-unusable"]
    assert "link 'upper': its <inertial> is malformed" in str(arm.findings[0])
    assert arm.inverse_dynamics([0.0, 0.0])[0] == 0.0


@pytest.mark.parametrize("mass", ["2", " 2", "2 ", "\n2\t", "+2.", "2e0"])
def test_a_mass_with_space_around_it_weighs_what_it_says(mass: str, tmp_path: Path) -> None:
    path = with_inertial(tmp_path, INERTIAL.format(mass))
    if mass != mass.rstrip():
        assert pinocchio.buildModelFromUrdf(str(path)).inertias[1].mass == 0.0
    arm = load_arm(path)
    assert arm.findings == ()
    # 2 kg, 1 m in front of the axis; the axis is y, gravity along −z.
    assert arm.inverse_dynamics([0.0, 0.0])[0] == pytest.approx(-2 * 9.81)


MIMICS = {
    "a master further out": ("revolute", "z", 1.5, "revolute"),
    "a continuous follower": ("continuous", "m", 2.0, "revolute"),
    "a continuous pair": ("continuous", "z", 2.0, "continuous"),
    "a sliding follower of an angle": ("prismatic", "m", 0.1, "revolute"),
}
"""Follower's type, master, multiplier, type of the joint z; m is the first joint, z the last."""


@pytest.mark.parametrize("case", MIMICS)
def test_mimics_wherever_the_master_stands(case: str, tmp_path: Path) -> None:
    follower, master, multiplier, kind = MIMICS[case]
    mimic = f'<axis xyz="1 0 0"/><mimic joint="{master}" multiplier="{multiplier}" offset="0.2"/>'
    parts = (
        joint("m", "base_link", "upper", inside='<axis xyz="0 1 0"/>'),
        joint("a", "upper", "fore", follower, mimic),
        joint("z", "fore", "tool0", kind, inside='<axis xyz="0 1 0"/>'),
    )
    path = write(tmp_path, robot(*parts, links=("base_link", "upper", "fore", "tool0")))
    arm = load_arm(path)
    assert set(arm.joint_names) == {"m", "z"}
    assert right(arm, path)


def test_two_of_what_there_may_be_one_is_the_first_for_everybody(tmp_path: Path) -> None:
    """A second origin, axis or limit is read by neither engine."""
    again = '<origin xyz="9 9 9"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" velocity="9" effort="9"/>'
    text = two_joints().replace("</joint>", f"{again}</joint>", 1)
    path = write(tmp_path, text)
    arm = load_arm(path)
    assert arm.limits.upper[0] == 1
    assert right(arm, path)
    model = pinocchio.buildModelFromUrdf(str(path))
    assert model.upperPositionLimit[0] == 1
    assert model.jointPlacements[1].translation.tolist() == [0, 0, 0.5]


def test_the_root_is_the_base_whatever_its_name(tmp_path: Path) -> None:
    parts = joint("mount", "world", "base_link", kind="fixed"), joint("a", "base_link", "tool0")
    path = write(tmp_path, robot(*parts, links=("tool0", "base_link", "world")))
    assert load_arm(path).base == "world"
    assert np.allclose(load_arm(path, base="base_link").home[:3, 3], [0, 0, 0.5])


def test_theta_runs_base_to_tip_whatever_the_file_or_the_alphabet_says(tmp_path: Path) -> None:
    """The first joint is continuous and drives a revolute one, which Pinocchio's own mimic refuses."""
    wide = '<limit lower="-9" upper="9" velocity="1" effort="1"/><axis xyz="1 0 0"/>'
    parts = (
        joint("a_last", "fore", "tool0", inside='<axis xyz="1 0 0"/>'),
        joint("m_middle", "upper", "fore", inside='<axis xyz="0 1 0"/>'),
        joint("b_follows", "lower", "upper", inside=wide + '<mimic joint="z_first" multiplier="0.5"/>'),
        joint("z_first", "base_link", "lower", kind="continuous"),
    )
    path = write(tmp_path, robot(*parts, links=("tool0", "upper", "fore", "base_link", "lower")))
    arm = load_arm(path)
    assert arm.joint_names == ("z_first", "m_middle", "a_last")
    assert right(arm, path)
    assert arm.theta_from(["a_last", "z_first", "m_middle"], [3.0, 1.0, 2.0]).tolist() == [1.0, 2.0, 3.0]


def test_a_joint_may_have_the_name_of_a_link(tmp_path: Path) -> None:
    parts = joint("upper", "base_link", "upper"), joint("tool0", "upper", "tool0", inside='<axis xyz="1 0 0"/>')
    path = write(tmp_path, robot(*parts))
    arm = load_arm(path)
    assert right(arm, path)
    upper = reader.pose(reader.parsed(path.read_bytes()), {"upper": 0.2}, "base_link", "upper")
    assert np.allclose(arm.pose([0.2, 0.4], "upper"), upper)


def test_two_arms_in_one_file(tmp_path: Path) -> None:
    links = ("torso", *(f"{side}_{part}" for side in ("left", "right") for part in ("upper", "tcp")))
    parts = [
        joint(f"{side}_{name}", parent, f"{side}_{child}", xyz=f"0 {y} 0", inside=f'<axis xyz="{axis}"/>')
        for side, y in (("left", 0.3), ("right", -0.3))
        for name, parent, child, axis in (
            ("shoulder", "torso", "upper", "0 1 0"),
            ("elbow", f"{side}_upper", "tcp", "1 0 0"),
        )
    ]
    path = write(tmp_path, robot(*parts, links=links))
    arm = load_arm(path, tip="right_tcp")
    assert arm.joint_names == ("right_shoulder", "right_elbow")
    assert right(arm, path)
    left = reader.pose(reader.parsed(path.read_bytes()), {"left_shoulder": 0.4}, "torso", "left_tcp")
    assert np.allclose(arm.poses([0.0, 0.0], other_joints={"left_shoulder": 0.4})["left_tcp"], left)
