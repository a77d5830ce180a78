"""`twistarm plan` of targets, straight lines and motion.toml."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from test_cli import Capture, answer, error_of
from twistarm import Scene, load_arm, load_motion, load_trajectory
from twistarm.cli.application import run

pytestmark = pytest.mark.usefixtures("here")


def test_the_file_that_init_writes_is_planned(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "motion.toml"
    assert run(["init", "rover_arm", "--motion", "-o", str(file)]) == 0
    capsys.readouterr()
    planned = answer(capsys, "plan", "rover_arm", str(file), "-o", str(tmp_path / "m.csv"))
    arm = load_arm("rover_arm")
    assert np.allclose(planned["waypoints"][-1], arm.ready)
    assert "close gripper" in (tmp_path / "m.csv").read_text("utf-8")
    longest = max(planned["active_limits"], key=lambda stretch: stretch["end"] - stretch["begin"])
    assert (longest["rate"], longest["name"]) == ("acceleration", "slide")  # 5 cm at 1 m/s²: half of them to brake
    assert answer(capsys, "follow", "rover_arm", str(file), "--no-browser")["duration"] == planned["duration"]
    assert run(["view", "rover_arm", "--play", str(file), "-o", str(tmp_path / "view.html")]) == 0
    text = file.read_text("utf-8").replace("# [", "[").replace("# line", "line").replace("# screw", "screw")
    text = text.replace("# free", "free")
    file.write_text(text.replace("# arc", "arc").replace("# acceleration", "acceleration"), "utf-8")
    assert len(load_motion(file, arm).segments) == 8


def test_avoid_goes_round_the_obstacles_of_a_scene(capsys: Capture, tmp_path: Path) -> None:
    """From above a table to below it, by option and by file; joint moves there collide."""
    pytest.importorskip("ompl")
    scene, motion = tmp_path / "scene.toml", tmp_path / "m.toml"
    scene.write_text("[[box]]\nname = 'table'\nsize = [0.4, 1.0, 0.04]\nxyz = [0.8, 0.0, 0.3]", "utf-8")
    motion.write_text("scene = 'scene.toml'\n[[segment]]\nfree = { xyz = [0.75, 0.1, 0.2] }", "utf-8")
    arm = load_arm("rover_arm")
    there = Scene.load(arm, scene)
    for typed in (["--xyz", "0.75 0.1 0.2", "--avoid", str(scene)], [str(motion)]):
        planned = answer(capsys, "plan", "rover_arm", *typed, "-o", str(tmp_path / "m.csv"), "--force")
        np.testing.assert_allclose(arm.fk(planned["waypoints"][-1])[:3, 3], [0.75, 0.1, 0.2], atol=1e-6)
        way = load_trajectory(arm, tmp_path / "m.csv")
        assert not there.collides(way(np.linspace(0.0, way.duration, 500))).any()
        metres = there.distance(way(planned["nearest"]["time"])).metres
        assert metres == pytest.approx(planned["nearest"]["metres"], abs=1e-4)
        assert ("comes nearer than" in " ".join(planned["notes"])) == (metres < 0.004)
    motion.write_text(motion.read_text("utf-8").replace("free", "joint"), "utf-8")
    assert "segment 1" in error_of(capsys, "plan", "rover_arm", str(motion), code=1)


def test_keep_keeps_the_tool_level(capsys: Capture, tmp_path: Path) -> None:
    typed = ["rover_arm_6dof", "--avoid", "self", "--to", "shoulder_yaw=40", "--to", "ready"]
    file = tmp_path / "level.csv"
    answer(capsys, "plan", *typed, "--keep", "level", "--keep-tol", "1", "-o", str(file))
    arm = load_arm("rover_arm_6dof")
    motion = load_trajectory(arm, file)
    R = arm.fk(motion(np.linspace(0.0, motion.duration, 500)))[:, :3, :3]
    assert (R[:, 2] @ R[0, 2]).min() >= np.cos(np.radians(1.0)) - 1e-9  # what was upright at the start
    for wrong, words in ((["--keep-tol", "1"], "goes with --keep"), (["--keep", "level", "--line"], "without --line")):
        assert words in error_of(capsys, "plan", *typed, *wrong)
    tipped = [*typed[:-2], "--to", "wrist_pitch=10", "--keep", "level"]
    assert run(["plan", *tipped]) == 1
    assert "at its goal the tool axis is 50.1° off" in capsys.readouterr().err
    turned = ["ur5", "--avoid", "self", "--xyz", "0.4 0.2 0.5", "--rpy", "0 0 0", "--keep", "level"]
    assert "the target itself" in error_of(capsys, "plan", *turned, code=1)


def test_a_line_is_planned_to_a_typed_position(capsys: Capture) -> None:
    arm = load_arm("rover_arm")
    p = arm.fk(arm.ready)[:3, 3] + [0.05, 0.05, 0.0]
    planned = answer(capsys, "plan", "rover_arm", "--xyz", " ".join(map(str, p)), "--line", "--linear-speed", "0.1")
    np.testing.assert_allclose(arm.fk(planned["waypoints"][-1])[:3, 3], p, atol=1e-6)
    assert planned["duration"] > np.linalg.norm([0.05, 0.05]) / 0.1
    assert "linear speed" in [stretch["rate"] for stretch in planned["active_limits"]]


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        ("", "'segment'"),
        ("[[segment]\n", "TOML"),
        ("[[segment]]\nscrew = { axis = [0, 0, 1], point = [0, 0, 0] }", "angle"),
        ("[[segment]]\narc = {}", "arc"),
        ("[[segment]]\njoint = 'redy'", "'redy'"),
        ("[[segment]]\njoint = { rpy = [1, 0, 1] }", "xyz"),
        ("[[segment]]\njoint = { xyz = [1, 0, 1], tolerance = [1, 1, 1, 1, 1, 1] }", "tolerance"),
        ("[[segment]]\njoint = { xyz = [1, 0, 1], tool_axis = [1, 0, 0] }", "tool_axis"),
        ("start = { xyz = [1, 0, 1] }\n[[segment]]\ndwell = 1", "start"),
        ("start = { elbow = 1 }\n[[segment]]\ndwell = 1", "'slide'"),
        ("limits = { aceleration = 1 }\n[[segment]]\ndwell = 1", "'aceleration'"),
        ("[[segment]]\nline = 'ready'\njoint = 'ready'", "segment 1"),
        ("kind = 'fast'\n[[segment]]\ndwell = 1", "kind"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(capsys: Capture, tmp_path: Path, text: str, culprit: str) -> None:
    file = tmp_path / "motion.toml"
    file.write_text(text, "utf-8")
    assert culprit in error_of(capsys, "plan", "rover_arm", str(file))


def test_each_position_may_have_its_own_direction(capsys: Capture) -> None:
    arm = load_arm("rover_arm")
    p = arm.fk(arm.ready)[:3, 3]
    places = ["--xyz", " ".join(map(str, p)), "--xyz", " ".join(map(str, p + [0.0, 0.1, 0.0]))]
    directions = np.array([[1.0, 0.0, -0.2], [1.0, 0.0, -0.5]])
    typed = [word for d in directions for word in ("--direction", " ".join(map(str, d)))]
    for options, expected in ((typed[:2], directions[[0, 0]]), (typed, directions)):
        ends = answer(capsys, "plan", "rover_arm", *places, *options)["waypoints"][1:]
        unit = expected / np.linalg.norm(expected, axis=1, keepdims=True)
        np.testing.assert_allclose(arm.fk(ends)[:, :3, :3] @ arm.tool_axis, unit, atol=1e-6)


def test_what_is_typed_goes_before_what_the_file_says(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "motion.toml"
    file.write_text("start = 'zero'\nlinear_speed = 0.2\n[[segment]]\njoint = 'ready'", "utf-8")
    planned, slower = (
        answer(capsys, "plan", "rover_arm", str(file), *typed) for typed in ([], ["--linear-speed", "0.02"])
    )
    assert (planned["start"], planned["waypoints"][0]) == ("zero", [0.0] * 5)
    assert slower["duration"] > 5 * planned["duration"]
    assert answer(capsys, "plan", "rover_arm", str(file), "--from", "reach")["start"] == "reach"


@pytest.mark.parametrize("line", [[], ["--line"]])
def test_what_the_arm_cannot_do_is_told_in_one_line_and_by_the_exit_code(line: list[str], capsys: Capture) -> None:
    assert "segment 1" in error_of(capsys, "plan", "rover_arm", "--xyz", "9 9 9", *line, code=1)


def test_another_start_is_told_as_it_would_be_typed(capsys: Capture) -> None:
    """Seven radians about the tool's axis are more than the wrist has left, from here."""
    arm = load_arm("ur5")
    ready = "0 -90 90 0 90 0"
    axis, p = arm.fk(np.radians([0, -90, 90, 0, 90, 0]))[:3, 2:].T
    assert arm.joint_names[5] == "wrist_3_joint"
    file = f"degrees = true\nstart = [{ready.replace(' ', ', ')}]\n[[segment]]\n"
    file += f"screw = {{ axis = {axis.tolist()}, point = {p.tolist()}, angle = 400 }}"
    path = Path("motion.toml")
    path.write_text(file, "utf-8")
    told = error_of(capsys, "plan", "ur5", str(path), code=1)
    found = re.search(r'another configuration, "([^"]*)" \(° and m\), from which all of it can be followed', told)
    assert found, told
    assert answer(capsys, "plan", "ur5", str(path), "--from", found[1])["duration"] > 0
