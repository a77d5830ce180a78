"""`twistarm init`, and the options that say what stands beside a description."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test_cli import Capture, answer, error_of, printed
from twistarm import load_arm
from twistarm.cli.application import run
from urdf_text import joint, robot, two_joints, write


@pytest.fixture
def folder(here: Path) -> Path:
    write(here, two_joints())
    return here


@pytest.fixture
def forked(folder: Path) -> Path:
    """A description without a clear tip."""
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "left"), joint("c", "upper", "right")
    write(folder, robot(*parts, links=("base_link", "upper", "left", "right")))
    return folder


def test_init_writes_an_arm_toml_that_every_command_takes(folder: Path, capsys: Capture) -> None:
    assert "arm.toml: 2 joints" in printed(capsys, "init", "arm.urdf")
    assert answer(capsys, "info", "arm.toml")["ready"] == load_arm("arm.urdf").ready.tolist()
    assert answer(capsys, "fk", "arm.toml")["position"] == answer(capsys, "fk", "arm.urdf")["position"]


def test_init_keeps_the_typed_tool(folder: Path, capsys: Capture) -> None:
    tool = "--tool", "0.01", "0", "0.12"
    printed(capsys, "init", "arm.urdf", *tool)
    assert answer(capsys, "fk", "arm.toml")["matrix"] == answer(capsys, "fk", "arm.urdf", *tool)["matrix"]
    assert printed(capsys, "init", "arm.urdf", "--motion", *tool).endswith("--tool 0.01 0.0 0.12\n")


def test_a_link_in_a_circle_is_replaced(folder: Path) -> None:
    (folder / "loop.toml").symlink_to("loop.toml")
    assert run(["init", "arm.urdf", "-o", "loop.toml"]) == 0
    assert (folder / "loop.toml").is_file()


def test_init_without_a_clear_tip_writes_nothing(forked: Path, capsys: Capture) -> None:
    assert "--tip left" in error_of(capsys, "init", "arm.urdf")
    assert not (forked / "arm.toml").exists()
    assert run(["init", "arm.urdf", "--tip", "right"]) == 0
    assert load_arm("arm.toml").joint_names == ("a", "c")


def test_a_motion_is_begun_for_the_arm_that_the_options_say(forked: Path, capsys: Capture) -> None:
    assert "motion.txt" in error_of(capsys, "init", "arm.urdf", "--motion", "-o", "motion.txt", "--tip", "right")
    shown = printed(capsys, "init", "arm.urdf", "--motion", "--tip", "right")
    assert len(answer(capsys, *shown.rpartition("twistarm ")[2].split())["waypoints"]) == 4


def test_init_leaves_nothing_behind_when_it_fails(folder: Path, capsys: Capture) -> None:
    assert "--tip tool9" in error_of(capsys, "init", "arm.urdf", "--tip", "tool9")
    assert "xacro" in error_of(capsys, "init", "arm.urdf", "--xacro", "a:=1")
    assert [path.name for path in folder.iterdir()] == ["arm.urdf"]


def test_limits_and_srdf_by_file(folder: Path, capsys: Capture) -> None:
    write(folder, "joint_limits: {a: {max_velocity: 0.25}}", "limits.yaml")
    state = '<group_state name="home"><joint name="a" value="0.1"/><joint name="b" value="0.2"/></group_state>'
    write(folder, f'<robot name="tiny">{state}</robot>', "semantics.xml")
    content = answer(capsys, "info", "arm.urdf", "--limits", "limits.yaml", "--srdf", "semantics.xml")
    assert [joint["velocity"] for joint in content["joints"]] == [0.25, 2.0]
    assert content["named_states"] == {"home": [0.1, 0.2]}
    assert "no.yaml" in error_of(capsys, "fk", "arm.urdf", "--limits", "no.yaml")
    assert "no.srdf" in error_of(capsys, "fk", "arm.urdf", "--srdf", "no.srdf")


def test_locked_joints_in_degrees_and_metres(capsys: Capture) -> None:
    arm = load_arm("rover_arm", locked_joints={"slide": 0.1, "elbow": np.pi / 6})
    degrees = ("--locked-joint", "slide=0.1", "--locked-joint", "elbow=30")
    radians = ("--locked-joint", "slide = 0.1", "--locked-joint", f"elbow={np.pi / 6}", "--rad")
    for typed in (degrees, radians):
        content = answer(capsys, "fk", "rover_arm", *typed, "--theta", "0 0 0")
        assert np.allclose(content["matrix"], arm.fk([0.0, 0.0, 0.0]))
    for pair in ("slide", "slide=inf", "knee=1"):
        assert "--locked-joint" in error_of(capsys, "fk", "rover_arm", "--locked-joint", pair)
