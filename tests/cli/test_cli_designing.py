"""`payload` and `designs` as a person and as a program uses them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import twistarm
from test_cli import answer, error_of, printed
from twistarm import payload
from twistarm.cli.application import run
from urdf_text import two_joints, write

Capture = pytest.CaptureFixture[str]


def test_payload_at_a_configuration(capsys: Capture, rover: twistarm.Arm) -> None:
    content = answer(capsys, "payload", "rover_arm", "--theta", "ready", "--mass", "2")
    found = payload(rover, "ready")
    assert np.isclose(content["payload"], found.mass)
    assert content["limited_by"] == "wrist_pitch"
    assert np.allclose([row["effort"] for row in content["needs"]], found.needs(2.0).effort)
    assert [row["limit"] for row in content["needs"]] == rover.limits.effort.tolist()
    printed(capsys, "payload", "rover_arm", "--theta", "ready", "--mass", "20", code=1)


def test_payload_anywhere_fits_a_terminal(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = printed(capsys, "payload", "rover_arm").splitlines()
    assert max(map(len, lines)) <= 80
    assert [line.split()[0] for line in lines[3:8]] == ["slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"]
    theta = next(line for line in lines if line.startswith("--theta"))
    there = answer(capsys, "payload", "rover_arm", "--theta", theta.split('"')[1])
    assert f"holds {there['payload']:.1f} kg at tool0" in lines[-2]


def test_payload_of_a_motion_in_files(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed(capsys, "plan", "rover_arm", "--to", "stowed", "-o", "motion.csv")
    content = answer(capsys, "payload", "rover_arm", "--motion", "motion.csv", "-o", "held.csv")
    with open("held.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == content["configurations"]
    assert min(float(row["payload [kg]"]) for row in rows) == content["payload"]
    assert float(rows[-1]["time [s]"]) > 0.0
    assert content["needs"][1]["speed"] > 0.1


def test_an_unknown_payload_is_no_good_answer(capsys: Capture, tmp_path: Path) -> None:
    arm = str(
        write(
            tmp_path,
            two_joints().replace('effort="3"', 'effort="0"').replace('<axis xyz="0 0 1"/>', '<axis xyz="0 1 0"/>'),
        )
    )
    assert run(["payload", arm, "--json"]) == 1
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert content["payload"] is None
    assert content["unknown"] == content["configurations"]
    assert "no effort limit of 'a', 'b'" in err
    assert "no link that moves has a mass" in err
    shown = printed(capsys, "payload", arm, code=1)
    assert shown.splitlines()[-1] == "the payload is unknown", "without a weakest configuration"
    assert "0 %" not in shown.partition("limits in")[2].splitlines()[2].split("−")[1], "no share of no limit"


def test_designs(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    content = answer(capsys, "designs", "rover_arm", "rover_arm_6dof")
    ours, other = content["designs"]
    assert other["farthest"] > ours["farthest"]
    shown = printed(capsys, "designs", "rover_arm", "rover_arm_6dof")
    assert f"{ours['farthest']:.3g}" in shown


PANEL = """
degrees = true
[panel]
xyz = [0.95, 0.0, 0.8]
[parking]
x = [-0.1, 0.1]
[[task]]
name = "key"
kind = "press"
xyz = [0.0, 0.0, 0.0]
travel = 0.004
[[task]]
name = "far knob"
kind = "turn"
xyz = [0.0, 3.0, 0.0]
angle = 90
"""


def test_a_panel_as_table_json_and_files(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    Path("panel.toml").write_text(PANEL, "utf-8")
    shown = printed(capsys, "panel", "rover_arm", "panel.toml", "-o", "p.csv", code=1)
    *table, why, sentence, motion = shown.splitlines()
    assert max(map(len, table)) <= 80
    (row,) = (line.split() for line in table if line.startswith("key "))
    assert row[:3] == ["key", "press", "done"]
    assert why.startswith("far knob, out_of_reach: in front of it: ")
    assert sentence.startswith("1 of 2 tasks")
    assert motion == "written: p.csv"
    moved = twistarm.load_trajectory(twistarm.load_arm("rover_arm"), "p.csv")
    place = sentence.split('"')[1]
    assert run(["panel", "rover_arm", "panel.toml", "--base-pose", place, "--json"]) == 1
    content = json.loads(capsys.readouterr().out)
    assert (content["done"], content["share"]) == (1, 0.5)
    assert np.isclose(content["base"]["x"], float(place.split()[0]), atol=1e-4)
    key, knob = content["tasks"]
    assert (key["code"], knob["code"]) == ("done", "out_of_reach")
    assert row[3] == key["joint"]
    unit = {"slide": 1.0}.get(key["joint"], np.pi / 180)
    assert np.isclose(float(row[4].rstrip("°")) * unit, key["margin"], atol=0.006 * unit)
    assert knob["margin"] is None
    assert key["clearance"] is None
    # The deepest point of the motion is 4 mm into the panel, which stands 0.95 m from the world's origin.
    tip = moved(np.linspace(0.0, moved.duration, 2000))
    reached = twistarm.load_arm("rover_arm").fk(tip)[:, 0, 3].max()
    assert np.isclose(reached + float(place.split()[0]), 0.954, atol=2e-4)


def test_the_answer_outlives_a_motion_that_fails(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("panel.toml").write_text(PANEL, "utf-8")
    asked = ["panel", "rover_arm", "panel.toml", "--base-pose", "0 0 0", "--dt", "1e-12", "-o", "p.csv", "--json"]
    assert run(asked) == 2
    answer = json.loads(capsys.readouterr().out)
    assert (len(answer["tasks"]), answer["written"]) == (2, [])
    assert [path.name for path in tmp_path.iterdir()] == ["panel.toml"]


def test_reach_as_a_table_with_units_and_every_file(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["reach", "rover_arm", "--voxel", "0.5"]
    shown = printed(capsys, *words, *["-o", "m.npz", "-o", "m.png"])
    m = twistarm.ReachMap.load("m.npz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["m.npz", "m.png"]
    (volume,) = (line.split() for line in shown.splitlines() if line.startswith("volume"))
    assert volume == ["volume", f"{m.volume:g}", "m³"]
    around = answer(capsys, *words, "--directions", "26")
    assert around["volume_in_all_directions"] <= around["volume"]


def test_no_task_done_writes_no_motion(capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("panel.toml").write_text(PANEL.replace("0.95, 0.0, 0.8", "5.0, 0.0, 0.8"), "utf-8")
    assert run(["panel", "rover_arm", "panel.toml", "-o", "p.csv"]) == 1
    out, err = capsys.readouterr()
    assert "0 of 2 tasks" in out
    assert "no motion is written" in err
    assert [path.name for path in tmp_path.iterdir()] == ["panel.toml"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["payload", "rover_arm", "--mass", "-1"], "it takes a number of 0 or more"),
        (["payload", "rover_arm", "--theta", "ready", "--motion", "m.csv"], "leave out --theta"),
        (["reach", "rover_arm", "--directions", "up"], "down, position, 26 or three numbers"),
        (["designs", "rover_arm"], "Missing argument"),
        (["panel", "rover_arm", "nowhere.toml", "--linear-speed", "nan"], "it takes a number above 0 such as 0.1 or"),
        (["panel", "rover_arm", "nowhere.toml"], "nowhere.toml"),
        (["panel", "rover_arm", "nowhere.toml", "-o", "x.pdf"], "-o takes *.csv or *.json"),
        (["designs", "rover_arm", "ur5", "--xyz", "0.5 0 0.5"], "give two or more, or none"),
    ],
)
def test_wrong_options(
    words: list[str], message: str, capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert message in error_of(capsys, *words)
