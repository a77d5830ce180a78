"""Keys typed at the terminal while a command runs, without Enter."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

AT_ONCE = 64
"""The most bytes to read between two cycles."""


@contextmanager
def typed_keys() -> Iterator[Callable[[], str] | None]:
    """A function that returns the keys typed since its last call, without waiting.

    None if stdin is no terminal, or belongs to another program in the foreground. The terminal is restored at the end.
    Ctrl-C still works.
    """
    try:
        terminal = sys.stdin.fileno()
        before = termios.tcgetattr(terminal) if _is_ours(terminal) else None
    except (AttributeError, OSError, ValueError, termios.error):
        before = None
    if before is None:
        yield None
        return
    tty.setcbreak(terminal)
    try:
        yield lambda: _waiting(terminal)
    finally:
        with suppress(termios.error):  # it is gone
            termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _is_ours(terminal: int) -> bool:
    """Whether it is a terminal with this program in the foreground. Otherwise a read would stop the program."""
    return os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp()


def _waiting(terminal: int) -> str:
    with suppress(OSError, ValueError):
        if _is_ours(terminal) and select.select([terminal], [], [], 0.0)[0]:
            return os.read(terminal, AT_ONCE).decode("utf-8", "replace")
    return ""
