"""`twistarm ik --all`: every configuration on the terminal, as JSON and CSV; and what `info` says of the family."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from ik_targets import require_core
from test_cli import Capture, answer, printed
from twistarm import load_arm

AT = ["ik", "rover_arm", "--all", "--xyz", "0.8", "0.1", "0.7"]
ROVER = [*AT, "--direction", "1", "0", "0"]
"""Elbow up and elbow down."""


def rows_at(p: list[float], out: Path) -> list[dict[str, str]]:
    """The rows of a CSV of configurations, each of which puts the tool at p (3,)."""
    arm = load_arm("rover_arm")
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        theta = [float(row[f"{name} [{unit}]"]) for name, unit in zip(arm.joint_names, arm.units, strict=True)]
        g, _, _ = arm.by_pinocchio(theta)
        assert np.allclose(g[:3, 3], p, atol=1e-9)
        assert arm.limits.contains(theta) == (row["within_limits"] == "yes")
    return rows


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
    lines = printed(capsys, *ROVER).splitlines()
    assert lines[0] == "rover_arm: 2 configurations, nearest first"
    assert max(map(len, lines[1:6])) <= 80
    assert "2 configurations inside the limits, each with wrist_roll free; all there are" in lines
    typed = next(line for line in lines if line.startswith("--theta")).removeprefix("--theta ").strip('"')
    pose = answer(capsys, "fk", "rover_arm", "--theta", typed)
    assert np.allclose(pose["position"], [0.8, 0.1, 0.7], atol=1e-6)


def test_given_joints_stand_where_they_are_told(capsys: Capture) -> None:
    held = answer(capsys, *AT, "--fixed-joint", "wrist_pitch=10", "wrist_roll=30")
    assert held["complete"]
    assert np.allclose(np.array(held["theta"])[:, 3:], np.radians([10, 30]))


def test_whole_turns_count_on_request(capsys: Capture) -> None:
    pose = ["ik", "scara", "--all", "--xyz", "0.4", "0.2", "0.2", "--rpy", "0", "0", "30"]
    alone, copies = (answer(capsys, *pose, *more)["theta"] for more in ([], ["--include-turns"]))
    assert len(copies) >= len(alone) > 0
    arm = load_arm("scara")
    turns = (np.array(copies)[:, None] - np.array(alone)[None]) / (2.0 * np.pi)
    assert (np.abs(turns - np.round(turns)).max(axis=2).min(axis=1) < 1e-9).all()
    assert arm.limits.contains(np.array(copies)).all()


def test_csv_has_those_outside_the_limits_too(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    pose = ["--xyz", "0.2", "0.1", "0.7", "--direction", "-1", "0", "0"]
    words = printed(capsys, "ik", "rover_arm", "--all", *pose, "-o", str(out))
    assert "1 configuration inside the limits, with wrist_roll free, 1 more outside; all there are" in words
    assert [row["within_limits"] for row in rows_at([0.2, 0.1, 0.7], out)] == ["yes", "no"]


def test_a_position_is_a_family_whose_samples_are_in_the_csv(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    told = answer(capsys, *AT, "-o", str(out))
    assert not told["complete"]
    rows = [row for row in rows_at([0.8, 0.1, 0.7], out) if row["within_limits"] == "yes"]
    assert len(rows) > 10 > len(told["theta"])
    assert {int(row["number"]) for row in rows} == {*range(1, len(told["theta"]) + 1)}
    assert all("wrist_roll" in free for free in told["free"])


def test_none_is_an_answer_with_exit_code_1(capsys: Capture) -> None:
    far = printed(capsys, "ik", "rover_arm", "--all", "--xyz", "5", "0", "0", "--direction", "1", "0", "0", code=1)
    assert "no configuration inside the limits: that is certain" in far
    require_core(load_arm("rover_arm"))
    aside = printed(capsys, "ik", "rover_arm", "--all", "--xyz", "0.6", "0.1", "0.7", "--rpy", "20", "0", "0", code=1)
    assert "no configuration inside the limits: that is certain" in aside
    assert "the nearest configuration: position met, orientation" in aside
    assert "with the position held, no joint turns its tool about" in aside


def test_info_names_the_family(capsys: Capture) -> None:
    told = "an Approach (ik --all): closed form, the axes of shoulder, elbow and wrist_pitch are parallel"
    assert told in printed(capsys, "info", "rover_arm")
    assert answer(capsys, "info", "rover_arm")["all_configurations"]["family"] in told
