"""Addresses for a browser's command line, which every user of this computer can read: good once, for a short while."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from .authentication import TOKEN, new_token

LIFETIME = 120.0
"""Seconds that a one-time address is good: a browser may take a while to start."""

MOST = 16
"""One-time addresses remembered: a program that opens browsers without end is told of no more."""

PATH = re.compile(rf"/open/({TOKEN})")

TABLES = ("/proc/net/tcp", "/proc/net/tcp6")
"""Where Linux lists connections, each with the user whose it is."""


USED = "this address is good once, and was used: open the one that the program printed"


class OneTimeAddresses:
    """Paths that stand for the token once; `write` may be called from any thread."""

    def __init__(self) -> None:
        self._ends: dict[str, float] = {}
        self._used: set[str] = set()

    def write(self) -> str:
        """The path of a new one, without the first slash."""
        for old in list(self._ends)[: 1 - MOST]:
            self._used.discard(old)
            del self._ends[old]
        code = new_token()
        self._ends[code] = time.monotonic() + LIFETIME
        return f"open/{code}"

    def refusal(self, path: str, ports: tuple[int, int]) -> str | None:
        """Why `path` does not lead in; empty where it does, this once; None: it is no one-time address.

        ports: the asking side's and ours, of the connection by which it was asked for.
        """
        found = PATH.fullmatch(path)
        if found is None or found[1] not in self._ends:
            return None
        code = found[1]
        if not users_of(ports) <= {os.geteuid(), os.getuid(), 0}:
            return "this address is another user's"
        if code in self._used:
            return USED
        if time.monotonic() > self._ends[code]:
            return f"this address was good for {LIFETIME:g} s: open the one that the program printed"
        self._used.add(code)
        return ""


def users_of(ports: tuple[int, int]) -> set[int]:
    """The users whose a connection with these ports, theirs and ours, may be; none where the system does not tell.

    The addresses are not compared: whatever has the same ports must be ours.
    """
    return {user for theirs, ours, user in _connections() if (theirs, ours) == ports}


def _connections() -> Iterator[tuple[int, int, int]]:
    """Local port, remote port and user of each."""
    for table in TABLES:
        with suppress(OSError):
            for line in Path(table).read_text("ascii").splitlines()[1:]:
                fields = line.split()
                yield int(fields[1].rpartition(":")[2], 16), int(fields[2].rpartition(":")[2], 16), int(fields[7])
