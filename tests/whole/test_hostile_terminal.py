"""Names that would be orders to a terminal are shown, from wherever they come and wherever the command line prints."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hostile.terminal import CARRIERS, NAMES, Case, cases, fault
from twistarm.cli.application import run
from twistarm.cli.output import print_json
from twistarm.support.errors import printable

SEEN = ("markup", "a link", "markup that ends nothing", "a backslash", "an emoji", "a colour by C1")
"""Of which `info` must show every character, those that are no orders as they are."""

SAMPLED = {"a colour by C1", "a line", "a link"}


def tried(case: Case, capsys: pytest.CaptureFixture[str]) -> str:
    case.carrier.put(Path(), case.text)
    capsys.readouterr()
    code = run(case.command)
    said = capsys.readouterr()
    seen = case.command[0] == "info" and case.command[-1] != "--json" and case.text in map(NAMES.get, SEEN)
    shows = printable(case.text) if seen and case.carrier is CARRIERS["a robot"] else ""
    return fault(code, said.out + said.err, shows)


def sampled() -> list[Case]:
    """One command for each carrier and each of a few names; doctor, which says most, for a line in each description."""
    first = {case.name.rpartition(": ")[0]: case for case in reversed(list(cases()))}
    few = [case for name, case in first.items() if name.split(": ")[1] in SAMPLED]
    return few + [case for case in cases() if ": a line: doctor arm.urdf" in case.name and "--json" not in case.command]


@pytest.mark.parametrize("case", sampled(), ids=lambda case: case.name)
def test_a_sample_is_shown(
    case: Case, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert tried(case, capsys) == ""


@pytest.mark.slow
def test_every_name_is_shown(
    capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    every, faults = list(cases()), []
    for case in every:
        monkeypatch.chdir(tmp_path_factory.mktemp("names"))
        found = tried(case, capsys)
        faults += [f"{case.name}: {found}"] * bool(found)
    with capsys.disabled():
        print(f"names on a terminal: {len(every)} cases, {len(faults)} faults", *faults, sep="\n  ")
    assert not faults


def test_json_shows_what_a_terminal_would_obey_as_json_escapes_it(capsys: pytest.CaptureFixture[str]) -> None:
    name = "a\x1b[31m\x9b31m\u202e\ud800ξ"
    print_json({"name": name})
    shown = capsys.readouterr().out
    assert shown == '{\n  "name": "a\\u001b[31m\\u009b31m\\u202e\\ud800ξ"\n}\n'
    assert json.loads(shown) == {"name": name}
