"""Check that a browser wrote the requested PNG."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

FEWEST_VALUES = 16
"""A picture of one colour has fewer different bytes, its rows being differences: filter, first pixel, zeros."""


def fault(data: bytes, size: tuple[int, int]) -> str | None:
    """What is wrong with a PNG of `size` that should not be empty."""
    try:
        if data[:8] != b"\x89PNG\r\n\x1a\n":
            raise ValueError("signature")
        chunks = list(_chunks(data))
        found = struct.unpack(">II", chunks[0][1][:8])
        pixels = zlib.decompress(b"".join(content for kind, content in chunks if kind == b"IDAT"))
    except (ValueError, IndexError, struct.error, zlib.error):
        return "wrote a picture that is not a whole PNG"
    if found != size:
        return "drew {} x {} pixels instead of {} x {}".format(*found, *size)
    if len(set(pixels)) < FEWEST_VALUES:
        return "drew an empty page, as without WebGL; update it, or save the page (-o FILE.html) and open that"
    return None


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Type and content of each chunk (PNG specification, 5.3). Raises struct.error for a truncated file."""
    at, kind = 8, b""
    while kind != b"IEND":
        length, kind = struct.unpack_from(">I4s", data, at)
        yield kind, data[at + 8 : at + 8 + length]
        at += 12 + length
