"""`twistarm ik --all`: every configuration on the terminal, as JSON and CSV; and what `info` says of the family."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from ik_targets import require_core
from test_cli import Capture, answer, error_of
from twistarm import load_arm
from twistarm.cli.application import run

AT = ["ik", "rover_arm", "--all", "--xyz", "0.8", "0.1", "0.7"]
ROVER = [*AT, "--direction", "1", "0", "0"]
"""Elbow up and elbow down."""


def said(capsys: Capture, *arguments: str, code: int = 0) -> str:
    assert run(arguments) == code
    return capsys.readouterr().out


def test_all_of_them_nearest_first(capsys: Capture) -> None:
    arm = load_arm("rover_arm")
    content = answer(capsys, *ROVER)
    assert content["complete"]
    assert content["method"] == "closed form"
    assert content["free"] == [["wrist_roll"]] * 2
    for theta in content["theta"]:
        g, _, _ = arm.by_pinocchio(theta)
        np.testing.assert_allclose(g[:3, 2:].T, [[1, 0, 0], [0.8, 0.1, 0.7]], atol=1e-9)
    far = [np.abs(np.array(theta) - arm.ready).max() for theta in content["theta"]]
    assert far == sorted(far)
    assert content["theta"][0][2] * content["theta"][1][2] < 0, "elbow up and elbow down"


def test_it_is_a_table_that_can_be_pasted(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = said(capsys, *ROVER).splitlines()
    assert lines[0] == "rover_arm: 2 configurations, nearest first"
    assert max(map(len, lines[1:6])) <= 80
    assert "2 configurations inside the limits, each with wrist_roll free; all there are" in lines
    typed = next(line for line in lines if line.startswith("--theta")).removeprefix("--theta ").strip('"')
    pose = answer(capsys, "fk", "rover_arm", "--theta", typed)
    assert np.allclose(pose["position"], [0.8, 0.1, 0.7], atol=1e-6)


def test_given_joints_stand_where_they_are_told(capsys: Capture) -> None:
    held = answer(capsys, *AT, "--given", "wrist_pitch=10", "wrist_roll=30")
    assert held["complete"]
    assert np.allclose(np.array(held["theta"])[:, 3:], np.radians([10, 30]))


def test_whole_turns_count_on_request(capsys: Capture) -> None:
    pose = ["ik", "scara", "--all", "--xyz", "0.4", "0.2", "0.2", "--rpy", "0", "0", "30"]
    alone, copies = (answer(capsys, *pose, *more)["theta"] for more in ([], ["--copies"]))
    assert len(copies) >= len(alone) > 0
    arm = load_arm("scara")
    turns = (np.array(copies)[:, None] - np.array(alone)[None]) / (2.0 * np.pi)
    assert (np.abs(turns - np.round(turns)).max(axis=2).min(axis=1) < 1e-9).all()
    assert arm.limits.contains(np.array(copies)).all()


def test_csv_has_those_outside_the_limits_too(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    pose = ["--xyz", "0.2", "0.1", "0.7", "--direction", "-1", "0", "0"]
    words = said(capsys, "ik", "rover_arm", "--all", *pose, "-o", str(out))
    assert "1 configuration inside the limits, with wrist_roll free, 1 more outside; all there are" in words
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["within_limits"] for row in rows] == ["yes", "no"]
    arm = load_arm("rover_arm")
    for row in rows:
        theta = [float(row[f"{name} [{unit}]"]) for name, unit in zip(arm.joint_names, arm.units, strict=True)]
        g, _, _ = arm.by_pinocchio(theta)
        assert np.allclose(g[:3, 3], [0.2, 0.1, 0.7], atol=1e-9)
        assert arm.limits.contains(theta) == (row["within_limits"] == "yes")


def test_a_position_is_a_family_whose_samples_are_in_the_csv(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    told = answer(capsys, *AT, "-o", str(out))
    assert not told["complete"]
    with out.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["within_limits"] == "yes"]
    assert len(rows) > 10 > len(told["theta"])
    assert {int(row["number"]) for row in rows} == {*range(1, len(told["theta"]) + 1)}
    assert all("wrist_roll" in free for free in told["free"])
    arm = load_arm("rover_arm")
    for row in rows[::5]:
        g, _, _ = arm.by_pinocchio([float(row[f"{n} [{u}]"]) for n, u in zip(arm.joint_names, arm.units, strict=True)])
        assert np.allclose(g[:3, 3], [0.8, 0.1, 0.7], atol=1e-9)


def test_none_is_an_answer_with_exit_code_1(capsys: Capture) -> None:
    far = said(capsys, "ik", "rover_arm", "--all", "--xyz", "5", "0", "0", "--direction", "1", "0", "0", code=1)
    assert "no configuration inside the limits: that is certain" in far
    require_core(load_arm("rover_arm"))
    aside = said(capsys, "ik", "rover_arm", "--all", "--xyz", "0.6", "0.1", "0.7", "--rpy", "20", "0", "0", code=1)
    assert "no configuration inside the limits: that is certain" in aside
    assert "the nearest configuration: position met, orientation" in aside
    assert "with the position held, no joint turns its tool about" in aside


BAD = {
    "no pair": (["--all", "--xyz", "1 0 0", "--given", "3"], "--given takes joint=value"),
    "beyond a limit": (["--all", "--xyz", "1 0 0", "--given", "elbow=500"], "'elbow' cannot be given at 500°"),
    "given without all": (["--xyz", "1 0 0", "--given", "elbow=5"], "--given is about all configurations"),
    "copies without all": (["--xyz", "1 0 0", "--copies"], "--copies is about all configurations"),
    "a posture": (["--all", "--xyz", "1 0 0", "--posture", "middle"], "--all takes no --posture"),
    "no target": (["--all"], "--xyz"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case: str, capsys: Capture) -> None:
    arguments, told = BAD[case]
    assert told in error_of(capsys, "ik", "rover_arm", *arguments)


@pytest.mark.parametrize(
    ("arm", "told"),
    [
        ("rover_arm", "an Approach (ik --all): closed form, the axes of shoulder, elbow and wrist_pitch are parallel"),
        ("elbow", "a Pose (ik --all): closed form, the axes of joint_4, joint_5 and joint_6 meet in a point"),
        pytest.param("rover_arm_6dof", "elimination, six joints that turn, with any axes; the axes of "
                     "wrist_pitch and wrist_roll pass at 20 mm", marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_info_names_the_family_or_what_misses(arm: str, told: str, capsys: Capture) -> None:
    assert told in said(capsys, "info", arm)
    assert answer(capsys, "info", arm)["all_configurations"]["family"] in told
