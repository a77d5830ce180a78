"""`twistarm ik --all`: every configuration on the terminal, as JSON and CSV."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from ik_targets import require_core
from test_cli import Capture, answer, printed
from twistarm import load_arm

AT = ["ik", "rover_arm", "--all", "--xyz", "0.8", "0.1", "0.7"]
ROVER = [*AT, "--direction", "1", "0", "0"]  # Elbow up and elbow down.


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
    assert max(map(len, lines[1:6])) <= 80
    typed = next(line for line in lines if line.startswith("--theta")).removeprefix("--theta ").strip('"')
    pose = answer(capsys, "fk", "rover_arm", "--theta", typed)
    assert np.allclose(pose["position"], [0.8, 0.1, 0.7], atol=1e-6)


def test_fixed_joints_stand_where_they_are_told(capsys: Capture) -> None:
    held = answer(capsys, *AT, "--fixed-joint", "wrist_pitch=10", "wrist_roll=30")
    assert held["complete"]
    assert np.allclose(np.array(held["theta"])[:, 3:], np.radians([10, 30]))


def test_csv_has_those_outside_the_limits_too(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    pose = ["--xyz", "0.2", "0.1", "0.7", "--direction", "-1", "0", "0"]
    found = answer(capsys, "ik", "rover_arm", "--all", *pose, "-o", str(out))
    assert (len(found["theta"]), len(found["outside"])) == (1, 1)
    assert [row["within_limits"] for row in rows_at([0.2, 0.1, 0.7], out)] == ["yes", "no"]


def test_a_position_is_a_family_with_one_row_and_its_free_joints(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    found = answer(capsys, *AT, "-o", str(out))
    assert not found["complete"]
    rows = [row for row in rows_at([0.8, 0.1, 0.7], out) if row["within_limits"] == "yes"]
    assert [int(row["number"]) for row in rows] == [*range(1, len(found["theta"]) + 1)] != []
    assert all("wrist_roll" in free for free in found["free"])


@pytest.mark.parametrize("asked", ["--xyz 5 0 0 --direction 1 0 0", "--xyz 0.6 0.1 0.7 --rpy 20 0 0"])
def test_none_is_an_answer_with_exit_code_1(asked: str, capsys: Capture) -> None:
    require_core(load_arm("rover_arm"))
    found = answer(capsys, "ik", "rover_arm", "--all", *asked.split(), code=1)
    assert (found["theta"], found["complete"]) == ([], True)
    assert printed(capsys, "ik", "rover_arm", "--all", *asked.split(), code=1)
