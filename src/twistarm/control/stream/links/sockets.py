"""UDP sockets that never wait: open, drain, close."""

from __future__ import annotations

import errno
import os
import socket
from collections.abc import Collection, Hashable, Iterator
from typing import Any

from ....support.checks import require, require_names
from ....support.closeable import Closeable
from ....support.errors import InputError, listed, shown
from ....support.strict_json import LARGEST_MESSAGE
from .signing import Verifier

BUFFER = 128 * 1024
"""Bytes that the system keeps for us, twice that by its own count: one message of the largest size, or some 350 small
ones. A larger buffer would only hand out older messages in a flood."""

MOST_PER_CYCLE = 512
"""Datagrams read in one cycle, about a millisecond's work: more than the buffer holds."""


class Socket(Closeable):
    """A UDP socket that does not wait, a context manager."""

    def __init__(self, family: socket.AddressFamily) -> None:
        self.socket = socket.socket(family, socket.SOCK_DGRAM)
        self.socket.setblocking(False)

    @property
    def address(self) -> tuple[str, int]:
        """Its own host and port."""
        host, port = self.socket.getsockname()[:2]
        return str(host), int(port)

    def close(self) -> None:
        """Give the port back. Harmless when repeated."""
        self.socket.close()


class Receiver(Socket):
    """A socket bound to host and port (0: a free one), for datagrams of `senders`, signed by `key` if given.

    senders: hosts, empty for all. `note` counts the dropped datagrams and gives the last reason; "" for none. Raises
    InputError for an unusable host or port, and for an invalid key.
    """

    def __init__(self, host: str, port: int, senders: Collection[str] = (), key: bytes | None = None) -> None:
        self._allowed = _addresses(require_names(senders, "senders"))
        self._verifier = None if key is None else Verifier(key)
        self.note, self._left_out = "", 0
        family, address = _resolved(host, port, smallest=0)
        super().__init__(family)
        try:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
            self.socket.bind(address)
        except OSError as error:
            self.close()
            raise InputError(f"cannot listen on {host}:{port}: {error.strerror or error}") from error

    def sender_name(self, sender: Any) -> str:
        """The sender's address in words."""
        return named(sender)

    def arrivals(self) -> Iterator[tuple[Hashable, bytes]]:
        """(sender's address, text) of the datagrams that count. Others move nothing and stop nothing."""
        for sender, datagram in self.waiting():
            text = self._text(sender, datagram)
            if text is not None:
                yield sender, text

    def _text(self, sender: Any, datagram: bytes) -> bytes | None:
        try:
            if self._allowed and sender[0].partition("%")[0].removeprefix("::ffff:") not in self._allowed:
                raise InputError("it is not an allowed sender")
            return datagram if self._verifier is None else self._verifier.verified(datagram)
        except InputError as error:
            self._left_out += 1
            self.note = f"; {self._left_out} datagrams were left out, the last from {named(sender)}: {error}"
            return None

    def waiting(self) -> Iterator[tuple[Any, bytes]]:
        """What has arrived, as (sender's address, datagram), at most `MOST_PER_CYCLE` of them."""
        for _ in range(MOST_PER_CYCLE):
            try:
                # One byte more than a message may have, so that what is too long is seen to be.
                datagram, sender = self.socket.recvfrom(LARGEST_MESSAGE + 1)
            except BlockingIOError:
                return
            yield sender, datagram


class Sender(Socket):
    """A socket that sends to host and port. Raises InputError where there is no way to it."""

    def __init__(self, host: str, port: int) -> None:
        family, address = _resolved(host, port, smallest=1)
        super().__init__(family)
        self.receiver = named((host, port))
        try:
            # Connected, so that the system says when nobody listens there.
            self.socket.connect(address)
        except OSError as error:
            self.close()
            raise InputError(f"cannot send to {host}:{port}: {error.strerror or error}") from error

    def send(self, datagram: bytes) -> bool:
        """Send one datagram.

        Returns whether a program listens, as far as known. Raises OSError if it cannot send.

        The system reports a refusal at the next call, in place of its result. So it is read before sending, for a new
        listener, and after, for an immediate answer.
        """
        refused = self._refused()
        try:
            self.socket.send(datagram)
        except ConnectionRefusedError:  # an answer that came just now
            return False
        return not (self._refused() or refused)

    def _refused(self) -> bool:
        error = self.socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if error not in (0, errno.ECONNREFUSED):
            raise OSError(error, os.strerror(error))
        return error != 0


def named(address: Any) -> str:
    """`127.0.0.1:5005`, `[::1]:5005`."""
    host, port = address[:2]
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"


def _resolved(host: str, port: int, smallest: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    require(host, str, "host", "such as '127.0.0.1', with the port beside it")
    if not isinstance(port, int) or isinstance(port, bool) or not smallest <= port <= 65535:
        raise InputError(f"a port is a whole number from {smallest} to 65535; got {shown(port)}")
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError, ValueError) as error:
        raise InputError(f"no host {host!r}: {error}") from error
    return family, (str(address[0]), int(address[1]))


def _addresses(hosts: Collection[str]) -> set[str]:
    """Every address of these hosts, the zone left out."""
    try:
        found = [each for host in hosts for each in socket.getaddrinfo(host, None)]
    except (OSError, UnicodeError) as error:
        raise InputError(f"no such host among those that may send, {listed(hosts)}: {error}") from error
    return {str(address[0]).partition("%")[0] for *_, address in found}
