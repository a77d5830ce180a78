"""Log lines of the server for the terminal: one of each kind, counted; nobody waits until it is read."""

from __future__ import annotations

import logging
import os
import select
import sys
import threading
from contextlib import suppress
from types import TracebackType

from ...support.errors import one_line

LOGGERS = ("tornado.access", "tornado.application", "tornado.general", "asyncio")
"""By which what serves would speak for itself, with a traceback each time."""

MOST_KINDS = 20
AT_ONCE = 512
"""Bytes that a pipe takes at once, by POSIX, if it takes anything."""

LONGEST = 400
"""Characters of a line: most lines are as many bytes."""


class ServerLog(logging.Filter):
    """Says the first, the tenth, the hundredth … of each kind: a flood makes a handful of lines.

    A context manager, within which what the libraries log from this thread is counted as one of them.
    """

    def __init__(self, who: str) -> None:
        super().__init__()
        self.counts: dict[str, int] = {}
        self._who = who
        self._thread = 0

    def __enter__(self) -> ServerLog:
        self._thread = threading.get_ident()
        for name in LOGGERS:
            logging.getLogger(name).addFilter(self)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for name in LOGGERS:
            logging.getLogger(name).removeFilter(self)

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the record is another thread's, and no affair of ours."""
        if record.thread != self._thread:
            return True
        if record.levelno >= logging.WARNING:
            error = record.exc_info[1] if record.exc_info else None
            words = record.getMessage() if error is None else f"{type(error).__name__}: {error}"
            self.say(str(record.msg) if error is None else type(error).__name__, words)
        return False

    def say(self, kind: str, words: str) -> None:
        """Count one more of its kind, and say so where the count is 1, 10, 100 …"""
        if kind not in self.counts and len(self.counts) >= MOST_KINDS:
            kind = "others"
        count = self.counts[kind] = self.counts.get(kind, 0) + 1
        if set(str(count)[1:]) <= {"0"} and str(count)[0] == "1":
            times = f" ({count:,} times by now)" if count > 1 else ""
            write_at_once(one_line(f"{self._who}: {words}", LONGEST - len(times)) + times)


def write_at_once(line: str) -> None:
    """Write a line to stderr if that takes it without a wait; where nobody reads, it is dropped."""
    with suppress(Exception):  # there may be no stderr, or one that is closed: nothing is worth an end
        try:
            number = sys.stderr.fileno()
        except OSError:  # a stand-in without a file, as notebooks have
            sys.stderr.write(line + "\n")
            return
        if select.select([], [number], [], 0)[1]:
            os.write(number, line.encode("utf-8", "replace")[: AT_ONCE - 1] + b"\n")
