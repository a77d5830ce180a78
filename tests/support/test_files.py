"""Files written whole or not at all, descriptions that no output replaces, and lines of CSV in any encoding."""

from __future__ import annotations

import io
import os
import stat
from pathlib import Path

import pytest

from twistarm.support.csv_lines import Bounds, lines_in
from twistarm.support.errors import InputError
from twistarm.support.files import WRITTEN_XML, WRITTEN_YAML, open_regular, why_no_file, write_whole

NAMES = ["ARM.URDF", "arm.urdf.xacro", "arm.srdf", "arm.xml", "arm.toml", "joint_limits.yaml"]


@pytest.mark.parametrize("name", NAMES)
def test_no_description_is_lost_to_an_output(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text("mine")
    (tmp_path / "page.html").symlink_to(name)
    for target in (path, tmp_path / "page.html"):
        with pytest.raises(InputError, match=name):
            write_whole(target, "yours")
    assert path.read_text() == "mine"
    write_whole(path, "ours", over_description=True)
    assert path.read_text() == "ours"


def test_what_is_no_description_is_replaced(tmp_path: Path) -> None:
    ours = (("limits.yaml", f"{WRITTEN_YAML}: limits"), ("arm.urdf", f"<robot/>\n{WRITTEN_XML}\n"))
    for name, text in (("a.html", "old"), *ours):
        (tmp_path / name).write_text(text)
        assert write_whole(tmp_path / name, "new").read_text() == "new"


def test_text_and_bytes_arrive_as_they_are(tmp_path):
    assert write_whole(tmp_path / "a.txt", "θ\r\n").read_bytes() == "θ\r\n".encode()
    assert write_whole(str(tmp_path / "b"), b"\x00\xff").read_bytes() == b"\x00\xff"


@pytest.mark.parametrize("failing", ["replace", "fsync"])
def test_a_failure_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch, failing):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, failing, full)
    with pytest.raises(InputError, match=r"cannot write .*a\.txt: No space left on device"):
        write_whole(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize(
    ("path", "culprit"),
    [("missing/a.txt", "missing"), (".", "folder"), ("/dev/zero", "/dev/zero"), (None, "None"), ("a\0b", "a")],
)
def test_what_cannot_be_written_is_named(here, path, culprit):
    with pytest.raises(InputError, match=culprit):
        write_whole(path, "x")
    assert os.listdir(here) == []


def test_what_is_no_regular_file_is_never_read(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    for name in ("pipe", "zero", "."):
        with pytest.raises(OSError, match="it is no regular file"):
            open_regular(tmp_path / name)


def test_why_there_is_no_file(tmp_path):
    (tmp_path / "motion.toml").touch()
    assert why_no_file(tmp_path / "moton.toml") == "no such file; closest: 'motion.toml'"
    assert why_no_file(tmp_path / "nowhere" / "motion.toml") == "no such file"
    assert why_no_file(tmp_path) == "a folder"
    assert why_no_file(tmp_path / "motion.toml", OSError(13, "Permission denied")) == "Permission denied"


@pytest.mark.parametrize("mode", [0o600, 0o444, 0o664])
def test_a_file_keeps_its_permissions(mode: int, tmp_path: Path) -> None:
    path = tmp_path / "token"
    path.write_text("old")
    path.chmod(mode)
    write_whole(path, "new")
    assert (path.read_text(), stat.S_IMODE(path.stat().st_mode)) == ("new", mode)


TEXT = "Gelenk ä,b\n1,2\n"


@pytest.mark.parametrize(
    "data",
    [
        TEXT.encode(),
        TEXT.encode("utf-8-sig"),
        TEXT.encode("latin-1"),
        TEXT.encode("utf-16"),
        b"\xfe\xff" + TEXT.encode("utf-16-be"),
        TEXT.replace("\n", "\r\n").encode(),
        TEXT.replace("\n", "\r").encode(),
    ],
)
def test_lines_are_those_that_were_written_in_whatever_encoding(data: bytes) -> None:
    lines = lines_in(io.BytesIO(data), "it", Bounds(bytes=100, lines=10))
    assert [line.rstrip("\r\n") for line in lines] == ["Gelenk ä,b", "1,2"]


class Endless(io.RawIOBase):
    """A pipe whose other side writes for ever; `given` counts."""

    def __init__(self, text: bytes) -> None:
        self.text, self.given = text, 0

    def readable(self) -> bool:
        return True

    def readinto(self, into: bytearray) -> int:  # type: ignore[override]
        self.given += len(into)
        into[:] = (self.text * (len(into) // len(self.text) + 1))[: len(into)]
        return len(into)


@pytest.mark.parametrize("text", [b"\0", b"1,2\n", b"1," * 1_000 + b"\n"])
def test_what_has_no_end_is_left_soon(text: bytes) -> None:
    pipe = Endless(text)
    with pytest.raises(InputError, match="standard input"):
        list(lines_in(io.BufferedReader(pipe), "standard input", Bounds(bytes=1_000_000, lines=1000)))
    assert pipe.given < 1_100_000


@pytest.mark.parametrize(
    ("data", "lines"), [(b"x\n" + b"1," * 50_001, 10**9), (b"1\n" * 1001, 1000)], ids=["a long line", "many lines"]
)
def test_lines_are_measured_and_counted(data: bytes, lines: int) -> None:
    with pytest.raises(InputError, match="it"):
        list(lines_in(io.BytesIO(data), "it", Bounds(bytes=10**9, lines=lines)))
