"""Lines of CSV as people's programs write them, and where reading stops."""

from __future__ import annotations

import io

import pytest

from twistarm.support.csv_lines import Bounds, lines_in
from twistarm.support.errors import InputError

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
