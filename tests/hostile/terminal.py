"""Names that would be orders to a terminal, and every place from which the command line prints a name."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path

from twistarm.arm.baking import text_of
from twistarm.arm.loading.load import load_arm
from twistarm.checking.difference import golden_text
from urdf_text import joint, robot

FAKE = "FAKE"
"""What a name would make a line of its own begin with."""

NAMES: Mapping[str, str] = {
    "clears the screen": "a\x1b[2Jb",
    "a colour by C1": "a\x9b31mb",
    "another direction": "a\u202eb",
    "a line": f"a\n{FAKE}: all engines agree",
    "a next line": f"a\x85{FAKE}",
    "a tab": "a\tb",
    "a link": "[link=https://example.invalid]a[/link]",
    "markup that ends nothing": "a[/]b",
    "a backslash": "a\\",
    "an emoji": ":bomb:",
    "half a character": "a\ud800b",
    "a long name": "n" * 3000,
}

NOT_IN_XML = re.compile(r"[\0-\x08\x0b\x0c\x0e-\x1f\ud800]")

IN_XML = {name for name, text in NAMES.items() if not NOT_IN_XML.search(text)}
IN_TOML = {name for name, text in NAMES.items() if "\ud800" not in text}
NAMED = "NAMED"
"""In a command: the file that has the name."""

IN_FILE_NAMES = {name for name in IN_TOML if name not in ("a long name",)}


def _xml(text: str) -> str:
    return escape(text).replace("\n", "&#10;").replace("\r", "&#13;").replace("\t", "&#9;")


def _arm(folder: Path, name: str = "tiny", joint_name: str = "b", tip: str = "tool0", file: str = "arm.urdf") -> Path:
    links = ("base_link", "upper", _xml(tip))
    parts = (joint("a", "base_link", "upper", xyz="0.3 0 0"), joint(_xml(joint_name), "upper", links[2], xyz="0.3 0 0"))
    path = folder / file
    path.write_text(robot(*parts, links=links, name=_xml(name)), encoding="utf-8")
    return path


def _toml(folder: Path, text: str, name: str) -> None:
    _arm(folder)
    quoted = "".join(f"\\u{ord(c):04x}" if not c.isalnum() or not c.isascii() else c for c in name)
    (folder / "arm.toml").write_text('source = "arm.urdf"\n' + text.replace("@", f'"{quoted}"'), encoding="utf-8")


def _golden(folder: Path, name: str) -> None:
    arm = load_arm(_arm(folder))
    changed = replace(arm, name=name, tip=name, joint_names=("a", name))
    (folder / "golden.json").write_text(golden_text(changed))


def _baked(folder: Path, name: str) -> None:
    arm = load_arm(_arm(folder))
    links = {"base": name, "tip": name, "tip_link": name, "description": None}
    changed = replace(arm, name=name, joint_names=("a", name), source=name, named_states={name: arm.ready}, **links)
    (folder / "arm.json").write_text(text_of(changed))


def _postures(folder: Path, name: str) -> None:
    _arm(folder)
    cell = name.replace('"', '""')
    (folder / "in.csv").write_text(f'a,b,"{cell}"\n0.1,0.2,0.3\n', encoding="utf-8", newline="")


def _log(folder: Path, name: str) -> None:
    _toml(folder, "[actuators.left]\nratio = { a = 10.0 }\n", "x")
    (folder / "in.csv").write_text(f'left,"{name}",x,y,z\n1,2,3,4,5\n', encoding="utf-8", newline="")


def _srdf(folder: Path, name: str) -> None:
    _arm(folder)
    group = f'<group name="{_xml(name)}"><chain base_link="base_link" tip_link="tool0"/></group>'
    state = f'<group_state name="{_xml(name)}" group="{_xml(name)}"><joint name="a" value="0.1"/>'
    strangers = f'<joint name="{_xml(name)}" value="1"/></group_state>'
    (folder / "arm.srdf").write_text(f'<robot name="tiny">{group}{state}{strangers}</robot>', encoding="utf-8")


def _named_file(folder: Path, name: str) -> None:
    (folder / "arms").mkdir()
    (folder / "arms" / f"{name.replace('/', '_')}.urdf").write_text("<robot/>")


EVERY_COMMAND = (
    ("info", "arm.urdf"),
    ("info", "arm.urdf", "--json"),
    ("fk", "arm.urdf"),
    ("jacobian", "arm.urdf"),
    ("ik", "arm.urdf", "--xyz", "0.1 0.2 0.3"),
    ("ik", "arm.urdf", "--xyz", "0.1 0.2 0.3", "--json"),
    ("plan", "arm.urdf", "--to", "10 20"),
    ("check", "arm.urdf", "--samples", "5"),
    ("doctor", "arm.urdf"),
    ("doctor", "arm.urdf", "--json"),
    ("bake", "arm.urdf", "-o", "out.json", "--force"),
)


@dataclass(frozen=True)
class Carrier:
    """What carries a name to the command line: `put` writes it into a folder, `commands` read it."""

    put: Callable[[Path, str], object]
    commands: tuple[tuple[str, ...], ...]
    names: set[str]


CARRIERS: Mapping[str, Carrier] = {
    "a robot": Carrier(lambda folder, name: _arm(folder, name=name), EVERY_COMMAND, IN_XML),
    "a joint": Carrier(lambda folder, name: _arm(folder, joint_name=name), EVERY_COMMAND, IN_XML),
    "a link": Carrier(lambda folder, name: _arm(folder, tip=name), EVERY_COMMAND, IN_XML),
    "an arm.toml": Carrier(
        lambda folder, name: _toml(folder, "name = @\n[tool]\nname = @\n[poses.@]\na = 0.1\nb = 0.1\n", name),
        (
            ("info", "arm.toml"),
            ("info", "arm.toml", "--json"),
            ("fk", "arm.toml"),
            ("check", "arm.toml"),
            ("plan", "arm.toml", "--to", "1 2"),
        ),
        IN_TOML,
    ),
    "a motor": Carrier(
        lambda folder, name: _toml(folder, "[actuators.@]\nratio = { a = 10.0 }\n", name),
        (("info", "arm.toml"), ("info", "arm.toml", "--json"), ("doctor", "arm.toml")),
        IN_TOML,
    ),
    "an entry of an arm.toml": Carrier(
        lambda folder, name: _toml(folder, "@ = 1\n", name), (("info", "arm.toml"), ("doctor", "arm.toml")), IN_TOML
    ),
    "a golden file": Carrier(
        _golden,
        (
            ("check", "arm.urdf", "--samples", "5", "--against", "golden.json"),
            ("check", "arm.urdf", "--samples", "5", "--against", "golden.json", "--json"),
        ),
        set(NAMES),
    ),
    "a baked arm": Carrier(
        _baked,
        (
            ("info", "arm.json"),
            ("info", "arm.json", "--json"),
            ("fk", "arm.json"),
            ("ik", "arm.json", "--xyz", "1 2 3"),
            ("plan", "arm.json", "--to", "1 2"),
        ),
        set(NAMES),
    ),
    "a column of postures": Carrier(_postures, (("fk", "arm.urdf", "--configurations", "in.csv"),), IN_TOML),
    "a column of a log": Carrier(_log, (("wiring", "arm.toml", "in.csv"),), IN_TOML),
    "an SRDF": Carrier(_srdf, (("info", "arm.urdf"), ("info", "arm.urdf", "--json")), IN_XML),
    "a file's name": Carrier(
        _named_file,
        (
            ("doctor", f"{NAMED}.urdf"),
            ("doctor", f"{NAMED}.urdf", "--json"),
            ("check", f"{NAMED}.urdf", "--samples", "5"),
        ),
        IN_FILE_NAMES,
    ),
}


@dataclass(frozen=True)
class Case:
    """A carrier with a name, and a command that reads it."""

    name: str
    carrier: Carrier
    text: str
    command: tuple[str, ...]


def cases() -> Iterator[Case]:
    """Every name from everything that carries one, by every command."""
    for who, carrier in CARRIERS.items():
        for what in NAMES:
            if what in carrier.names:
                for command in carrier.commands:
                    typed = tuple(part.replace(NAMED, f"arms/{NAMES[what].replace('/', '_')}") for part in command)
                    yield Case(f"{who}: {what}: {' '.join(command)}", carrier, NAMES[what], typed)


def fault(code: int, said: str, shows: str = "") -> str:
    """What is wrong with what was printed; empty where nothing is. `shows` is what it should hold."""
    orders = sorted({c for c in said if not (c.isprintable() or c in "\n\xa0")})
    if orders:
        return f"printed as it is: {orders}"
    if any(line.strip(" │").startswith(FAKE) for line in said.splitlines()):
        return "a name became a line"
    if "fault of twistarm" in said or "Traceback" in said or code not in (0, 1, 2):
        return f"exit {code}: {said.strip().splitlines()[-1][:150]}"
    return "" if shows in said else f"does not show {shows!r}"
