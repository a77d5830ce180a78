"""Lines of CSV as people's programs write them, and where reading stops."""

from __future__ import annotations

import io

import pytest

from twistarm.support.csv_lines import Bounds, lines_in
from twistarm.support.errors import InputError

FEW = Bounds(bytes=100, lines=10)

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
    assert [line.rstrip("\r\n") for line in lines_in(io.BytesIO(data), "it", FEW)] == ["Gelenk ä,b", "1,2"]


@pytest.mark.parametrize("data", [b"", b"1", b"1\r\n"])
def test_short_files_are_whole(data: bytes) -> None:
    assert "".join(lines_in(io.BytesIO(data), "it", FEW)).encode() == data


class Endless(io.RawIOBase):
    """A pipe whose other side writes for ever; `read` counts."""

    def __init__(self, text: bytes) -> None:
        self.text, self.given = text, 0

    def readable(self) -> bool:
        return True

    def readinto(self, into: bytearray) -> int:  # type: ignore[override]
        self.given += len(into)
        into[:] = (self.text * (len(into) // len(self.text) + 1))[: len(into)]
        return len(into)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"\0", "standard input is too large: at most 1 MB and 1,000 lines are read; split it, or leave out lines"),
        (b"1,2\n", "standard input is too large: at most 1 MB and 1,000 lines are read; split it, or leave out lines"),
        (b"1," * 1_000 + b"\n", "standard input is too large: at most 1 MB and 1,000 lines are read"),
    ],
)
def test_what_has_no_end_is_left_soon(text: bytes, said: str) -> None:
    pipe = Endless(text)
    with pytest.raises(InputError, match=said):
        list(lines_in(io.BufferedReader(pipe), "standard input", Bounds(bytes=1_000_000, lines=1000)))
    assert pipe.given < 1_100_000


def test_a_line_too_long_is_refused() -> None:
    with pytest.raises(InputError, match="it, line 2: more than 100,000 characters"):
        list(lines_in(io.BytesIO(b"x\n" + b"1," * 50_001), "it", Bounds(bytes=10**9, lines=10**9)))


def test_lines_are_counted_however_short() -> None:
    with pytest.raises(InputError, match="at most 1 MB and 1,000 lines"):
        list(lines_in(io.BytesIO(b"1\n" * 1001), "a pipe", Bounds(bytes=1_000_000, lines=1000)))
