"""`-o`: one way to name what a command writes, and nothing that stands there is lost; tables that fit a terminal."""

from __future__ import annotations

import csv
import json
import os
import re
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from test_cli import Capture, answer, error_of
from twistarm.cli.application import run
from twistarm.cli.output import plain
from twistarm.cli.tables import Column, Table
from urdf_text import two_joints, write

PLAN = ["plan", "arm.urdf", "--from", "zero", "--to", "10 10", "--acceleration", "3"]
WRITES = {
    "init": (["init", "arm.urdf"], "arm.toml"),
    "freeze": (["freeze", "arm.urdf"], "golden.json"),
    "bake": (["bake", "arm.urdf"], "baked.json"),
    "plan": (PLAN, "motion.csv"),
    "plan a message": ([*PLAN, "--format", "json"], "motion.json"),
    "view": (["view", "arm.urdf"], "page.html"),
    "doctor --fix": (["doctor", "arm.urdf", "--fix"], "fixed.urdf"),
}

STABLE = 500_000  # Bytes that are compared: behind the page's code stand its own times.


@pytest.fixture
def folder(here: Path) -> Path:
    write(here, two_joints())
    return here


@pytest.mark.parametrize("case", WRITES)
def test_a_file_is_written_kept_replaced_and_piped(
    case: str, folder: Path, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    command, name = WRITES[case]
    assert run([*command, "-o", name]) == 0
    written = (folder / name).read_bytes()[:STABLE]
    (folder / name).write_text("mine")
    capsysbinary.readouterr()
    assert run([*command, "--output", name]) == 2
    out, err = capsysbinary.readouterr()
    assert out == b""
    assert name in err.decode()
    assert (folder / name).read_text() == "mine"
    assert run([*command, "-o", name, "--force"]) == 0
    assert (folder / name).read_bytes()[:STABLE] == written
    capsysbinary.readouterr()
    assert run([*command, "-o", "-"]) == 0
    out, err = capsysbinary.readouterr()
    assert out[:STABLE] == written
    assert not err.decode().rstrip().endswith(" -"), "no command reads standard output again"
    assert sorted(os.listdir(folder)) == sorted(["arm.urdf", name])
    assert run([*command, "-o", f"nowhere/{name}"]) == 2


@pytest.mark.parametrize("command", ["init", "freeze", "bake"])
def test_without_a_name_nothing_is_replaced_either(command: str, folder: Path, capsys: Capture) -> None:
    assert run([command, "arm.urdf"]) == 0
    capsys.readouterr()
    assert "--force" in error_of(capsys, command, "arm.urdf")


def test_several_kinds_in_one_call(folder: Path, capsys: Capture) -> None:
    content = answer(capsys, *PLAN, "-o", "a.csv", "-o", "a.json")
    assert content["written"] == ["a.csv", "a.json"]
    assert json.loads((folder / "a.json").read_text())["joint_names"] == ["a", "b"]
    # One of them on standard output: what is said goes beside it.
    assert run([*PLAN, "-o", "-", "-o", "b.json"]) == 0
    out, err = capsys.readouterr()
    assert out == (folder / "a.csv").read_text()
    assert err.endswith("\nwritten: b.json\n")


REFUSED = {
    "a kind nobody knows": ([*PLAN, "-o", "motion.txt"], "motion.txt"),
    "a name against its kind": ([*PLAN, "-o", "m.csv", "--format", "json"], "m.csv"),
    "a format nobody knows": ([*PLAN, "-o", "-", "--format", "txt"], "'txt'"),
    "two on standard output": ([*PLAN, "-o", "-", "-o", "-"], "-o -"),
    "an answer beside it": ([*PLAN, "-o", "-", "--json"], "--json"),
    "a repaired copy without a name": (["doctor", "arm.urdf", "--fix"], "--fix"),
    "one file of two that is there": ([*PLAN, "-o", "new.csv", "-o", "old.json"], "old.json"),
    "a page of two arms": (["view", "arm.urdf", "ur5", "-o", "page.html"], "second ARM"),
    "a description": (["freeze", "arm.urdf", "-o", "arm.urdf", "--force"], "arm.urdf"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_written_is_said_before_anything_is(case: str, folder: Path, capsys: Capture) -> None:
    command, culprit = REFUSED[case]
    (folder / "old.json").write_text("mine")
    assert culprit in error_of(capsys, *command)
    assert sorted(os.listdir(folder)) == ["arm.urdf", "old.json"]
    assert (folder / "old.json").read_text() == "mine"


def test_the_motors_of_a_motion_are_written_within_their_limits(folder: Path) -> None:
    """Two joints at once ask of a motor what neither asks alone. What reads a motion passes over the motors."""
    motor = "[actuators.left]\nratio = { a = 50.0, b = -50.0 }\nlimits = { velocity = 30.0 }\n"
    motor += 'unit = "tick"\nticks_per_turn = 4096\n'
    (folder / "arm.toml").write_text(f'source = "arm.urdf"\n{motor}')
    command = ["plan", "arm.toml", "--from", "zero", "--to", "50 -50", "--acceleration", "3", "-o", "motion.csv"]
    assert run(command) == 0
    with open(folder / "motion.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    # 50° and −50° of the joints are 5000° of the motor.
    assert float(rows[-1]["left.counts [tick]"]) == pytest.approx(5000 / 360 * 4096)
    speeds = [float(row["left.motor_velocity [rad/s]"]) for row in rows]
    assert 30.0 * (1 - 1e-3) <= max(speeds) <= 30.0 * (1 + 1e-9)
    assert run(["view", "arm.toml", "--play", "motion.csv", "-o", "page.html"]) == 0


COMMANDS = (
    "info rover_arm",
    "check ur5 --samples 5",
    "jacobian ur10 --rad --theta 0.123456 -1.5 1.5 0.123456 0.1 3.123456",
    "plan ur5 --from zero --to 10.123456 20.123456 -30.123456 40.123456 50.123456 -60.123456",
    "payload rover_arm",
)


def printed(table: Table, width: int, radians: bool = False) -> list[str]:
    console = Console(file=StringIO(), width=width)
    table.print_on(console, radians)
    return console.file.getvalue().splitlines()  # type: ignore[attr-defined]


@pytest.mark.parametrize("command", COMMANDS)
def test_tables_fit_a_terminal_and_break_no_number(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    numbers = []
    for columns in (80, 400):
        monkeypatch.setenv("COLUMNS", str(columns))
        assert run(command.split()) == 0
        shown = capsys.readouterr().out
        assert all(len(line.rstrip()) <= columns for line in shown.splitlines() if "──" in line)
        numbers.append(re.findall(r"(?<![\w.])-?\d+\.\d+(?:e-\d+)?(?![\w.])", shown))
    assert sorted(numbers[0]) == sorted(numbers[1])


def test_numbers_stay_whole_where_nothing_fits_and_text_is_folded() -> None:
    columns = [Column("joint", ["a"]), *(Column(f"column_{k}", [100_000.0 + k]) for k in range(9))]
    assert all(f"10000{k}" in printed(Table("", columns), 40)[-1] for k in range(9))
    words = printed(Table("", [Column("joint", ["a"]), Column("why", ["x" * 30 + " y" * 30]), *columns[1:3]]), 50)
    assert "".join(words).count("x") == 30
    assert "".join(words).count(" y") == 30
    assert max(map(len, words)) <= 50


def test_units_are_declared_once() -> None:
    joints = Column("joint", ("slide", "elbow"), key="joint_names")
    theta = Column("theta", np.array([0.5, np.pi]), ("m", "rad"))
    speed = Column("speed", np.array([0.1, np.pi / 2]), ("m", "rad"), "/s")
    angle = Column("angle", np.array([0.0, np.inf]), "rad")
    table = Table("t", [joints, theta, speed, angle, Column("hidden", (1, 2), people=False)], "")
    assert plain(table.entries()) == {
        "joint_names": ["slide", "elbow"], "theta": [0.5, np.pi], "speed": [0.1, np.pi / 2], "angle": [0.0, None],
        "hidden": [1, 2],
    }  # fmt: skip
    degrees, radians = (printed(table, 100, rad) for rad in (False, True))
    assert degrees[1].split() == ["joint", "unit", "theta", "speed", "/s", "angle", "[°]"]
    assert degrees[-1].split() == ["elbow", "°", "180", "90", "−"]
    assert radians[-1].split() == ["elbow", "rad", "3.1416", "1.5708", "−"]
    records = Table("t", [joints, theta], "joints").entries()["joints"]
    assert records[1] == {"joint_names": "elbow", "theta": np.pi}
