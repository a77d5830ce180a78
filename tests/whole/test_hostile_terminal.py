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

CASES = list(cases())

FIRST = {case.name.rpartition(": ")[0]: case.name for case in reversed(CASES)}
QUICK = {name for name in FIRST.values() if name.split(": ")[1] in ("a colour by C1", "a line", "a link")}
QUICK |= {case.name for case in CASES if case.name.endswith(": a line: doctor arm.urdf")}
"""One command for each carrier and each of a few names; doctor, which says most, for a line in each description."""


@pytest.mark.parametrize(
    "case", [pytest.param(c, id=c.name, marks=() if c.name in QUICK else pytest.mark.slow) for c in CASES]
)
def test_every_name_is_shown(
    case: Case, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    case.carrier.put(Path(), case.text)
    capsys.readouterr()
    code = run(case.command)
    said = capsys.readouterr()
    seen = case.command[0] == "info" and case.command[-1] != "--json" and case.text in map(NAMES.get, SEEN)
    shows = printable(case.text) if seen and case.carrier is CARRIERS["a robot"] else ""
    assert fault(code, said.out + said.err, shows) == ""


def test_json_shows_what_a_terminal_would_obey_as_json_escapes_it(capsys: pytest.CaptureFixture[str]) -> None:
    name = "a\x1b[31m\x9b31m\u202e\ud800ξ"
    print_json({"name": name})
    shown = capsys.readouterr().out
    assert shown == '{\n  "name": "a\\u001b[31m\\u009b31m\\u202e\\ud800ξ"\n}\n'
    assert json.loads(shown) == {"name": name}
