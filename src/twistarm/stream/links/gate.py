"""Whose datagrams count: hosts that are allowed, and a shared key that signs what is sent, once and in time."""

from __future__ import annotations

import hmac
import ipaddress
import os
import secrets
import socket
import stat
import time
import warnings
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator
from typing import Any

from ...support.checks import require, require_clock, require_names
from ...support.errors import InputError, shown
from ...support.files import as_path, read_bounded
from .sockets import named

WINDOW = 2.0
"""Seconds that the clocks of two computers may differ, and that a signed datagram may be under way."""

SHORTEST_KEY, LONGEST_KEY = 16, 1024
"""Bytes of a key."""

SECOND = 10**9
"""In nanoseconds, which the counters count."""


class ExposedPortWarning(UserWarning):
    """A port beyond this machine was opened with neither senders nor a key: whoever reaches it moves the arm."""


def read_key(path: str | os.PathLike[str]) -> bytes:
    """The key in a file, white space around it left out. InputError where it cannot be read, is shorter than 16 bytes
    or longer than 1024, or where others than its owner may read or change the file.
    """
    file = as_path(path)
    try:
        key = read_bounded(file, LONGEST_KEY).strip()
        mode = os.stat(file).st_mode
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot read the key {shown(str(path))}: {why}") from error
    if mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise InputError(f"the key {str(path)!r} is open to others: chmod 600 it, and make a new one")
    return checked_key(key)


def checked_key(key: bytes) -> bytes:
    """A key; InputError where it is none. Its bytes are in no message."""
    if not isinstance(key, bytes) or not SHORTEST_KEY <= len(key) <= LONGEST_KEY:
        raise InputError(f"a key is {SHORTEST_KEY} to {LONGEST_KEY} bytes: `openssl rand -hex 32 > key` makes one")
    return key


class Signer:
    """Signs datagrams: `session counter mac text`, mac = HMAC-SHA256(key, "session counter text") (RFC 2104) in hex.

    session: 16 hexadecimal digits, drawn anew by each sender at its start. counter: nanoseconds since 1970, above the
    last one's.
    """

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key = checked_key(key)
        self._now = require_clock(now, "now")
        self._session = secrets.token_hex(8)
        self._counter = 0

    def sign(self, text: bytes) -> bytes:
        """The text as a signed datagram."""
        require(text, bytes, "text", "a message encoded")
        self._counter = max(self._counter + 1, self._now())
        head = b"%s %d" % (self._session.encode(), self._counter)
        return b" ".join((head, _mac(self._key, head, text), text))


class Verifier:
    """Takes signed datagrams, each once and within `WINDOW` of this computer's clock.

    Nothing that is older than this verifier counts, so that nobody plays what was recorded before a restart. A sender
    that starts anew is a new session, and heard at once; one whose clock is off is heard again once it is right.
    """

    def __init__(self, key: bytes, now: Callable[[], int] = time.time_ns) -> None:
        self._key = checked_key(key)
        self._now = require_clock(now, "now")
        self._floor = self._now()
        self._counters: dict[bytes, int] = {}

    def verified(self, datagram: bytes) -> bytes:
        """The text in a datagram. InputError where it is unsigned, forged, old, or was here before."""
        parts = require(datagram, bytes, "datagram", "as it arrived").split(b" ", 3)
        if len(parts) != 4 or len(parts[0]) != 16 or not parts[1].isdigit() or len(parts[1]) > 20:
            raise InputError("it is not signed")
        session, digits, mac, text = parts
        if not hmac.compare_digest(mac, _mac(self._key, session + b" " + digits, text)):
            raise InputError("its signature is wrong: the keys differ, or it was forged")
        self._count(session, int(digits))
        return text

    def _count(self, session: bytes, counter: int) -> None:
        now = self._now()
        off = (counter - now) / SECOND
        if not abs(off) <= WINDOW:
            raise InputError(f"its time is {off:+.3g} s from ours (at most {WINDOW:g} s): set both clocks")
        if counter <= self._floor:
            raise InputError("it is from before this program began to listen, or our clock went back")
        if counter <= self._counters.get(session, 0):
            raise InputError("it was here before, or came after a later one")
        self._counters[session] = counter
        # What a session says that was silent for so long is too old; should this clock go back, it stays so.
        silent = {each: last for each, last in self._counters.items() if now - last > WINDOW * SECOND}
        self._floor = max(self._floor, *silent.values()) if silent else self._floor
        self._counters = {each: last for each, last in self._counters.items() if each not in silent}


class Gate:
    """Lets datagrams in that come from an allowed host, and are signed by the key where there is one.

    senders: host names or addresses, looked up once; none: all. What is left out is counted, and said in `note`, but
    moves and stops nothing: else whoever reaches the port could hold the arm up.
    """

    def __init__(self, senders: Collection[str] = (), key: bytes | None = None) -> None:
        self._allowed = {address for host in require_names(senders, "senders") for address in _addresses(host)}
        self._verifier = None if key is None else Verifier(key)
        self._left_out = 0
        self._why = ""

    @property
    def note(self) -> str:
        """How many datagrams were left out until now, and why the last one was; "" where none was."""
        return f"; {self._left_out} datagrams were left out, the last {self._why}" if self._left_out else ""

    def warn_if_open(self, address: tuple[str, int]) -> None:
        """`ExposedPortWarning` where whoever reaches this machine's port may send."""
        if self._open and not _address(address[0]).is_loopback:
            warnings.warn(
                f"whoever reaches {address[0]}:{address[1]} can move the arm: name who may send (senders=, --from), "
                "or give a key (key=, --key)",
                ExposedPortWarning,
                stacklevel=3,
            )

    def admitted(self, arrivals: Iterable[tuple[Hashable, bytes]]) -> Iterable[tuple[Hashable, bytes]]:
        """(sender, text) of the datagrams that count."""
        return arrivals if self._open else self._sifted(arrivals)

    @property
    def _open(self) -> bool:
        return not self._allowed and self._verifier is None

    def _sifted(self, arrivals: Iterable[tuple[Hashable, bytes]]) -> Iterator[tuple[Hashable, bytes]]:
        for sender, datagram in arrivals:
            text = self._admit(sender, datagram)
            if text is not None:
                yield sender, text

    def _admit(self, sender: Any, datagram: bytes) -> bytes | None:
        try:
            return self._checked(sender, datagram)
        except InputError as error:
            self._left_out += 1
            self._why = f"from {named(sender)}: {error}"
            return None

    def _checked(self, sender: Any, datagram: bytes) -> bytes:
        if self._allowed and _address(sender[0]) not in self._allowed:
            raise InputError("it is none of the allowed senders")
        return datagram if self._verifier is None else self._verifier.verified(datagram)


_Address = ipaddress.IPv4Address | ipaddress.IPv6Address


def _address(text: str) -> _Address:
    """An address as the system names it, the zone left out; one of IPv4 within IPv6 as that of IPv4."""
    address = ipaddress.ip_address(text.partition("%")[0])
    mapped = address.ipv4_mapped if isinstance(address, ipaddress.IPv6Address) else None
    return mapped or address


def _addresses(host: str) -> set[_Address]:
    try:
        return {_address(str(found[4][0])) for found in socket.getaddrinfo(host, None)}
    except (OSError, UnicodeError, TypeError, ValueError) as error:
        raise InputError(f"no host {host!r} that may send: {error}") from error


def _mac(key: bytes, head: bytes, text: bytes) -> bytes:
    return hmac.digest(key, head + b" " + text, "sha256").hex().encode()
