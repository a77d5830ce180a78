"""Descriptions that ask for packages which are not there, and the arm can do without: a camera's, a simulator's."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from hostile.sandbox import XMLNS
from twistarm import diagnose, load_arm
from twistarm.arm.arm import Arm
from twistarm.cli.application import run
from twistarm.support.errors import DescriptionError, InputError
from twistarm.testing import assert_arm
from urdf_text import joint, write
from xacro_text import ARM, as_xacro

INCLUDE = '<xacro:include filename="$(find realsense2_description)/urdf/_d435.urdf.xacro"/>'
CAMERA = (
    '<xacro:sensor_d435 parent="tool0" topics_ns="${camera_name}"><origin xyz="0 ${d435_y} 0"/></xacro:sensor_d435>'
)

LEFT_OUT: dict[str, tuple[str, tuple[str, ...]]] = {
    "a camera's macro with a block": (
        INCLUDE + CAMERA,
        ("include of '_d435.urdf.xacro'", "call of the macro 'sensor_d435'"),
    ),
    "an include that the missing one would have made": (
        '<xacro:include filename="camera.xacro"/><xacro:camera/>',
        ("include of '_d435.urdf.xacro'", "call of the macro 'sensor_d435'"),
    ),
    "a macro called by its name in a property": (
        INCLUDE + '<xacro:property name="kind" value="d435"/><xacro:call macro="sensor_${kind}" parent="tool0"/>',
        ("call of the macro 'sensor_d435'",),
    ),
    "a call inside another that is left out": (
        INCLUDE + "<xacro:mount><xacro:sensor_d435/></xacro:mount>",
        ("call of the macro 'mount'",),
    ),
    "a plugin with a value that is not there": (
        INCLUDE + '<gazebo reference="tool0"><plugin name="cam" rate="${d435_rate}"/></gazebo>',
        ("<gazebo> is left out: name 'd435_rate' is not defined",),
    ),
    "a shape with a value that is not there": (
        INCLUDE + '<link name="stand"><visual><geometry><sphere radius="${d435_size}"/></geometry></visual></link>'
        '<joint name="s" type="fixed"><parent link="tool0"/><child link="stand"/></joint>',
        ("<visual> is left out: name 'd435_size' is not defined",),
    ),
    "parameters in YAML": (
        '<xacro:property name="c" value="${xacro.load_yaml(\'$(find realsense2_description)/config/d435.yaml\')}"/>'
        '<ros2_control name="camera"><param name="r">${c["rate"]}</param></ros2_control>',
        (
            "'d435.yaml' counts as empty",
            "<ros2_control name='camera'> is left out: The yaml dictionary has no key 'rate'",
        ),
    ),
    "a path instead of $(find …)": (
        '<xacro:include filename="../../realsense2_description/urdf/d435.xacro"/>',
        ("include of 'd435.xacro'",),
    ),
    "several files by a wildcard": (
        INCLUDE.replace("_d435", "*") + CAMERA,
        ("include of '*.urdf.xacro'", "call of the macro 'sensor_d435'"),
    ),
    "a property computed at once": (
        INCLUDE + '<xacro:property name="half" value="${d435_height / 2}" lazy_eval="false"/><gazebo half="${half}"/>',
        ("<xacro:property name='half'> is left out", "<gazebo> is left out: name 'half' is not defined"),
    ),
}
"""What stands in the arm's file, and parts of what is said to be left out."""


def told(arm: Arm) -> list[str]:
    return [one.what for one in arm.findings if one.code == "package-left-out"]


@pytest.mark.parametrize("case", LEFT_OUT)
def test_what_the_package_would_have_brought_is_left_out_and_told(case: str, tmp_path: Path) -> None:
    inside, parts = LEFT_OUT[case]
    camera = f'<robot {XMLNS}>{INCLUDE}<xacro:macro name="camera">{CAMERA}</xacro:macro></robot>'
    write(tmp_path, camera, "camera.xacro")
    path = write(tmp_path, as_xacro(inside), "arm.xacro")
    with pytest.raises(DescriptionError):
        load_arm(path, tip="tool0")
    arm = load_arm(path, tip="tool0", ignore_packages=["realsense2_description"])
    assert "package-not-used" not in [one.code for one in arm.findings]
    plain = load_arm(write(tmp_path, ARM))
    np.testing.assert_array_equal(arm.screws, plain.screws)
    np.testing.assert_array_equal(arm.home, plain.home)
    for part in parts:
        assert any(part in what for what in told(arm)), told(arm)
    includes = sum("include of" in what or "counts as empty" in what for what in told(arm))
    assert includes == 1
    assert len(told(arm)) == includes + sum("include of" not in part and "counts" not in part for part in parts)


