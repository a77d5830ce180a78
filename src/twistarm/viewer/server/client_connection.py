"""One connection to the view, and whose turn it is to leave where there are too many."""

from __future__ import annotations

import asyncio
import ipaddress
import socket
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable
from typing import Any, Protocol, TypeVar

from tornado.iostream import IOStream

LARGEST_HEAD = 16 * 1024
"""Bytes of a request's head, and read of a stranger at once: cookies of all that this machine serves may be in it."""

CHUNK = 2 * 1024
"""Bytes read of all others of one computer in a turn of the loop: some three hundred frames at the worst."""

SLICE = 0.001
"""Seconds of a turn for what one computer asks for."""

STRANGER_TIME = 10.0
"""Seconds within which the token must have been shown: a browser sends it with its first packet."""

STALL_TIME = 20.0
"""Seconds for which an answer may wait without one byte of it being taken."""

ANSWER_TIME = 300.0
"""Seconds that one request and its answer may take: 20 MB at half a megabit a second."""


class OnceInATurn:
    """True when first asked in a turn of the loop."""

    def __init__(self) -> None:
        self._asked = False

    def __call__(self) -> bool:
        """Called by whoever would do the one thing."""
        if self._asked:
            return False
        self._asked = True
        asyncio.get_running_loop().call_soon(self._begin_anew)
        return True

    def _begin_anew(self) -> None:
        self._asked = False


class Peer:
    """A computer at the other end, whose pages share what it gets of a turn of the loop; `files` are made for it."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.files = 0
        self._turn = asyncio.Lock()
        self.may_read = OnceInATurn()
        self._spent = 0.0

    def spend(self, seconds: float) -> Awaitable[None] | None:
        """So long was something done for it; what it has to wait for before the next thing, if its time is up."""
        self._spent += seconds
        return None if self._spent <= SLICE else self.rest()

    async def rest(self) -> None:
        """Let the others have their turn; of its own pages one goes on in each."""
        async with self._turn:
            self._spent = 0.0
            await asyncio.sleep(0)


class HasPeer(Protocol):
    """What belongs to a peer."""

    @property
    def peer(self) -> Peer:
        """Which computer."""


Guest = TypeVar("Guest", bound=HasPeer)


class ClientConnection(IOStream):
    """A connection of `peer`: a stranger until it has shown the token (`known`), then perhaps a `page`'s socket."""

    def __init__(
        self, connection: socket.socket, peer: Peer, ports: tuple[int, int], left: Callable[[ClientConnection], None]
    ) -> None:
        """ports: the peer's and ours. left: told once it is closed."""
        super().__init__(connection, read_chunk_size=LARGEST_HEAD + 1)  # too large a head is seen at once
        self.peer, self.ports = peer, ports
        self.known = self.page = False
        self._left = left
        self._may_read = OnceInATurn()
        self._asked = self._moved = self._now()

    def welcome(self) -> None:
        """It has shown the token, with a request that begins now."""
        self.known = True
        self.read_chunk_size, self._may_read = CHUNK, self.peer.may_read
        self._asked = self._now()

    @staticmethod
    def _now() -> float:
        return asyncio.get_running_loop().time()

    def is_overdue(self) -> bool:
        """Whether it has been waited for long enough."""
        now = self._now()
        if self.writing() and now - self._moved > STALL_TIME:
            return True
        return not self.page and now - self._asked > (ANSWER_TIME if self.known else STRANGER_TIME)

    def read_from_fd(self, buf: Any) -> int | None:
        """At most once in a turn of the loop: whoever sends without end would be the only one to be heard."""
        return super().read_from_fd(buf) if self._may_read() else None

    def read_until_regex(self, regex: bytes, max_bytes: int | None = None) -> Awaitable[bytes]:
        """A request's head, as tornado asks for it; its end is looked for as browsers write it, a hundred times faster.

        Whoever sends much without that end costs little.
        """
        return self.read_until(b"\r\n\r\n", max_bytes)

    def write_to_fd(self, data: memoryview) -> int:
        """Notes that something was taken."""
        written = super().write_to_fd(data)
        if written:
            self._moved = self._now()
        return written

    def close_fd(self) -> None:
        """Tells whoever let it in."""
        super().close_fd()
        self._left(self)


def name_of(address: tuple[Any, ...]) -> str:
    """Of the computer at the other end: its address, of IPv6 the first half, as it may choose the second."""
    host = str(address[0]).partition("%")[0]
    if ":" not in host or host == "::1":
        return host
    return str(ipaddress.ip_network(f"{host}/64", strict=False))


def first_to_leave(guests: Iterable[Guest]) -> Guest:
    """Of the peer that has the most guests, the first; there must be one."""
    present = list(guests)
    counts = Counter(each.peer for each in present)
    return max(present, key=lambda each: counts[each.peer])
