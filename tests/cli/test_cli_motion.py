"""`twistarm plan` of targets, straight lines and motion.toml."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from test_cli import answer, error_of
from twistarm import load_arm, load_motion
from twistarm.cli.application import run

Capture = pytest.CaptureFixture[str]
LIMITED = ("--acceleration", "3")


def test_the_file_that_init_writes_is_planned(capsys: Capture, tmp_path: Path) -> None:
    file = tmp_path / "motion.toml"
    assert run(["init", "rover_arm", "--motion", "-o", str(file)]) == 0
    capsys.readouterr()
    planned = answer(capsys, "plan", "rover_arm", str(file), "-o", str(tmp_path / "m.csv"))
    arm = load_arm("rover_arm")
    assert np.allclose(planned["waypoints"][-1], arm.ready)
    assert "close gripper" in (tmp_path / "m.csv").read_text("utf-8")
    longest = max(planned["binding"], key=lambda each: each["end"] - each["begin"])
    assert (longest["rate"], longest["name"]) == ("acceleration", "slide")  # 5 cm at 1 m/s²: half of them to brake
    assert run(["follow", "rover_arm", str(file), "--no-browser", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["duration"] == planned["duration"]
    assert run(["view", "rover_arm", "--play", str(file), "-o", str(tmp_path / "view.html")]) == 0
    # With the comment signs taken away every example is one that is read.
    text = file.read_text("utf-8").replace("# [", "[").replace("# line", "line").replace("# screw", "screw")
    file.write_text(text.replace("# arc", "arc").replace("# acceleration", "acceleration"), "utf-8")
    assert len(load_motion(file, arm).segments) == 7


def test_a_line_is_planned_to_a_typed_position(capsys: Capture) -> None:
    arm = load_arm("rover_arm")
    p = arm.fk(arm.ready)[:3, 3] + [0.05, 0.05, 0.0]
    planned = answer(capsys, "plan", "rover_arm", "--xyz", " ".join(map(str, p)), "--line", "--tool-speed", "0.1")
    np.testing.assert_allclose(arm.fk(planned["waypoints"][-1])[:3, 3], p, atol=1e-6)
    assert planned["duration"] > np.linalg.norm([0.05, 0.05]) / 0.1
    assert "tool speed" in [each["rate"] for each in planned["binding"]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "there is no segment"),
        ("[[segment]]\njont = 'ready'", "segment 1: unknown entry 'jont'; closest: 'joint'"),
        ("[[segment]]\nline = { xyz = [1, 2] }", "segment 1: .*xyz"),
        ("[[segment]]\ndwell = -1", "segment 1: seconds must be 0 or more"),
        ("[[segment]]\nscrew = { axis = [0, 0, 1], point = [0, 0, 0] }", "segment 1: angle is missing"),
        ("[[segment]]\njoint = { elbw = 1 }", "segment 1 .JointMove.*|no joint 'elbw'.*closest: 'elbow'"),
        ("[[segment]]\nline = 'ready'\njoint = 'ready'", "segment 1: it needs one of"),
        ("segment = 3", "there is no segment"),
        ("kind = 'fast'\n[[segment]]\ndwell = 1", "kind must be"),
        ("[[segment]\n", "not valid TOML"),
    ],
)
def test_a_file_that_cannot_be_used_is_refused(capsys: Capture, tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "motion.toml"
    file.write_text(text, "utf-8")
    assert re.search(words, error_of(capsys, "plan", "rover_arm", str(file)))


def test_one_way_of_saying_where_to_go(capsys: Capture) -> None:
    assert "give poses by --to" in error_of(capsys, "plan", "rover_arm")
    assert "give poses by --to" in error_of(capsys, "plan", "rover_arm", "--to", "ready", "--xyz", "1 0 0")
    assert "give --xyz too" in error_of(capsys, "plan", "rover_arm", "--to", "ready", "--direction", "0 0 1")
