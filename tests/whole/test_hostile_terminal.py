"""Names that would be orders to a terminal are shown, from wherever they come and wherever the command line prints."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from html import escape
from pathlib import Path

import pytest

from twistarm.arm.baking import text_of
from twistarm.arm.loading.load import load_arm
from twistarm.cli.application import run
from twistarm.cli.output import print_json
from twistarm.support.errors import printable
from urdf_text import joint, robot, write

FAKE = "FAKE"  # What a name would make a line of its own begin with.

NAMES = {
    "clears the screen": "a\x1b[2Jb",
    "a colour by C1": "a\x9b31mb",
    "another direction": "a\u202eb",
    "a line": f"a\n{FAKE}: all engines agree",
    "a next line": f"a\x85{FAKE}",
    "a link": "[link=https://example.invalid]a[/link]",
    "markup that ends nothing": "a[/]b",
    "a backslash": "a\\",
    "half a character": "a\ud800b",
    "a long name": "n" * 3000,
}

NOT_IN_XML = re.compile(r"[\0-\x08\x0b\x0c\x0e-\x1f\ud800]")

QUICK = ("a colour by C1", "a line", "a link")


def _xml(text: str) -> str:
    return escape(text).replace("\n", "&#10;").replace("\r", "&#13;").replace("\t", "&#9;")


def _arm(name: str = "tiny", joint_name: str = "b", tip: str = "tool0", file: str = "arm.urdf") -> Path:
    links = ("base_link", "upper", _xml(tip))
    parts = (joint("a", "base_link", "upper", xyz="0.3 0 0"), joint(_xml(joint_name), "upper", links[2], xyz="0.3 0 0"))
    return write(Path(), robot(*parts, links=links, name=_xml(name)), file)


def _toml(text: str, name: str) -> None:
    _arm()
    quoted = "".join(f"\\u{ord(c):04x}" if not c.isalnum() or not c.isascii() else c for c in name)
    write(Path(), 'source = "arm.urdf"\n' + text.replace("@", f'"{quoted}"'), "arm.toml")


def _baked(name: str) -> None:
    arm, links = load_arm(_arm()), {"base": name, "tip": name, "tip_link": name, "description": None}
    changed = replace(arm, name=name, joint_names=("a", name), source=name, named_states={name: arm.ready}, **links)
    write(Path(), text_of(changed), "arm.json")


def _srdf(name: str) -> None:
    _arm()
    group = f'<group name="{_xml(name)}"><chain base_link="base_link" tip_link="tool0"/></group>'
    state = f'<group_state name="{_xml(name)}" group="{_xml(name)}"><joint name="a" value="1"/></group_state>'
    write(Path(), f'<robot name="tiny">{group}{state}</robot>', "arm.srdf")


URDF = (
    "info arm.urdf", "info arm.urdf --json", "fk arm.urdf", "jacobian arm.urdf", "ik arm.urdf --xyz 0.1 0.2 0.3",
    "plan arm.urdf --to 10 20", "check arm.urdf --samples 5", "doctor arm.urdf", "doctor arm.urdf --json",
    "bake arm.urdf -o out.json --force",
)  # fmt: skip
TOML = ("info arm.toml", "doctor arm.toml --json", "plan arm.toml --to 1 2")
CARRIERS: dict[str, tuple[Callable[[str], object], tuple[str, ...]]] = {
    "a robot": (lambda name: _arm(name=name), URDF),
    "a joint": (lambda name: _arm(joint_name=name), URDF),
    "a link": (lambda name: _arm(tip=name), URDF),
    "an SRDF": (_srdf, ("info arm.urdf", "info arm.urdf --json")),
    "an arm.toml": (lambda name: _toml("name = @\n[tool]\nname = @\n[poses.@]\na = 0.1\nb = 0.1\n", name), TOML),
    "a motor": (lambda name: _toml("[actuators.@]\nratio = { a = 10.0 }\n", name), TOML),
    "an entry of an arm.toml": (lambda name: _toml("@ = 1\n", name), TOML),
    "a baked arm": (_baked, ("info arm.json", "info arm.json --json", "ik arm.json --xyz 1 2 3")),
}
"""What writes a name into the folder, and the commands that print it."""

IN_XML = ("a robot", "a joint", "a link", "an SRDF")

CASES = [
    pytest.param(who, what, command, marks=() if what in QUICK and command is commands[0] else pytest.mark.slow)
    for who, (_, commands) in CARRIERS.items()
    for what, text in NAMES.items()
    if who == "a baked arm" or not (NOT_IN_XML.search(text) if who in IN_XML else "\ud800" in text)
    for command in commands
]


@pytest.mark.parametrize(("who", "what", "command"), CASES)
def test_every_name_is_shown(who: str, what: str, command: str, capsys: pytest.CaptureFixture[str], here: Path) -> None:
    CARRIERS[who][0](NAMES[what])
    capsys.readouterr()
    code = run(command.split())
    said = "".join(capsys.readouterr())
    assert code in (0, 1, 2)
    assert "fault of twistarm" not in said
    assert [c for c in said if not (c.isprintable() or c in "\n\xa0")] == []
    assert not any(line.strip(" │").startswith(FAKE) for line in said.splitlines())
    if (who, command) == ("a robot", "info arm.urdf") and len(NAMES[what]) < 100:
        assert printable(NAMES[what]) in said


def test_json_shows_what_a_terminal_would_obey_as_json_escapes_it(capsys: pytest.CaptureFixture[str]) -> None:
    name = "a\x1b[31m\x9b31m\u202e\ud800ξ"
    print_json({"name": name})
    shown = capsys.readouterr().out
    assert shown == '{\n  "name": "a\\u001b[31m\\u009b31m\\u202e\\ud800ξ"\n}\n'
    assert json.loads(shown) == {"name": name}
