"""Keys typed at the terminal while something runs, one by one and without Enter."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

AT_ONCE = 64
"""Bytes taken at once: nobody types faster than that between two cycles."""


@contextmanager
def typed_keys() -> Iterator[Callable[[], str] | None]:
    """A function that returns the keys typed since its last call, without waiting.

    It is None if stdin is no terminal or belongs to another program. The terminal is restored, and Ctrl-C still works.
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
    """Whether this program is in the terminal's foreground; reading would stop it otherwise."""
    return os.isatty(terminal) and os.tcgetpgrp(terminal) == os.getpgrp()


def _waiting(terminal: int) -> str:
    with suppress(OSError, ValueError):
        if _is_ours(terminal) and select.select([terminal], [], [], 0.0)[0]:
            return os.read(terminal, AT_ONCE).decode("utf-8", "replace")
    return ""
