"""Every reader of a file that somebody names, given what is no file, too large, or no honest program's."""

from __future__ import annotations

import os
import resource
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import pytest

from twistarm.arm.baking import text_of
from twistarm.arm.loading.load import load_arm
from twistarm.checking.difference import golden_text
from twistarm.cli.application import run
from urdf_text import two_joints, write

SECONDS, MEGABYTES = 20, 500  # Within these a hostile file is refused or loaded.

SRDF = '<robot name="tiny"><group name="arm"><chain base_link="base_link" tip_link="tool0"/></group></robot>'
TABLE = "a,b\n" + "0.1,0.2\n" * 3
LOG = "left,right,x,y,z\n" + "".join(f"{10 * k},{7 * k * k},0.1,0.2,1.0\n" for k in range(5))
RECORDING = "time [s],a.position [rad],b.position [rad]\n0,0.1,0\n1,0.1,0\n"
MOTORS = 'source = "arm.urdf"\n[actuators.left]\nratio = { a = 0.1 }\n[actuators.right]\nratio = { b = 0.1 }\n'

READERS: dict[str, tuple[str, str, str]] = {
    "a URDF": ("info in.urdf", "in.urdf", two_joints()),
    "a xacro file": ("info in.xacro", "in.xacro", two_joints()),
    "an arm.toml": ("info in.toml", "in.toml", MOTORS),
    "a baked arm": ("fk in.json", "in.json", "BAKED"),
    "a golden file": ("check arm.urdf --samples 5 --against in.json", "in.json", "GOLDEN"),
    "postures": ("fk arm.urdf --configurations in.csv", "in.csv", TABLE),
    "targets": ("ik arm.urdf --targets in.csv", "in.csv", "x,y,z\n0.1,0.2,0.3\n"),
    "a motion to play": ("view arm.urdf --play in.csv -o out.html", "in.csv", RECORDING),
    "a log of the wiring": ("wiring motors.toml in.csv", "in.csv", LOG),
    "an SRDF": ("info arm.urdf --srdf in.srdf", "in.srdf", SRDF),
    "an SRDF beside": ("info arm.urdf", "in.srdf", SRDF),
    "joint limits": ("info arm.urdf --limits in.yaml", "in.yaml", "joint_limits: {a: {max_velocity: 0.1}}\n"),
}
"""A command, the file that it reads, and what an honest one holds."""


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(path.name)  # a name of 100 characters at most


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(700_000_000)


NO_FILES: dict[str, Callable[[Path], object]] = {
    "a FIFO": os.mkfifo,
    "/dev/zero": lambda path: path.symlink_to("/dev/zero"),
    "a folder": lambda path: path.mkdir(),
    "a socket": _socket,
    "a link to itself": lambda path: path.symlink_to(path.name),
    "700 MB of nothing": _sparse,
}

TEXTS: dict[str, Callable[[str], str | bytes]] = {
    "nothing": lambda good: b"",
    "no UTF-8": lambda good: b"\xff\xc0\x80" * 1000,
    "brackets": lambda good: b"[" * 1_000_000,
    "one line of 100 MB": lambda good: b"1," * 50_000_000,
    "honest lines without end": lambda good: good + f"{good.splitlines()[-1]}\n" * 3_000_000,
    "5,000 digits": lambda good: good.replace("0.1", "1" + "0" * 4999).replace('"1"', f'"{"1" * 5000}"'),
    "no number": lambda good: good.replace("0.1", "NaN").replace('"1"', '"NaN"'),
    "a NUL": lambda good: good.replace("\n", "\0\n", 1),
    "a cell of a million characters": lambda good: good.replace("\n", f'\n"{"x" * 1_000_000}",', 1),
    "a name twice": lambda good: good + good.partition("\n")[2],
}

QUICK = ("a FIFO", "a link to itself", "no UTF-8", "5,000 digits", "a name twice")


@pytest.fixture(autouse=True)
def _patience() -> Iterator[None]:
    """A reader that waits for ever fails, and does not hold up all tests."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TimeoutError("it waits for ever")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def megabytes() -> float:
    """The most memory so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    "nasty", [case if case in QUICK else pytest.param(case, marks=pytest.mark.slow) for case in (*NO_FILES, *TEXTS)]
)
def test_everything_is_refused_in_one_line_or_read_within_the_bounds(
    reader: str, nasty: str, here: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arm = load_arm(write(here, two_joints()))
    write(here, MOTORS, "motors.toml")
    command, name, good = READERS[reader]
    if nasty in NO_FILES:
        NO_FILES[nasty](here / name)
    else:
        good = {"BAKED": text_of, "GOLDEN": golden_text}.get(good, lambda arm: good)(arm)
        content = TEXTS[nasty](good)
        (here / name).write_bytes(content.encode() if isinstance(content, str) else content)
    before = megabytes()
    code = run(command.split())
    said = capfd.readouterr()
    assert code in (0, 1, 2)
    assert "Traceback" not in said.err
    assert "fault of twistarm" not in said.err
    assert megabytes() - before < MEGABYTES
    if reader == "an SRDF beside":
        assert "tool0" in said.out  # the honest arm is told of all the same
    elif code == 2:
        (line,) = [line for line in said.err.splitlines() if not line.startswith(("note: ", "warning: "))]
        assert line.startswith("error: ")
        assert name in line
        assert len(line) < 2000
    (here / name).unlink() if (here / name).is_file() else None  # pytest would keep gigabytes
