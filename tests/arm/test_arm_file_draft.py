"""The first arm.toml: it loads as the same arm, says what was found, and leaves open what only the team knows."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import twistarm
from catalogue import load
from test_loading import REAL
from twistarm import Arm, DescriptionError, InputError, load_arm
from twistarm.arm.loading.arm_file_draft import draft_arm_file
from urdf_text import joint, robot, two_joints, write

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


def test_without_a_clear_tip_the_error_is_that_of_loading(tmp_path: Path) -> None:
    parts = joint("a", "base_link", "upper"), joint("b c", "upper", "left"), joint("d", "upper", "right tip")
    write(tmp_path, robot(*parts, links=("base_link", "upper", "left", "right tip")))
    with pytest.raises(DescriptionError) as caught:
        draft_arm_file(tmp_path / "arm.urdf", tmp_path)
    assert caught.value.findings[0].code == "no-tip"
    draft = draft_arm_file(tmp_path / "arm.urdf", tmp_path, tip="left")
    assert load_arm(write(tmp_path, draft, "arm.toml")).joint_names == ("a", "b c")


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
    with pytest.raises(twistarm.UnknownNameError, match="no link for tip= 'tool9'"):
        draft_arm_file(tmp_path / "arm.urdf", tip="tool9")
