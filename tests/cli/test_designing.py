"""`payload`, `designs`, `panel` and `reach` as a person and as a program uses them."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import twistarm
from test_cli import Capture, answer, error_of, printed
from twistarm import payload
from twistarm.cli.application import run
from urdf_text import two_joints, write

pytestmark = pytest.mark.usefixtures("here")


def rows_of(name: str) -> list[dict[str, str]]:
    with open(name, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_payload_at_a_configuration(capsys: Capture, rover: twistarm.Arm) -> None:
    content = answer(capsys, "payload", "rover_arm", "--theta", "ready", "--mass", "2")
    found = payload(rover, "ready")
    assert np.isclose(content["payload"], found.mass)
    assert content["limited_by"] == "wrist_pitch"
    assert np.allclose([row["effort"] for row in content["needs"]], found.needs(2.0).effort)
    assert [row["limit"] for row in content["needs"]] == rover.limits.effort.tolist()
    printed(capsys, "payload", "rover_arm", "--theta", "ready", "--mass", "20", code=1)


def test_the_weakest_configuration_is_typed_back(capsys: Capture) -> None:
    lines = printed(capsys, "payload", "rover_arm").splitlines()
    theta = next(line for line in lines if line.startswith("--theta"))
    there = answer(capsys, "payload", "rover_arm", "--theta", theta.split('"')[1])
    assert f"{there['payload']:.1f} kg" in lines[-2]


def test_payload_of_a_motion_in_files(capsys: Capture) -> None:
    printed(capsys, "plan", "rover_arm", "--to", "stowed", "-o", "motion.csv")
    content = answer(capsys, "payload", "rover_arm", "--motion", "motion.csv", "-o", "held.csv")
    rows = rows_of("held.csv")
    assert len(rows) == content["configurations"]
    assert min(float(row["payload [kg]"]) for row in rows) == content["payload"]
    assert float(rows[-1]["time [s]"]) > 0.0
    assert content["needs"][1]["speed"] > 0.1


def test_an_unknown_payload_is_no_good_answer(capsys: Capture, here: Path) -> None:
    text = two_joints().replace('effort="3"', 'effort="0"').replace('<axis xyz="0 0 1"/>', '<axis xyz="0 1 0"/>')
    arm = str(write(here, text))
    assert run(["payload", arm, "--json"]) == 1
    out, err = capsys.readouterr()
    content = json.loads(out)
    assert content["payload"] is None
    assert content["unknown"] == content["configurations"]
    assert "'a', 'b'" in err
    assert "unknown" in printed(capsys, "payload", arm, code=1).splitlines()[-1], "without a weakest configuration"


def test_designs(capsys: Capture) -> None:
    ours, other = answer(capsys, "designs", "rover_arm", "rover_arm_6dof")["designs"]
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


def test_a_panel_as_table_json_and_files(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    Path("panel.toml").write_text(PANEL, "utf-8")
    *table, _, sentence, _ = printed(capsys, "panel", "rover_arm", "panel.toml", "-o", "p.csv", code=1).splitlines()
    assert max(map(len, table)) <= 80
    moved = twistarm.load_trajectory(twistarm.load_arm("rover_arm"), "p.csv")
    place = sentence.split('"')[1]
    content = answer(capsys, "panel", "rover_arm", "panel.toml", "--base-pose", place, code=1)
    assert (content["done"], content["share"]) == (1, 0.5)
    assert np.isclose(content["base"]["x"], float(place.split()[0]), atol=1e-4)
    key, knob = content["tasks"]
    assert (key["code"], knob["code"]) == ("done", "out_of_reach")
    assert (knob["margin"], key["clearance"]) == (None, None)
    # The deepest point of the motion is 4 mm into the panel, which stands 0.95 m from the world's origin.
    tip = moved(np.linspace(0.0, moved.duration, 2000))
    reached = twistarm.load_arm("rover_arm").fk(tip)[:, 0, 3].max()
    assert np.isclose(reached + float(place.split()[0]), 0.954, atol=2e-4)


def test_the_answer_outlives_a_motion_that_fails(capsys: Capture, here: Path) -> None:
    Path("panel.toml").write_text(PANEL, "utf-8")
    asked = ["panel", "rover_arm", "panel.toml", "--base-pose", "0 0 0", "--dt", "1e-12", "-o", "p.csv", "--json"]
    assert run(asked) == 2
    content = json.loads(capsys.readouterr().out)
    assert (len(content["tasks"]), content["written"]) == (2, [])
    assert [path.name for path in here.iterdir()] == ["panel.toml"]


def test_reach_as_a_table_with_units_and_every_file(capsys: Capture, here: Path) -> None:
    words = ["reach", "rover_arm", "--voxel", "0.5"]
    shown = printed(capsys, *words, *["-o", "m.npz", "-o", "m.png"])
    m = twistarm.ReachMap.load("m.npz")
    assert sorted(path.name for path in here.iterdir()) == ["m.npz", "m.png"]
    (volume,) = (line.split() for line in shown.splitlines() if line.startswith("volume"))
    assert volume == ["volume", f"{m.volume:g}", "m³"]
    around = answer(capsys, *words, "--directions", "26")
    assert around["volume_in_all_directions"] <= around["volume"]


@pytest.mark.parametrize(
    ("words", "culprit"),
    [
        ("payload rover_arm --theta ready --motion m.csv", "--theta"),
        ("reach rover_arm --directions up", "'up'"),
        ("designs rover_arm", "ARM..."),
        ("panel rover_arm nowhere.toml", "nowhere.toml"),
        ("panel rover_arm nowhere.toml -o x.pdf", "x.pdf"),
        ("designs rover_arm ur5 --xyz 0.5 0 0.5", "--xyz"),
    ],
)
def test_wrong_options(words: str, culprit: str, capsys: Capture) -> None:
    assert culprit in error_of(capsys, *words.split())
