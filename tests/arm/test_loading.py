"""Which base and tip, what arm.toml says, what the caller says, the proof at load; and the first arm.toml."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

import twistarm
from catalogue import load
from twistarm import Arm, JointLimits, load_arm
from twistarm.arm.loading.arm_file_draft import draft_arm_file
from twistarm.arm.loading.load import prove
from twistarm.support.errors import ComparisonError, DescriptionError, InputError, UnknownNameError
from urdf_text import joint, robot, two_joints, write

TOML = """
name = "ours"
source = "arm.urdf"
tip = "tool0"
[tool]
name = "pen"
xyz = [0.0, 0.0, 0.1]
rpy = [0.0, 1.5707963267948966, 0.0]
[limits.a]
velocity = 1.5
acceleration = 4.0
[poses.ready]
a = 0.1
b = -0.2
"""


def test_a_tip_that_does_not_exist_offers_the_closest(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints())
    with pytest.raises(UnknownNameError, match="tip='tool_0' is no link of tiny; closest: 'tool0'"):
        load_arm(path, tip="tool_0")
    with pytest.raises(UnknownNameError, match="base='base' is no link of tiny; closest: 'base_link'"):
        load_arm(path, base="base")


def test_a_base_beside_the_tip_is_refused(tmp_path: Path) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "tool0"), joint("c", "base_link", "mast")
    path = write(tmp_path, robot(*parts, links=("base_link", "upper", "tool0", "mast")))
    with pytest.raises(
        DescriptionError, match="base 'mast' is no ancestor of tip 'tool0'.*one of 'upper', 'base_link'"
    ):
        load_arm(path, base="mast", tip="tool0")


def test_an_arm_inside_a_rover_starts_at_its_base(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints(rpy="0.3 0.2 0.1")), base="upper")
    assert arm.joint_names == ("b",)
    assert np.allclose(arm.home[:3, 3], [0, 0, 0.5])
    # The joint's axis is z of its own frame, which is not turned against `upper`.
    assert np.allclose(arm.spatial_jacobian([0.4])[:, 0], [0, 0, 0, 0, 0, 1])


def test_an_unknown_name_offers_the_catalogue(tmp_path: Path) -> None:
    with pytest.raises(
        UnknownNameError, match="no arm 'rover_amr' in the catalogue, nor a file .*closest: 'rover_arm'"
    ):
        load_arm("rover_amr")
    write(tmp_path, "<package/>", "package.xml")
    mjcf = write(tmp_path, "<mujoco/>", "arm.xml")
    for path, why in (("nowhere/arm.urdf", "no such file"), ("/", "a folder"), (tmp_path, f"in it: '{mjcf.name}'$")):
        with pytest.raises(DescriptionError, match=why):
            load_arm(path)


def test_a_local_file_is_never_shadowed_by_the_catalogue(here: Path) -> None:
    write(here, two_joints(), "panda")
    assert load_arm("panda").name == "tiny"


def test_arm_toml(tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    path = write(tmp_path, TOML, "arm.toml")
    arm = load_arm(path)
    assert (arm.name, arm.tip) == ("ours", "pen")
    assert np.allclose(arm.home[:3, :], [[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 1.1]])
    assert arm.limits.velocity.tolist() == [1.5, 2.0]
    assert arm.limits.acceleration.tolist() == [4.0, np.inf]
    assert arm.ready.tolist() == [0.1, -0.2]
    assert load_arm(path, limits={"velocity": 1.0}).limits.velocity.tolist() == [1.0, 1.0]


BAD_TOML = {
    "not TOML": ("name = ", "not valid TOML"),
    "no source": ('name = "x"', "it names no source: write source ="),
    "a source that is not there": ('source = "other.urdf"', "source 'other.urdf' does not exist beside"),
    "a source that is a folder": ('source = "."', "source '.' is a folder"),
    "an unknown entry": ('source = "arm.urdf"\nbsae = "x"', "unknown entry 'bsae'; closest: 'base'"),
    "an unknown limit": ('source = "arm.urdf"\n[limits.a]\nspeed = 1', "unknown entry 'speed' in limits.a"),
    "a limit of an unknown joint": ('source = "arm.urdf"\n[limits.c]\nvelocity = 1', "no joint 'c' in limits"),
    "a pose without a joint": ('source = "arm.urdf"\n[poses.p]\na = 0.0', "poses.p: no value for joint 'b'"),
    "a pose of an unknown joint": ('source = "arm.urdf"\n[poses.p]\na = 0.0\nbb = 0.0', "no joint 'bb' in tiny"),
    "a pose outside the limits": (
        'source = "arm.urdf"\n[poses.p]\na = 3.0\nb = 0.0',
        "poses.p: a = 3 lies outside its limits [-1, 1]",
    ),
    "a tool without a name": ('source = "arm.urdf"\n[tool]\nxyz = [0.0, 0.0, 0.0]', "tool needs 'name'"),
    "a tool named as a link": (
        'source = "arm.urdf"\n[tool]\nname = "upper"',
        "tool.name 'upper' is a link already; name",
    ),
    "a base without a name": ('source = "arm.urdf"\nbase = ""', "base must not be empty; got ''"),
    "a joint locked out of this world": (
        'source = "arm.urdf"\nlocked_joints = { a = -1e300 }',
        "locked_joints.a must be",
    ),
    "several places of one tool": (
        'source = "arm.urdf"\n[tool]\nname = "t"\nxyz = [[0, 0, 0], [0, 0, 1]]',
        "tool.xyz must be",
    ),
    "package dirs that are not there": (
        'source = "arm.urdf"\npackage_dirs = ["no_such"]',
        "package_dirs 'no_such' does not exist beside it",
    ),
    "a file that is no arm.toml": ("# \n" * 40000, "it has 120,000 bytes; at most 64,000 are"),
}


@pytest.mark.parametrize("case", BAD_TOML)
def test_bad_arm_toml_in_one_line(case: str, tmp_path: Path) -> None:
    text, message = BAD_TOML[case]
    write(tmp_path, two_joints())
    with pytest.raises((DescriptionError, UnknownNameError)) as caught:
        load_arm(write(tmp_path, text, "arm.toml"))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_tool_turned_by_degrees_is_a_finding(tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    arm = load_arm(write(tmp_path, 'source = "arm.urdf"\n[tool]\nname = "pen"\nrpy = [0, 90, 0]\n', "arm.toml"))
    assert [finding.code for finding in arm.findings] == ["unit-doubtful"]
    assert "tool.rpy" in arm.findings[0].what


def test_limits_by_the_caller(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints())
    arm = load_arm(path, limits={"acceleration": 3, "velocity": {"b": 0.5}})
    assert arm.limits.acceleration.tolist() == [3, 3]
    assert arm.limits.velocity.tolist() == [2.0, 0.5]
    with pytest.raises(UnknownNameError, match="no limit 'speed' in JointLimits"):
        load_arm(path, limits={"speed": 1})
    with pytest.raises(InputError, match="limits of a are swapped or disjoint"):
        load_arm(path, limits={"lower": 2.0})


def test_a_locked_joint_stands_still(tmp_path: Path) -> None:
    path = write(tmp_path, two_joints(inside='<axis xyz="0 1 0"/>'))
    free, locked = load_arm(path), load_arm(path, locked_joints={"a": 0.4})
    assert locked.joint_names == ("b",)
    assert np.allclose(locked.fk([0.3]), free.fk([0.4, 0.3]), atol=1e-14)
    with pytest.raises(UnknownNameError, match="no moving joint 'c' in tiny, for locked_joints="):
        load_arm(path, locked_joints={"c": 0.0})


def test_what_is_locked_outside_its_limits_is_said(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints()), locked_joints={"a": 50})
    assert [finding.code for finding in arm.findings] == ["outside-limits"]
    with pytest.raises(InputError, match=r"locked_joints\['a'\]"):
        load_arm(tmp_path / "arm.urdf", locked_joints={"a": np.inf})
    with pytest.raises(InputError, match=r"locked_joints\['a'\]"):
        load_arm(tmp_path / "arm.urdf", locked_joints={"a": "x"})  # type: ignore[dict-item]


def test_a_joint_that_mimics_one_above_the_base(tmp_path: Path) -> None:
    """The master carries base and tip alike; only the follower moves one against the other."""
    parts = (
        joint("a", "base_link", "upper", inside='<axis xyz="0 1 0"/>'),
        joint("b", "upper", "fore", inside='<axis xyz="1 0 0"/><mimic joint="a" multiplier="0.5"/>'),
        joint("c", "fore", "tool0"),
    )
    path = write(tmp_path, robot(*parts, links=("base_link", "upper", "fore", "tool0")))
    arm = load_arm(path, base="upper")
    assert arm.joint_names == ("a", "c")
    whole = load_arm(path)
    relative = np.linalg.inv(whole.pose([0.6, 0.2], "upper")) @ whole.fk([0.6, 0.2])
    assert np.allclose(arm.fk([0.6, 0.2]), relative, atol=1e-14)


def test_a_follower_keeps_its_master_inside_its_own_limits(tmp_path: Path) -> None:
    limit = '<limit lower="{}" upper="{}" velocity="1" effort="1"/>'
    parts = (
        joint("a", "base_link", "upper"),
        joint("b", "upper", "tool0", inside='<mimic joint="a" multiplier="-2" offset="0.2"/>' + limit.format(-1, 1)),
    )
    arm = load_arm(write(tmp_path, robot(*parts)))
    assert np.allclose([arm.limits.lower[0], arm.limits.upper[0]], [-0.4, 0.6])
    assert [finding.code for finding in arm.findings] == ["limits-adjusted"]
    text = robot(*parts).replace('lower="-1" upper="1" velocity="1"', 'lower="0" upper="0" velocity="1"')
    arm = load_arm(write(tmp_path, text))
    assert [arm.limits.lower[0], arm.limits.upper[0]] == [-1, 1]
    assert "outside-limits" in [finding.code for finding in arm.findings]


WRONG_TYPES = {
    "a source that is none": ({"source": None}, "source must be a path or a name; got None"),
    "a tip that is a number": ({"tip": 3}, "tip must be the name of a link; got 3"),
    "an empty base": ({"base": " "}, "base must be the name of a link; got ' '"),
    "limits of another arm": ({"limits": JointLimits.unbounded(3)}, "limits must be those of 2 joints"),
    "a limit in words": ({"limits": {"velocity": "fast"}}, "velocity.*got 'fast'"),
}


@pytest.mark.parametrize("case", WRONG_TYPES)
def test_wrong_types_are_input_errors(case: str, tmp_path: Path) -> None:
    arguments, message = WRONG_TYPES[case]
    path = write(tmp_path, two_joints())
    with pytest.raises(InputError, match=message):
        load_arm(**{"source": path, **arguments})


def test_the_proof_catches_screws_that_are_not_the_description(tmp_path: Path) -> None:
    arm = load_arm(write(tmp_path, two_joints()))
    assert arm.proof is not None
    assert arm.proof.pose_error < 1e-14
    wrong = dataclasses.replace(arm, home=arm.home + np.outer([1e-6, 0, 0, 0], [0, 0, 0, 1]))
    with pytest.raises(ComparisonError, match="product of exponentials and Pinocchio disagree by 9.9e-07"):
        prove(wrong)


REAL = {
    "slider": ("robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro", {}, "tool0", 5),
    "walli v3": ("robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf", {}, "claw", 6),
    "walli v2": ("robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf", {}, "ee", 5),
    "ur5e": ("ur_description/urdf/ur.urdf.xacro", {"name": "ur", "ur_type": "ur5e"}, "tool0", 6),
    "so101": ("so101/so101_new_calib.urdf", {}, "gripper_frame_link", 5),
    "ar4": ("annin_ar4_description/urdf/ar.urdf.xacro", {"ar_model": "mk3"}, "ee_link", 6),
    "gen3": ("kortex_description/robots/gen3.xacro", {"dof": "7"}, "tool_frame", 7),
    "gen3_lite": ("kortex_description/robots/gen3_lite.urdf", {}, "tool_frame", 6),
}
"""Real arms under TWISTARM_MODELS: file, xacro arguments, tip, degrees of freedom."""


@pytest.mark.parametrize("name", REAL)
def test_real_arms_load_from_any_working_directory(name: str, models: Path, here: Path) -> None:
    file, arguments, tip, n = REAL[name]
    arm = load_arm(models / file, xacro_args=arguments, tip=tip)
    assert (arm.n, arm.tip) == (n, tip)


if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

OWN = ("rover_arm", "scara", "stanford")


def same(arm: Arm, other: Arm) -> None:
    assert (arm.name, arm.base, arm.tip, arm.joint_names) == (other.name, other.base, other.tip, other.joint_names)
    assert arm.limits.lower.tolist() == other.limits.lower.tolist()
    assert arm.limits.velocity.tolist() == other.limits.velocity.tolist()
    assert np.array_equal(arm.home, other.home)
    assert np.array_equal(arm.screws, other.screws)
    assert np.array_equal(arm.ready, other.ready)
    assert arm.disabled_collisions == other.disabled_collisions
    theta = other.random_theta(np.random.default_rng(1), 3)
    assert np.allclose(arm.fk(theta), other.fk(theta), atol=1e-14)


@pytest.mark.parametrize("name", REAL)
def test_real_arms_load_from_their_draft_as_the_same(name: str, models: Path, tmp_path: Path) -> None:
    file, arguments, tip, n = REAL[name]
    draft = draft_arm_file(models / file, tmp_path, tip=tip, xacro_args=arguments)
    arm = load_arm(write(tmp_path, draft, "arm.toml"))
    assert arm.n == n
    same(arm, load_arm(models / file, tip=tip, xacro_args=arguments))


@pytest.mark.parametrize("name", OWN)
def test_our_own_descriptions_without_their_arm_toml(name: str, tmp_path: Path) -> None:
    description = load(name).description
    assert description is not None
    assert description.path is not None
    tip = load(name).tip_link
    draft = draft_arm_file(description.path, tmp_path, tip=tip)
    same(load_arm(write(tmp_path, draft, "arm.toml")), load_arm(description.path, tip=tip))


def test_what_stands_in_it(tmp_path: Path) -> None:
    limit = '<limit lower="0" upper="0" velocity="0" effort="3"/>'
    write(tmp_path, two_joints(inside=limit))
    (tmp_path / "config").mkdir()
    state = '<group_state name="home"><joint name="a" value="0"/><joint name="b" value="0.5"/></group_state>'
    write(tmp_path / "config", f'<robot name="tiny">{state}</robot>', "arm.srdf")
    write(tmp_path / "config", "joint_limits: {}", "joint_limits.yaml")
    text = draft_arm_file(tmp_path / "arm.urdf", tmp_path)
    content = tomllib.loads(text)
    assert content["name"] == "tiny"
    assert (content["source"], content["base"], content["tip"]) == ("arm.urdf", "base_link", "tool0")
    assert set(content) == {"name", "source", "base", "tip", "limits", "poses"}
    arm = load_arm(tmp_path / "arm.urdf")
    assert content["poses"]["ready"] == dict(zip(("a", "b"), arm.ready.tolist(), strict=True))
    for line in ('# joint_limits = "config/joint_limits.yaml"', "# a.velocity = ?"):
        assert line in text
    assert "# b.velocity" not in text


def test_xacro_arguments_with_defaults_and_the_required_ones(tmp_path: Path) -> None:
    body = two_joints().replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    arguments = '<xacro:arg name="model" default=""/><xacro:arg name="side" default="le&quot;ft"/>'
    use = '<link name="$(arg model)$(arg needed)"/><joint name="m" type="fixed"><parent link="tool0"/>'
    use += '<child link="$(arg model)$(arg needed)"/></joint>'
    path = write(tmp_path, body.replace("</robot>", arguments + use + "</robot>"), "arm.urdf.xacro")
    with pytest.raises(DescriptionError, match="xacro_args=.*needed"):
        draft_arm_file(path, tmp_path)
    draft = draft_arm_file(path, tmp_path, xacro_args={"needed": "x\\1", "model": "mk3"})
    content = tomllib.loads(draft)
    assert content["xacro_args"] == {"model": "mk3", "needed": "x\\1"}
    assert '# side = "le\\"ft"' in draft
    assert "mk3x\\1" in load_arm(write(tmp_path, draft, "arm.toml")).frame_names


def test_paths_are_written_from_the_folder_it_stands_in(tmp_path: Path) -> None:
    folders = tmp_path / "description", tmp_path / "team" / "arm"
    for folder in folders:
        folder.mkdir(parents=True)
    path = write(folders[0], two_joints())
    text = draft_arm_file(path, folders[1], package_dirs=[tmp_path / "description"])
    content = tomllib.loads(text)
    assert content["source"] == "../../description/arm.urdf"
    assert content["package_dirs"] == ["../../description"]
    assert load_arm(write(folders[1], text, "arm.toml")).n == 2


def test_what_it_cannot_work_with(tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    toml = write(tmp_path, 'source = "arm.urdf"', "arm.toml")
    with pytest.raises(InputError, match="arm.toml is an arm.toml already; give the URDF or xacro file"):
        draft_arm_file(toml)
    with pytest.raises(DescriptionError, match="no such file"):
        draft_arm_file(tmp_path / "no.urdf")
    with pytest.raises(twistarm.UnknownNameError, match="tip='tool9' is no link of"):
        draft_arm_file(tmp_path / "arm.urdf", tip="tool9")
