"""The doctor's findings: all of them, the gravest first, for real arms too, and no false alarms."""

from __future__ import annotations

from pathlib import Path

import pytest

import twistarm
from diagnosing import codes
from finding_cases import CASES
from test_finding_codes import lay
from twistarm import Arm, InputError, UnknownNameError, diagnose
from twistarm.checking.doctor import examine
from urdf_text import joint, robot, two_joints, write

WARNED = {"kinova", "so100"}
"""Of one a state of its SRDF lies outside the limits; the other has no tool frame."""


@pytest.mark.parametrize("name", twistarm.available_arms())
def test_no_false_alarm_about_the_catalogue(name: str) -> None:
    findings = diagnose(name)
    assert all(one.severity != "error" for one in findings)
    assert (name in WARNED) == any(one.severity == "warning" for one in findings)
    assert len(findings) <= 6


def test_an_arm_is_taken_too(rover: Arm, tmp_path: Path) -> None:
    assert codes(rover) == codes("rover_arm")
    with pytest.raises(InputError, match="an Arm is loaded already and takes no tip"):
        diagnose(rover, tip="tool0")


def test_arguments_raise_where_arm_toml_is_diagnosed(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="no arm 'rover_amr' in the catalogue"):
        diagnose("rover_amr")
    path = write(tmp_path, two_joints())
    with pytest.raises(UnknownNameError, match="no link for tip= 'tool'"):
        diagnose(path, tip="tool")
    write(tmp_path, 'source = "arm.urdf"\ntip = "tool"\n', "arm.toml")
    (said,) = [one for one in diagnose(tmp_path / "arm.toml") if one.severity == "error"]
    assert said.code == "companion-unusable"
    assert "closest: 'tool0'" in said.what


def test_a_tool_given_in_the_arm_toml_is_a_tool(tmp_path: Path) -> None:
    assert "tool-frame-missing" not in codes(write(tmp_path, two_joints()))
    path = write(tmp_path, two_joints().replace("tool0", "flange"))
    (said,) = [one for one in diagnose(path) if one.code == "tool-frame-missing"]
    _, _, snippet = said.remedy.partition("\n")
    write(tmp_path, f'source = "arm.urdf"\n{snippet}\n', "arm.toml")
    assert "tool-frame-missing" not in codes(tmp_path / "arm.toml")


def test_a_slide_at_the_end_has_its_tool(tmp_path: Path) -> None:
    """Its frame moves along the axis, not on it: where the arm grips is no less said than with a tool."""
    for kind, told in ("revolute", True), ("prismatic", False):
        parts = joint("a", "base_link", "upper"), joint("b", "upper", "flange", kind)
        path = write(tmp_path, robot(*parts, links=("base_link", "upper", "flange")))
        assert ("tool-frame-missing" in codes(path)) == told


def test_other_ends_are_told_only_where_nobody_said_which(tmp_path: Path) -> None:
    path = lay(CASES["several-tips"], tmp_path)
    assert "several-tips" in codes(path)
    assert "several-tips" not in codes(path, tip="tool0")
    assert examine(path, tip="tool0").arm is not None


# -- real arms -----------------------------------------------------------------------------------------------------

REAL = {
    "robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro": (
        {}, {"home-singular", "cannot-turn-in-place", "several-tips"}
    ),
    "robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf": (
        {},
        {"mesh-missing", "rate-not-given", "outside-limits", "tool-frame-missing"},
    ),
    "robojackets_walli_v2_block/urdf/walli_arm_v2_block/robot.urdf": (
        {}, {"limit-incomplete", "mass-missing", "axes-almost-exact", "home-singular", "cannot-turn-in-place"}
    ),
    "so101/so101_new_calib.urdf": ({}, {"mesh-missing", "cannot-turn-in-place", "off-the-chain", "several-tips"}),
    "kortex_description/robots/gen3.xacro": ({"xacro_args": {"dof": 7}}, {"mesh-missing", "axes-almost-exact"}),
    "robojackets_walliiarmv3/urc_arm_moveit_config/config/WalliiArmV3.urdf.xacro": ({}, {"package-without-manifest"}),
    "kortex_description/robots/kinova.urdf.xacro": (
        {
            "xacro_args": {"name": "gen3", "arm": "gen3", "gripper": "robotiq_2f_85"},
            "ignore_packages": "robotiq_description",
        },
        {"package-left-out"},
    ),
}  # fmt: skip
REFUSED = {
    "kortex_description/robots/gen3_lite_gen3_lite_2f.xacro": ({}, "xacro-failed", 'Invalid parameter "gripper"'),
    "kortex_description/robots/gen3.xacro": ({}, "xacro-failed", "arms/gen3/dof/"),
    "annin_ar4_description/urdf/ar.urdf.xacro": ({}, "xacro-arguments", "ar_model"),
    "annin_ar4_description/urdf/ar_gazebo.urdf.xacro": (
        {"xacro_args": {"ar_model": "mk3"}}, "package-needed-not-found", "annin_ar4_driver"
    ),
}  # fmt: skip


@pytest.mark.parametrize("file", REAL)
def test_real_arms_get_a_page_without_errors(file: str, models: Path) -> None:
    load, expected = REAL[file]
    findings = diagnose(models / file, **load)  # type: ignore[arg-type]
    assert expected <= {one.code for one in findings}
    assert not [one for one in findings if one.severity == "error"]


@pytest.mark.parametrize("file", REFUSED)
def test_real_descriptions_that_fail_get_the_error_that_says_why(file: str, models: Path) -> None:
    load, code, words = REFUSED[file]
    first = diagnose(models / file, **load)[0]  # type: ignore[arg-type]
    assert (first.code, first.severity) == (code, "error")
    assert words in first.what
