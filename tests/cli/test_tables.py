"""Tables at the widths of terminals: no number is broken, and text loses nothing. One declaration serves JSON too."""

from __future__ import annotations

import re
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from twistarm.cli.application import run
from twistarm.cli.output import plain
from twistarm.cli.tables import Column, Table

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
