"""A shared key that signs datagrams, each valid once and briefly (docs/streaming.md)."""

from __future__ import annotations

import hmac
import os
import secrets
import time
from collections.abc import Callable

from ...support.checks import require, require_clock
from ...support.errors import InputError, shown
from ...support.files import as_path, read_bounded

WINDOW = 2 * 10**9
"""Nanoseconds for the difference of two computers' clocks plus the travel of a datagram."""


def read_key(path: str | os.PathLike[str]) -> bytes:
    """The key in a file without surrounding white space. Raises InputError for an unreadable file or an invalid key."""
    file = as_path(path)
    try:
        key = read_bounded(file, 2048).strip()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot read the key {shown(str(path))}: {why}") from error
    return checked_key(key)


def checked_key(key: bytes) -> bytes:
    """A checked key. Raises InputError without its bytes."""
    if not isinstance(key, bytes) or not 16 <= len(key) <= 1024:
        raise InputError("a key is 16 to 1024 bytes: `openssl rand -hex 32 > key` makes one")
    return key


def _mac(key: bytes, *said: bytes) -> bytes:
    return hmac.digest(key, b" ".join(said), "sha256").hex().encode()


class Signer:
    """Signs datagrams: `session counter mac text`, mac = HMAC-SHA256(key, "session counter text") (RFC 2104) in hex.

    session: 16 hexadecimal digits, drawn at the start. counter: nanoseconds since 1970, above the last one's.
    """

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key, self._now, self._counter = checked_key(key), require_clock(now, "now"), 0
        self._session = secrets.token_hex(8).encode()

    def sign(self, text: bytes) -> bytes:
        """The text as a signed datagram."""
        self._counter = max(self._counter + 1, self._now())
        said = self._session, b"%d" % self._counter, require(text, bytes, "text", "a message encoded")
        return b" ".join((*said[:2], _mac(self._key, *said), text))


class Verifier:
    """Accepts signed datagrams once each, in order, within 2 s of this computer's clock, none from before its start."""

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key, self._now = checked_key(key), require_clock(now, "now")
        self._floor = self._now()
        self._counters: dict[bytes, int] = {}

    def verified(self, datagram: bytes) -> bytes:
        """The text in a datagram. InputError where it is unsigned, forged, old, or was here before."""
        session, *parts = require(datagram, bytes, "datagram", "as it arrived").split(b" ", 3)
        if len(parts) != 3 or len(session) != 16 or not parts[0].isdigit() or len(parts[0]) > 20:
            raise InputError("it is not signed")
        digits, mac, text = parts
        if not hmac.compare_digest(mac, _mac(self._key, session, digits, text)):
            raise InputError("its signature is wrong: the keys differ, or it was forged")
        counter, now = int(digits), self._now()
        if abs(counter - now) > WINDOW:
            raise InputError(f"its time is {(counter - now) / 1e9:+.3g} s from ours (at most 2 s): set both clocks")
        if counter <= max(self._floor, self._counters.get(session, 0)):
            raise InputError("it was here before, came after a later one, or is older than this program")
        self._counters[session] = counter
        for silent in [each for each, last in self._counters.items() if now - last > WINDOW]:
            self._floor = max(self._floor, self._counters.pop(silent))  # still too old if this clock goes back
        return text
