"""Tables at the widths of terminals: what a cell or a head holds is never broken inside a word or a number."""

from __future__ import annotations

import re

import pytest
from rich.console import Console

from twistarm.cli.application import run
from twistarm.cli.output import table

COMMANDS = (
    "info rover_arm",
    "check ur5 --samples 5",
    "fk kinova",
    "jacobian ur10 --rad --theta 0.123456 -1.5 1.5 0.123456 0.1 3.123456",
    "ik ur5 --xyz 0.4 0.1 0.4 --direction 0 0 -1",
    "plan ur5 --from zero --to 10.123456 20.123456 -30.123456 40.123456 50.123456 -60.123456",
)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("width", [80, pytest.param(60, marks=pytest.mark.slow)])
def test_no_word_or_number_is_broken(
    command: str, width: int, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever is one word where there is room is one word here; joints' names may be cut behind underscores."""
    pieces = []
    for columns in (width, 400):
        monkeypatch.setenv("COLUMNS", str(columns))
        assert run(command.split()) == 0
        shown = capsys.readouterr().out
        assert all(len(line.rstrip()) <= columns for line in shown.splitlines() if "─" in line)
        pieces.append(
            {piece for word in re.findall(r"[\w.\-°²/]+", shown) for piece in re.findall(r"[^_]*_+|[^_]+", word)}
        )
    narrow, wide = pieces
    assert narrow <= wide


def test_columns_that_do_not_fit_go_on_below() -> None:
    rows = [["a", *range(100_000, 100_009)], ["b", *range(9)]]
    made = table("t", ["joint", *(f"column_{k}" for k in range(9))], rows)
    console = Console(width=40)
    with console.capture() as captured:
        console.print(made)
    shown = [line.split() for line in captured.get().splitlines()]
    assert [row for row in shown if row[:1] == ["a"]] == [
        ["a", "100000", "100001", "100002"],
        ["a", "100003", "100004", "100005"],
        ["a", "100006", "100007", "100008"],
    ]
    assert max(map(len, captured.get().splitlines())) <= 40


def test_a_cell_wider_than_the_terminal_is_folded_and_loses_nothing() -> None:
    console = Console(width=20)
    with console.capture() as captured:
        console.print(table("", ["joint", "value"], [["x" * 30, "1.25"]]))
    assert captured.get().count("x") == 30
    assert "1.25" in captured.get()