def test_the_error_names_the_package_and_what_to_type(tmp_path: Path) -> None:
    path = write(tmp_path, as_xacro(INCLUDE + CAMERA), "arm.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path)
    assert "package 'realsense2_description' not found" in str(caught.value)
    assert str(caught.value).endswith("ignore_packages=['realsense2_description']")
    assert "package-needed-not-found" in [one.code for one in diagnose(path)]
    assert "package-left-out" in [one.code for one in diagnose(path, ignore_packages="realsense2_description")]


NEEDED = {
    "a joint on a link that is missing": (
        joint("lens", "camera_link", "lens", kind="fixed") + '<link name="lens"/>',
        "joint 'lens': its parent link",
    ),
    "a link that nothing joins": ('<link name="camera_bottom"/>', "2 root links: 'camera_bottom', 'base_link'"),
    "a joint's place": (
        '<link name="pen"/>' + joint("t", "tool0", "pen", kind="fixed", xyz="0 0 ${d435_height}"),
        "name 'd435_height' is not defined",
    ),
    "a condition": ('<xacro:if value="${d435_used}"><link name="a"/></xacro:if>', "name 'd435_used' is not defined"),
}


@pytest.mark.parametrize("case", NEEDED)
def test_what_the_arm_itself_needs_is_refused_as_before(case: str, tmp_path: Path) -> None:
    inside, message = NEEDED[case]
    path = write(tmp_path, as_xacro(INCLUDE + CAMERA + inside), "arm.xacro")
    with pytest.raises(DescriptionError) as caught:
        load_arm(path, tip="tool0", ignore_packages=["realsense2_description"])
    assert message in str(caught.value)
    assert "may be what is missing: the include of '_d435.urdf.xacro' is left out" in str(caught.value)
    codes = [one.code for one in diagnose(path, tip="tool0", ignore_packages=["realsense2_description"])]
    assert "package-left-out" in codes


def test_nothing_is_refused_less_for_being_inside_what_could_be_left_out(tmp_path: Path) -> None:
    for reach, message in (
        ("${xacro.load_yaml('/etc/hostname')}", "lies outside"),
        ("${().__class__}", "is not allowed"),
        ("${9**9**9}", "whole number"),
        ("${xacro.load_yaml('$(find other)/a.yaml')}", "package 'other' not found"),
        ("${xacro.load_yaml('absent.yaml')}", "No such file"),
    ):
        path = write(tmp_path, as_xacro(f'{INCLUDE}<gazebo a="{reach}"/>'), "arm.xacro")
        with pytest.raises(DescriptionError, match=message):
            load_arm(path, ignore_packages=["realsense2_description"])


@pytest.mark.parametrize(("name", "text"), [("arm.xacro", as_xacro(CAMERA)), ("arm.urdf", ARM)])
def test_a_package_that_is_not_asked_for_is_said(name: str, text: str, tmp_path: Path) -> None:
    text = text.replace(CAMERA, '<gazebo a="$(find realsense2_description)/a.yaml"/>')
    path = write(tmp_path, text, name)
    arm = load_arm(path, ignore_packages=["realsense_description"])
    (one,) = [one for one in arm.findings if one.code == "package-not-used"]
    assert "nothing is left out without 'realsense_description'" in one.what
    assert ("closest: 'realsense2_description'" in one.remedy) == (name == "arm.xacro")


@pytest.mark.parametrize("bad", [" ", "a/b", "..", 3, ["a", ""], [["a"]]])
def test_what_is_no_name_of_a_package_is_refused(bad: object, tmp_path: Path) -> None:
    path = write(tmp_path, ARM)
    with pytest.raises(InputError, match=r"ignore_packages (takes|must be a sequence of) names.*; got "):
        load_arm(path, ignore_packages=bad)  # type: ignore[arg-type]


def test_an_arm_file_says_what_it_does_without(tmp_path: Path) -> None:
    write(tmp_path, as_xacro(INCLUDE + CAMERA), "arm.xacro")
    path = write(tmp_path, 'source = "arm.xacro"\nignore_packages = ["realsense2_description"]', "arm.toml")
    assert len(told(load_arm(path))) == 2
    assert assert_arm(tmp_path / "arm.xacro", ignore_packages=["realsense2_description"], samples=3).n == 2
    bad = write(tmp_path, 'source = "arm.xacro"\nignore_packages = ["a/b"]', "bad.toml")
    with pytest.raises(DescriptionError, match=r"bad.toml: ignore_packages takes names of packages, .*got 'a/b'"):
        load_arm(bad)


def test_what_to_type_works_when_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Each error ends in the options that answer it: followed one after the other, they load the arm."""
    argument = '<xacro:arg name="side" default="left one"/>'
    name = '<gazebo reference="$(arg side)"/><gazebo reference="$(arg model)"/>'
    path = write(tmp_path, as_xacro(name + argument + INCLUDE + CAMERA), "arm.xacro")
    typed: list[str] = []
    for _ in range(2):
        assert run(["info", str(path), *typed]) == 2
        options = re.search("--(xacro|ignore-package) .*", capsys.readouterr().err)
        assert options
        typed += shlex.split(options.group())
    assert typed == [
        "--xacro",
        "side:=left one",
        "--xacro",
        "model:=VALUE",
        "--ignore-package",
        "realsense2_description",
    ]
    draft = ["init", str(path), "-o", str(tmp_path / "arm.toml"), *typed]
    assert run(draft) == 0
    assert len(told(load_arm(tmp_path / "arm.toml"))) == 2
