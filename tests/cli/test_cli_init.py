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
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, two_joints())
    return tmp_path


def test_init_writes_an_arm_toml_that_every_command_takes(folder: Path, capsys: Capture) -> None:
    assert (
        printed(capsys, "init", "arm.urdf")
        == "arm.toml: 2 joints from base_link to tool0; next: twistarm info arm.toml\n"
    )
    assert answer(capsys, "info", "arm.toml")["ready"] == load_arm("arm.urdf").ready.tolist()
    assert answer(capsys, "fk", "arm.toml")["position"] == answer(capsys, "fk", "arm.urdf")["position"]


def test_a_link_in_a_circle_is_replaced(folder: Path, capsys: Capture) -> None:
    (folder / "loop.toml").symlink_to("loop.toml")
    assert run(["init", "arm.urdf", "-o", "loop.toml"]) == 0, capsys.readouterr().err
    assert (folder / "loop.toml").is_file()


def test_init_without_a_clear_tip_writes_nothing(folder: Path, capsys: Capture) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "left"), joint("c", "upper", "right")
    write(folder, robot(*parts, links=("base_link", "upper", "left", "right")))
    assert "--tip left" in error_of(capsys, "init", "arm.urdf")
    assert not (folder / "arm.toml").exists()
    assert run(["init", "arm.urdf", "--tip", "right"]) == 0
    assert load_arm("arm.toml").joint_names == ("a", "c")


def test_a_motion_is_begun_for_the_arm_that_the_options_say(folder: Path, capsys: Capture) -> None:
    parts = joint("a", "base_link", "upper"), joint("b", "upper", "left"), joint("c", "upper", "right")
    write(folder, robot(*parts, links=("base_link", "upper", "left", "right")))
    assert "no link for --tip 'tool9'" in error_of(capsys, "init", "arm.urdf", "--motion", "--tip", "tool9")
    assert "is named *.toml" in error_of(capsys, "init", "arm.urdf", "--motion", "-o", "motion.txt", "--tip", "right")
    told = printed(capsys, "init", "arm.urdf", "--motion", "--tip", "right")
    assert told.endswith("next: twistarm plan arm.urdf motion.toml --tip right\n")
    assert len(answer(capsys, *told.rpartition("twistarm ")[2].split())["waypoints"]) == 4


def test_init_leaves_nothing_behind_when_it_fails(folder: Path, capsys: Capture) -> None:
    assert "no link for --tip 'tool9'" in error_of(capsys, "init", "arm.urdf", "--tip", "tool9")
    assert "takes no xacro arguments" in error_of(capsys, "init", "arm.urdf", "--xacro", "a:=1")
    assert [path.name for path in folder.iterdir()] == ["arm.urdf"]


def test_limits_and_srdf_by_file(folder: Path, capsys: Capture) -> None:
    write(folder, "joint_limits: {a: {max_velocity: 0.25}}", "limits.yaml")
    state = '<group_state name="home"><joint name="a" value="0.1"/><joint name="b" value="0.2"/></group_state>'
    write(folder, f'<robot name="tiny">{state}</robot>', "semantics.xml")
    content = answer(capsys, "info", "arm.urdf", "--limits", "limits.yaml", "--srdf", "semantics.xml")
    assert [joint["velocity"] for joint in content["joints"]] == [0.25, 2.0]
    assert content["named_states"] == {"home": [0.1, 0.2]}
    assert "no.yaml: no such file" in error_of(capsys, "fk", "arm.urdf", "--limits", "no.yaml")
    assert "no.srdf: no such file" in error_of(capsys, "fk", "arm.urdf", "--srdf", "no.srdf")


def test_locked_joints_in_degrees_and_metres(capsys: Capture) -> None:
    arm = load_arm("rover_arm", locked_joints={"slide": 0.1, "elbow": np.pi / 6})
    typed = ("--locked-joint", "slide=0.1", "--locked-joint", "elbow=30")
    assert np.allclose(answer(capsys, "fk", "rover_arm", *typed, "--theta", "0 0 0")["matrix"], arm.fk([0.0, 0.0, 0.0]))
    in_radians = ("--locked-joint", "slide = 0.1", "--locked-joint", f"elbow={np.pi / 6}", "--rad")
    content = answer(capsys, "fk", "rover_arm", *in_radians, "--theta", "0 0 0")
    assert np.allclose(content["matrix"], arm.fk([0.0, 0.0, 0.0]))
    for pair, told in (
        ("slide", "takes JOINT=VALUE"),
        ("slide=inf", "takes JOINT=VALUE"),
        ("knee=1", "for --locked-joint"),
    ):
        assert told in error_of(capsys, "fk", "rover_arm", "--locked-joint", pair)
