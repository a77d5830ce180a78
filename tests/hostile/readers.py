"""What may stand where a user names a file, and every command that reads one: things that are no files, files too
large, and numbers, nesting and text that no honest program writes.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

from hostile.attempt import Outcome, attempt
from twistarm.arm.baking import text_of
from twistarm.arm.loading.load import load_arm
from twistarm.checking.difference import golden_text
from urdf_text import two_joints

ROWS = "a,b\n" + "0.1,0.2\n" * 3
TARGETS = "x,y,z\n0.1,0.2,0.3\n"
RECORDING = (
    "time [s],a.position [rad],a.velocity [rad/s],b.position [rad],b.velocity [rad/s]\n0,0,0,0,0\n1,0.1,0,0.1,0\n"
)
LOG = "left,right,x,y,z\n" + "".join(f"{10 * k},{7 * k * k},0.1,0.2,1.0\n" for k in range(5))
ARM = """source = "arm.urdf"
[actuators.left]
ratio = { a = 10.0 }
[actuators.right]
ratio = { b = 10.0 }
"""
LIMITS = "joint_limits:\n  a:\n    max_velocity: 1.0\n"
SRDF = """<robot name="tiny"><group name="arm"><chain base_link="base_link" tip_link="tool0"/></group>
<group_state name="up" group="arm"><joint name="a" value="2"/><joint name="b" value="0"/></group_state></robot>"""


@dataclass(frozen=True)
class Reader:
    """A command that reads a file of somebody's: its arguments, and the file in question, relative to the folder.

    `good` is what an honest file holds; beside it stand `arm.urdf` and `motors.toml`. One that `walks` finds the file
    by itself and tells of the honest arm all the same.
    """

    arguments: tuple[str, ...]
    file: str
    good: Callable[[], str]
    language: str
    walks: bool = False
    stdin: bool = False


@cache
def good_json(kind: str) -> str:
    """A golden file, or a baked arm, of the arm that stands beside."""
    folder = Path(os.environ.get("TMPDIR", "/tmp")) / f"twistarm-{os.getpid()}.urdf"
    try:
        folder.write_text(two_joints())
        arm = load_arm(folder)
    finally:
        with suppress(OSError):
            folder.unlink()
    return golden_text(arm) if kind == "golden" else text_of(arm)


def _is(text: str) -> Callable[[], str]:
    return lambda: text


READERS: Mapping[str, Reader] = {
    "a URDF": Reader(("info", "in.urdf"), "in.urdf", two_joints, "xml"),
    "a xacro file": Reader(("info", "in.xacro"), "in.xacro", two_joints, "xml"),
    "an arm.toml": Reader(("info", "in.toml"), "in.toml", _is(ARM), "toml"),
    "a baked arm": Reader(("fk", "in.json"), "in.json", lambda: good_json("baked"), "json"),
    "a golden file": Reader(
        ("check", "arm.urdf", "--samples", "5", "--against", "in.json"), "in.json", lambda: good_json("golden"), "json"
    ),
    "postures": Reader(("fk", "arm.urdf", "--configurations", "in.csv"), "in.csv", _is(ROWS), "csv"),
    "targets": Reader(("ik", "arm.urdf", "--targets", "in.csv"), "in.csv", _is(TARGETS), "csv"),
    "a motion to play": Reader(
        ("view", "arm.urdf", "--play", "in.csv", "-o", "out.html"), "in.csv", _is(RECORDING), "csv"
    ),
    "a log of the wiring": Reader(("wiring", "motors.toml", "in.csv"), "in.csv", _is(LOG), "csv"),
    "an SRDF": Reader(("info", "arm.urdf", "--srdf", "in.srdf"), "in.srdf", _is(SRDF), "xml"),
    "joint limits": Reader(("info", "arm.urdf", "--limits", "in.yaml"), "in.yaml", _is(LIMITS), "yaml"),
    "targets from standard input": Reader(
        ("ik", "arm.urdf", "--targets", "-"), "in.csv", _is(TARGETS), "csv", stdin=True
    ),
    "an SRDF beside": Reader(("info", "arm.urdf"), "beside.srdf", _is(SRDF), "xml", walks=True),
}


# -- what is no file ---------------------------------------------------------------------------------------------


def _socket(path: Path) -> None:
    here = os.getcwd()
    os.chdir(path.parent)  # the name of a socket has 100 characters at most
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind(path.name)
    finally:
        os.chdir(here)


def _loop(path: Path) -> None:
    path.symlink_to(path.name)


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(700_000_000)


NO_FILES: Mapping[str, Callable[[Path], None]] = {
    "a FIFO": os.mkfifo,
    "/dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
    "a socket": _socket,
    "a link to itself": _loop,
    "a link to nothing": lambda path: path.symlink_to("nowhere"),
    "700 MB of nothing": _sparse,
}


READABLE = ("/dev/zero", "700 MB of nothing")
"""What a shell can make standard input of."""


# -- what no honest program writes -------------------------------------------------------------------------------

ANY_TEXT: Mapping[str, Callable[[], bytes]] = {
    "nothing": lambda: b"",
    "NUL bytes": lambda: bytes(10_000_000),
    "ten million lines": lambda: b"1\n" * 10_000_000,
    "one line of 100 MB": lambda: b"1," * 50_000_000,
    "a million columns": lambda: b"1," * 1_000_000,
    "no UTF-8": lambda: b"\xff\xc0\x80" * 1000,
    "brackets": lambda: b"[" * 1_000_000,
}

NUMBERS = {
    "401 digits": "1" + "0" * 400, "5,000 digits": "1" + "0" * 4999, "a million digits": "1" * 1_000_000,
    "NaN": "NaN", "1e400": "1e400",
}  # fmt: skip

FIRST = {"csv": "0.1", "toml": "10.0", "yaml": "1.0", "xml": '"2"', "json": " 0.0"}
"""A number in an honest file of each language, for which another stands."""


def in_text(good: str, language: str) -> Iterator[tuple[str, Callable[[], str]]]:
    """An honest file with one thing in it that is not."""
    lines, first = good.splitlines(), FIRST[language]
    for name, number in NUMBERS.items():
        yield f"{name} in it", partial(good.replace, first, first.replace(first.strip(' "'), number), 1)
    yield "a byte order mark, and again", lambda: "\ufeff\ufeff" + good
    yield "a NUL in it", lambda: good.replace("\n" if "\n" in good else " ", "\0\n", 1)
    if language == "csv":
        yield "a cell of a million characters", lambda: good.replace("\n", f'\n"{"x" * 1_000_000}",', 1)
        yield "a quotation without end", lambda: good.replace("\n", '\n"', 1) + "1,2\n" * 1_000_000
        yield "columns named alike", lambda: good.replace(",", f",{good.split(',')[0]},", 1)
        yield "honest rows without end", lambda: good + f"{lines[-1]}\n" * 3_000_000
    if language == "toml":
        yield "a name twice", lambda: good + "[actuators.left]\nratio = { a = 1.0 }\n"
        yield "a table in a table without end", lambda: good + "x = " + "{a=" * 900 + "1" + "}" * 900
    if language == "yaml":
        yield "a name twice", lambda: good + "joint_limits: {}\n"
    if language == "json":
        yield "a name twice", lambda: good.rstrip()[:-1] + ', "tip": "another"}'
        yield "brackets for a name", lambda: good.replace('"tip":', f'"tip": {"[" * 900}{"]" * 900}, "x":', 1)


# -- the cases ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A reader and what stands where it is told to read; `prepare` puts it into an empty folder."""

    name: str
    reader: Reader
    put: Callable[[Path], None]

    def prepare(self, folder: Path) -> None:
        (folder / "arm.urdf").write_text(two_joints())
        (folder / "motors.toml").write_text(ARM)
        file = folder / self.reader.file
        file.parent.mkdir(exist_ok=True)
        if file.parent != folder:
            (file.parent / "arm.urdf").write_text(two_joints())
        self.put(file)

    def attempt(self, folder: Path) -> Outcome:
        """What comes of it, in a process of its own."""
        self.prepare(folder)
        with open(folder / self.reader.file if self.reader.stdin else os.devnull, "rb") as stdin:
            return attempt(*self.reader.arguments, folder=folder, stdin=stdin, seconds=20.0)

    def fault(self, outcome: Outcome) -> str:
        """What is wrong with what came of it; empty where nothing is."""
        said = outcome.within()
        if said:
            return said
        if self.reader.walks:
            return "" if "tool0" in outcome.output else "the good arm beside it is not told of"
        if outcome.code == 2 and not _one_clear_line(outcome.errors):
            return f"not one clear line: {outcome.errors[:200]!r}"
        return ""


def _one_clear_line(errors: str) -> bool:
    lines = [line for line in errors.splitlines() if not line.startswith(("note: ", "warning: "))]
    if len(lines) != 1 or not lines[0].startswith("error: ") or len(lines[0]) > 2000:
        return False
    return "in." in lines[0] or "standard input" in lines[0]


def _writing(make: Callable[[], str | bytes]) -> Callable[[Path], None]:
    def put(path: Path) -> None:
        content = make()
        path.write_bytes(content.encode() if isinstance(content, str) else content)

    return put


def cases() -> Iterator[Case]:
    """Every reader with everything."""
    for who, reader in READERS.items():
        for what, put in NO_FILES.items():
            if not (reader.walks and what == "a folder") and not (reader.stdin and what not in READABLE):
                yield Case(f"{who}: {what}", reader, put)
        for what, content in (*ANY_TEXT.items(), *in_text(reader.good(), reader.language)):
            yield Case(f"{who}: {what}", reader, _writing(content))
